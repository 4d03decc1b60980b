// What a run reports while it goes; see report.hpp. Called by the loop in run.cpp.
#include "solver/results/report.hpp"

#include "solver/discrete/fields_read.hpp"
#include "solver/formulation/reduce.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/plan/result_files.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

Reporter::Reporter(const Plan& plan, const Discretisation& d, const RunState& run,
                   const RunSettings& settings, Shown* shown)
    : plan_(plan), discretisation_(d), contact_(run.contact()), name_(settings.name),
      folder_(settings.output_folder), probes_(plan.problem, plan.report.probes, d, run),
      tables_read_(plan.problem, plan.report.probes, d, run), files_(settings.warn),
      tables_(plan.report, name_, folder_), pictures_(plan, d, contact_, shown),
      range_(plan.problem.law_terms.size()), found_(found_effects(plan.problem, d, run)) {
  every_value_ = settings.every_value;
  prepare_fields(run, settings);
  const int n_fields = count_fields(plan.problem);
  for (const auto& probe : plan.report.probes)
    rows_read_interior_ = rows_read_interior_ || reads_interior(probe, n_fields);
  run.formulation->observe(probes_.dofs_read());
  values_.assign(plan.report.probes.size(), std::nan(""));
}

void Reporter::prepare_fields(const RunState& run, const RunSettings& settings) {
  // What a checkpoint counts on is on the disk before it is.
  const auto durability = settings.checkpoint_every > 0 ? Durability::synced : Durability::ordinary;
  // A run that does not iterate has nothing to do for the others.
  const int processes = run.formulation->operators().iterative ? settings.processes : 1;
  auto expressions = probes_.expressions();
  const auto add = [&](const std::vector<Expr>& more) {
    expressions.insert(expressions.end(), more.begin(), more.end());
  };
  for (std::size_t i = 0; !folder_.empty() && i < plan_.report.fields.size(); ++i) {
    const auto& spec = plan_.report.fields[i];
    fields_.push_back({std::max(spec.every, 1), spec.from_start,
                       FieldFiles(plan_.problem, discretisation_, contact_, spec,
                                  {plan_.report.unit_of_time, plan_.report.unit_of_length}, folder_,
                                  fields_stem(plan_.report, i, name_), durability, processes)});
    add(fields_.back().files.expressions());
  }
  add(pictures_.expressions());
  const auto needed = fields_read(expressions, count_fields(plan_.problem));
  now_ = Snapshot(needed, discretisation_.space.n_dofs(), contact_.n_rows());
  keeps_before_ = probes_.any_timed() || probes_.look_back() || pictures_.timed();
  if (!keeps_before_) return;
  before_ = between_ = now_;
  before_.take(run);
}

void Reporter::record(const RunState& run, bool last) {
  const int step = run.evolution.step();
  if (step == last_recorded_) {
    if (last && !ended_) now_.take(run, true); // a run that ends early: its errors are those here
    return;
  }
  range_.note(run);
  const bool row = tables_.due(step, last);
  const bool any_fields = std::ranges::any_of(
      fields_, [&](const FieldSeries& series) { return is_due(series.every, step, last); });
  const bool shows = pictures_.keeps(step, last);
  const bool whole = any_fields || shows || last || ((row || every_value_) && rows_read_interior_);
  const bool reads = row || last || every_value_;
  if (reads || whole || keeps_before_) now_.take(run, whole);
  if (keeps_before_) read_between_steps(run);
  if (reads) {
    probes_.evaluate(now_, before_, values_);
    tables_read_.refuse_outside(now_, before_, values_);
  }
  if (row || last) add_row(run);
  for (FieldSeries& series : fields_)
    if (is_due(series.every, step, last)) write_fields(series);
  if (last) pictures_.take_at_end(now_);
  if (shows) pictures_.keep(now_, run, last);
  if (keeps_before_) before_ = now_;
  ended_ = last;
  last_recorded_ = step;
}

void Reporter::add_row(const RunState& run) {
  tables_.add_row(run.evolution.step(), run.evolution.t(), values_);
}

void Reporter::write_fields(FieldSeries& series) {
  files_.attempt([&] { series.files.write(now_, files_.names()); });
}

void Reporter::begin(const RunState& run) {
  balance_at_start_ = run.solver.equations.laws.start_known();
  if (keeps_before_) {
    start_ = before_;
    start_.take_start(run, plan_.problem, discretisation_.space);
  }
  const bool row = tables_.from_start();
  if (!row && std::ranges::none_of(fields_, &FieldSeries::from_start)) return;
  now_.take_start(run, plan_.problem, discretisation_.space);
  if (row) {
    probes_.evaluate_start(now_, balance_at_start_, values_);
    tables_read_.refuse_outside(now_, now_, values_);
    add_row(run);
  }
  for (FieldSeries& series : fields_)
    if (series.from_start) write_fields(series);
}

/// Probes and pictures at times between grid times read u_tau (affine) or bar u_tau (constant) of
/// the paper.
void Reporter::read_between_steps(const RunState& run) {
  const double from = before_.t(), to = now_.t();
  const bool first = run.evolution.step() == 1;
  const auto share_at = [&](double at) {
    const bool constant = plan_.problem.time.interpolant == Interpolant::constant && at > from;
    return constant ? 1.0 : (at - from) / (to - from);
  };
  const auto state_at = [&](double at) -> const Snapshot& {
    between_.interpolate(first ? start_ : before_, now_, share_at(at));
    return between_;
  };
  for (const int i : probes_.timed(from, to, first)) {
    const double at = *plan_.report.probes[i].time;
    if (probes_.of_steps(i)) {
      values_[i] = of_steps_at(i, share_at(at));
      continue;
    }
    values_[i] = probes_.value(i, state_at(at), before_);
    tables_read_.refuse_outside(i, between_, before_, values_);
  }
  pictures_.take_between(from, to, first, state_at);
}

/// What holds for a step is affine between the ends of two; where it is of the step as a whole, and
/// in a first step without a balance of forces at its start, it is that of the step.
double Reporter::of_steps_at(int i, double share) {
  const bool first = now_.step() == 1;
  const bool known_before = !probes_.look_back() && (!first || balance_at_start_);
  if (share == 0.0 && first && !known_before) return std::nan("");
  const double now = probes_.value(i, now_, before_);
  if (share == 1.0 || !known_before) return now;
  return (1.0 - share) * probes_.value(i, before_, before_) + share * now;
}

void Reporter::finish(RunResult& result) {
  pictures_.finish(ended_ ? &now_ : nullptr, result);
  for (std::size_t i = 0; i < values_.size(); ++i) // parts of other probes have no name
    if (const auto& name = plan_.report.probes[i].name; !name.empty())
      result.final[name] = values_[i];
  result.effects = effects_of_run(plan_.problem, range_);
  result.effects.insert(result.effects.end(), found_.begin(), found_.end());
  tables_.finish(result, files_);
  if (!folder_.empty()) pictures_.write_lines(folder_, name_, files_);
  for (auto& series : fields_) files_.attempt([&] { series.files.write_collection(); });
  result.files = files_.names();
}

void Reporter::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(values_);
  tables_.save(w);
  range_.save(out);
  w.put(last_recorded_);
  w.put(static_cast<std::uint64_t>(files_.names().size()));
  for (const auto& name : files_.names()) put_text(w, name);
  for (const auto& series : fields_) series.files.save(out);
  pictures_.save(out);
}

void Reporter::restore(std::istream& in, const RunState& run) {
  StateReader r(in, {});
  values_ = r.get_vector<double>(values_.size());
  tables_.restore(r, run.evolution.step());
  range_.restore(in);
  last_recorded_ = r.get_between(0, run.evolution.step());
  files_.names().clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) files_.names().push_back(get_text(r));
  for (auto& series : fields_) series.files.restore(in);
  // A run that is over takes no step that would be shown.
  ended_ = last_recorded_ == run.evolution.grid().steps();
  now_.take(run, ended_);
  pictures_.restore(in, now_);
  if (ended_) pictures_.keep_end(now_, run);
  if (keeps_before_) before_ = now_;
}

} // namespace hvi::solver
