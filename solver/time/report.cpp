// What a run reports while it goes; see report.hpp. Called by the loop in run.cpp.
#include "solver/time/report.hpp"

#include "solver/mesh/mesh.hpp"
#include "solver/output/file.hpp"
#include "solver/time/reduce.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

std::string stem_of(const std::string& file, const std::string& fallback) {
  if (file.empty()) return fallback;
  const std::filesystem::path path(file);
  return (path.parent_path() / path.stem()).string();
}

} // namespace

std::string table_stem(const ReportSpec& report, std::size_t i, const std::string& name) {
  return stem_of(report.tables[i].file, i == 0 ? name : fmt::format("{}_table{}", name, i + 1));
}

std::string fields_stem(const ReportSpec& report, std::size_t i, const std::string& name) {
  return stem_of(report.fields[i].file, i == 0 ? name : fmt::format("{}_fields{}", name, i + 1));
}

bool shows_events(const RunResult& result) {
  return !result.unique && !result.events.empty() && !result.columns.contains(event_column);
}

Reporter::Reporter(const Plan& plan, const Discretisation& d, const RunState& run,
                   const RunSettings& settings, Shown* shown)
    : plan_(plan), discretisation_(d), space_(d.space), contact_(run.contact()),
      folder_(settings.output_folder), writes_(!settings.output_folder.empty()),
      probes_(plan, d, run), range_(plan.problem.law_terms.size()),
      found_(found_effects(plan.problem, d, run)), warn_(settings.warn) {
  if (shown != nullptr) shown_.emplace(plan, d, contact_, *shown);
  prepare_tables(settings.name);
  prepare_fields(d, run, settings);
  const int n_fields = count_fields(plan.problem);
  for (const auto& probe : plan.report.probes)
    rows_read_interior_ = rows_read_interior_ || reads_interior(probe, n_fields);
  run.formulation->observe(probes_.dofs_read());
  values_.assign(plan.report.probes.size(), std::nan(""));
  pictures_.resize(plan.report.pictures.size());
  name_ = settings.name;
  std::size_t places = 0;
  for (const auto& line : plan.report.lines) places += static_cast<std::size_t>(line.points);
  const CellLocator locator(d.mesh, places);
  for (const auto& line : plan.report.lines)
    lines_.emplace_back(line, plan.problem, d, contact_, locator);
  columns_.resize(values_.size());
}

void Reporter::prepare_tables(const std::string& name) {
  for (std::size_t i = 0; i < plan_.report.tables.size(); ++i) {
    const auto& spec = plan_.report.tables[i];
    tables_.push_back({spec.probes, std::max(spec.every, 1), spec.from_start,
                       table_stem(plan_.report, i, name) + ".csv"});
    base_every_ = std::gcd(base_every_, tables_.back().every);
  }
}

void Reporter::prepare_fields(const Discretisation& d, const RunState& run,
                              const RunSettings& settings) {
  // What a checkpoint counts on is on the disk before it is.
  const auto durability = settings.checkpoint_every > 0 ? Durability::synced : Durability::ordinary;
  auto expressions = probes_.expressions();
  for (std::size_t i = 0; writes_ && i < plan_.report.fields.size(); ++i) {
    const auto& spec = plan_.report.fields[i];
    fields_.push_back({std::max(spec.every, 1), spec.from_start,
                       FieldFiles(plan_.problem, d, contact_, spec,
                                  {plan_.report.unit_of_time, plan_.report.unit_of_length}, folder_,
                                  fields_stem(plan_.report, i, settings.name), durability)});
    const auto more = fields_.back().files.expressions();
    expressions.insert(expressions.end(), more.begin(), more.end());
  }
  const auto timed = [](const auto& spec) { return spec.time.has_value(); };
  const bool timed_pictures = std::ranges::any_of(plan_.report.pictures, timed) ||
                              std::ranges::any_of(plan_.report.lines, timed);
  for (const auto& picture : plan_.report.pictures) {
    expressions.push_back(Expr::variable(slot::field(field_of_u(0), slot::value(0))));
    const auto& shown = picture.field.components;
    expressions.insert(expressions.end(), shown.begin(), shown.end());
  }
  for (const auto& line : plan_.report.lines)
    for (const auto& field : line.fields)
      expressions.insert(expressions.end(), field.components.begin(), field.components.end());
  if (shown_)
    for (const Expr& e : shown_->expressions()) expressions.push_back(e);
  const int n_fields = count_fields(plan_.problem);
  const auto needed = fields_read(expressions, n_fields);
  now_ = Snapshot(needed, d.space.n_dofs(), contact_.n_rows());
  keeps_before_ = probes_.any_timed() || probes_.look_back() || timed_pictures;
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
  const bool row = base_every_ > 0 && due(base_every_, step, last);
  const bool any_fields = std::ranges::any_of(
      fields_, [&](const FieldSeries& series) { return due(series.every, step, last); });
  const bool shows = shown_ && shown_->keeps(step, last);
  const bool whole = any_fields || shows || last || (row && rows_read_interior_);
  if (row || whole || keeps_before_) now_.take(run, whole);
  if (keeps_before_) read_between_steps(run);
  if (row || last) {
    probes_.evaluate(now_, before_, values_);
    add_row(run);
  }
  for (FieldSeries& series : fields_)
    if (due(series.every, step, last)) attempt([&] { series.files.write(now_, written_); });
  if (last) show_at_end();
  if (shows) shown_->keep(now_, run, last);
  if (keeps_before_) before_ = now_;
  ended_ = last;
  last_recorded_ = step;
}

void Reporter::add_row(const RunState& run) {
  rows_.push_back(run.evolution.step());
  times_.push_back(run.evolution.t());
  events_.push_back(std::exchange(pending_events_, 0));
  for (std::size_t i = 0; i < values_.size(); ++i) columns_[i].push_back(values_[i]);
}

void Reporter::begin(const RunState& run) {
  const auto wanted = [](const auto& item) { return item.from_start; };
  const bool row = std::ranges::any_of(tables_, wanted);
  if (!row && std::ranges::none_of(fields_, wanted)) return;
  now_.take_start(run, in_motion(plan_.problem));
  if (row) {
    const bool balance = run.solver.equations.laws.start_known();
    probes_.evaluate_start(now_, balance, values_);
    add_row(run);
  }
  for (FieldSeries& series : fields_)
    if (series.from_start) attempt([&] { series.files.write(now_, written_); });
}

void Reporter::mark(const StepResult& outcome) {
  if (outcome.inequality.events > 0)
    pending_events_ = std::max(pending_events_, 0) + outcome.inequality.events;
  else if (outcome.snap && pending_events_ == 0)
    pending_events_ = -1;
}

/// Probes and pictures at times between grid times read u_tau (affine) or bar u_tau (constant) of
/// the paper.
void Reporter::read_between_steps(const RunState& run) {
  const double from = before_.t(), to = now_.t();
  const bool first = run.evolution.step() == 1;
  const auto go_to = [&](double at) {
    const bool constant = plan_.problem.time.interpolant == Interpolant::constant && at > from;
    between_.interpolate(before_, now_, constant ? 1.0 : (at - from) / (to - from));
  };
  for (const int i : probes_.timed(from, to, first)) {
    const double at = *plan_.report.probes[i].time;
    if (probes_.of_steps(i)) {
      read_of_steps(i, first ? 1.0 : (at - from) / (to - from));
      continue;
    }
    go_to(at);
    values_[i] = probes_.value(i, between_, before_);
  }
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const auto& at = plan_.report.pictures[i].time;
    if (!at || *at > to || *at < from || (*at == from && !first)) continue;
    go_to(*at);
    show(i, between_);
    if (shown_) shown_->take(i, between_);
  }
  for (LineValues& line : lines_) {
    const auto& at = line.spec().time;
    if (!at || *at > to || *at < from || (*at == from && !first)) continue;
    go_to(*at);
    line.take(contact_, between_);
  }
}

void Reporter::show(std::size_t picture, const Snapshot& snapshot) {
  const auto& spec = plan_.report.pictures[picture];
  const auto& components = spec.field.components;
  const bool at_points = std::ranges::any_of(components, reads_multiplier);
  // Frames have all that is drawn; what lives at points is drawn from them alone.
  if (spec.in_row >= 0 && (shown_ || at_points)) return;
  PictureValues out{snapshot.field(field_of_u(0)), {}};
  if (!at_points)
    out.values = nodal_values(space_, components, snapshot.values());
  else if (StateField::is_one(plan_.problem, contact_, spec.field))
    out.values =
        StateField(plan_.problem, discretisation_, contact_, spec.field).of_nodes(snapshot);
  else
    return;
  pictures_[picture] = std::move(out);
}

/// Pictures and lines without a time.
void Reporter::show_at_end() {
  for (std::size_t i = 0; i < pictures_.size(); ++i)
    if (!plan_.report.pictures[i].time) show(i, now_);
  for (LineValues& line : lines_)
    if (!line.spec().time) line.take(contact_, now_);
}

/// What holds for a step is affine between the ends of two; where it is of the step as a whole,
/// and in the first step, it is that of the step.
void Reporter::read_of_steps(int i, double share) {
  const double now = probes_.value(i, now_, before_);
  const bool of_one = probes_.look_back() || share == 1.0 ||
                      plan_.problem.time.interpolant == Interpolant::constant;
  values_[static_cast<std::size_t>(i)] =
      of_one ? now : (1.0 - share) * probes_.value(i, before_, before_) + share * now;
}

void Reporter::attempt(const std::function<void()>& write) {
  try {
    write();
  } catch (const Failure& failure) {
    if (!concerns_output(failure.kind)) throw;
    if (unwritten_) return;
    unwritten_ = failure;
    if (warn_) warn_(failure.what());
  }
}

void Reporter::note_written(const std::vector<std::string>& files) {
  written_.insert(written_.end(), files.begin(), files.end());
}

void Reporter::stream(int step, bool with_events) {
  if (!writes_ || tables_.empty()) return;
  constexpr std::chrono::milliseconds pause(100); // shorter runs write their tables once
  const auto now = std::chrono::steady_clock::now();
  if (now - streamed_ < pause) return;
  const auto rows =
      static_cast<std::size_t>(std::upper_bound(rows_.begin(), rows_.end(), step) - rows_.begin());
  for (auto& table : tables_)
    if (rows > table.streamed) attempt([&] { stream_table(table, rows, with_events); });
  streamed_ = now;
}

/// The first time the whole table, then the rows that are new, at the end of the file.
void Reporter::stream_table(TableFile& table, std::size_t rows, bool with_events) {
  const std::size_t first = table.streamed_events == with_events ? table.streamed : 0;
  const ReportTable more = table_rows(table, first, rows, with_events, false);
  table.streamed = 0; // where writing fails
  if (first == 0)
    write_table(folder_, table.file, more);
  else if (const std::string lines = csv_rows(more); !lines.empty())
    append_line(folder_ / table.file, std::string_view(lines).substr(0, lines.size() - 1),
                Durability::ordinary);
  table.streamed = rows;
  table.streamed_events = with_events;
}

ReportTable Reporter::table_rows(const TableFile& table, std::size_t first, std::size_t end,
                                 bool with_events, bool ends) const {
  ReportTable out{{"t"}, {{}}, {plan_.report.unit_of_time}};
  for (const int probe : table.probes) {
    out.names.push_back(plan_.report.probes[probe].name);
    out.units.push_back(plan_.report.probes[probe].unit);
  }
  if (with_events) out.names.emplace_back(event_column);
  out.units.resize(out.names.size());
  out.columns.resize(out.names.size());
  std::int64_t events = 0; // of the rows that this table leaves out, too
  while (first > 0 && !has_row(table, rows_[first - 1], false)) --first; // their events
  for (std::size_t r = first; r < end; ++r) {
    if (events_[r] > 0) events = std::max<std::int64_t>(events, 0) + events_[r];
    if (events_[r] < 0) events = events_[r];
    if (!has_row(table, rows_[r], ends && r + 1 == rows_.size())) continue;
    if (with_events) out.columns.back().push_back(static_cast<double>(std::exchange(events, 0)));
    out.columns[0].push_back(times_[r]);
    for (std::size_t c = 0; c < table.probes.size(); ++c)
      out.columns[c + 1].push_back(columns_[table.probes[c]][r]);
  }
  return out;
}

void Reporter::finish(RunResult& result) {
  std::set<int> shown;
  for (const auto& table : tables_)
    for (const int probe : table.probes)
      if (shown.insert(probe).second)
        result.column_order.push_back(plan_.report.probes[probe].name);
  result.pictures = pictures_;
  if (shown_ && ended_) shown_->finish(now_);
  result.times = times_;
  result.events = events_;
  for (const int probe : shown) result.columns[plan_.report.probes[probe].name] = columns_[probe];
  for (std::size_t i = 0; i < values_.size(); ++i) // parts of other probes have no name
    if (const auto& name = plan_.report.probes[i].name; !name.empty())
      result.final[name] = values_[i];
  result.effects = effects_of_run(plan_.problem, range_);
  result.effects.insert(result.effects.end(), found_.begin(), found_.end());
  const bool with_events = shows_events(result);
  if (writes_ && !rows_.empty())
    for (const auto& table : tables_)
      attempt([&] {
        note_written(write_table(folder_, table.file,
                                 table_rows(table, 0, rows_.size(), with_events, true)));
      });
  for (std::size_t i = 0; writes_ && i < lines_.size(); ++i)
    if (lines_[i].taken())
      attempt([&] {
        ReportTable table = lines_[i].table();
        table.units = line_units(plan_.report, i, space_.mesh->dim);
        note_written(write_table(folder_, line_file(plan_.report, i, name_), table));
      });
  for (auto& series : fields_) attempt([&] { series.files.write_collection(); });
  result.files = written_;
}

} // namespace hvi::solver
