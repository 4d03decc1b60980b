// The run: the time loop over certified steps. Pipeline: plan -> discretise -> run -> results.
//
// The fully discrete scheme (paper, Problem "fullydiscrete"): given u_0, for n = 1, ..., N find u_n
// with
//
//   < A (u_n - u_{n-1})/k + B u_n + sum_m E_m (R_m u)_n, v - u_n > + J^0(M u_n; M v - M u_n)
//                                                       >= < f_n, v - u_n >      for all v
//
//   (R_m u)_n = sum_{j <= n} u_j int_{t_{j-1}}^{t_j} q_m(t_n, s) ds
//
// One step is Stepper::advance (step.hpp); this file repeats it, refuses what has no certificate,
// and keeps the last good state when it has to stop.
#include "solver/time/run.hpp"

#include "solver/common/clock.hpp"
#include "solver/history/horizon.hpp"
#include "solver/output/file.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/energy.hpp"
#include "solver/time/reduce.hpp"
#include "solver/time/report.hpp"
#include "solver/time/saved_state.hpp"
#include "solver/time/shared_work.hpp"
#include "solver/time/step.hpp"
#include "solver/time/trust.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace hvi::solver {
namespace {

/// Displacements smaller than this part of those that the loads alone would cause are rounding.
constexpr double negligible_share = 1e-8;
/// The condition number of a problem that takes less memory than this costs almost nothing.
constexpr double cheap_bytes = 1e5;

/// "3 points released, 1 re-attached (downward jump)".
std::string crossings(const InequalityReport& report) {
  const int back = report.reattached, off = report.events - back;
  std::string out;
  if (off > 0) out = fmt::format("{} points released", off);
  if (back > 0) out += fmt::format("{}{} points re-attached", off > 0 ? ", " : "", back);
  return out + " (downward jump)";
}

constexpr std::string_view not_proved = "least energy found, not proved";

/// With `least_energy`: the state is the best that was found, and what may be below it.
std::string what_is_below(double gap) {
  if (!(gap > proved_least_gap)) return "";
  return std::isfinite(gap)
             ? fmt::format("{}: another state may have less, by up to {:.1e} of the energies "
                           "involved",
                           not_proved, gap)
             : fmt::format("{}: how much less another state may have is not known (vector or "
                           "coupled laws, more than 300 points, forms without symmetry, or laws "
                           "whose curvature is only sampled)",
                           not_proved);
}

/// With `least_energy`: in how many steps that is proved. Each of the others has its note.
void note_proofs(const Plan& plan, RunResult& result) {
  if (plan.options.branch != Branch::least_energy || plan.law_terms.empty()) return;
  const auto open = std::count_if(result.notes.begin(), result.notes.end(), [](const auto& note) {
    return note.what.starts_with(not_proved);
  });
  result.notes.push_back(
      {0, 0.0,
       fmt::format("least energy: proved in {} of {} steps, to {:.0e} of the energies involved",
                   result.steps - open, result.steps, proved_least_gap),
       plan.law_terms.front().origin});
}

/// Releases, ends of branches (with the load they ended at) and snaps; "" for a smooth step.
std::string what_happened(const StepResult& step, int n, const TimeGrid& grid, Branch branch) {
  std::string out;
  if (step.inequality.events > 0) out = crossings(step.inequality);
  const auto& ends = step.branch_ends;
  if (ends.empty()) {
    if (out.empty() && step.snap)
      out = branch == Branch::least_energy
                ? "snap: the state of least energy is beyond unstable states"
                : "snap: the step crossed unstable states and its branch was not followed; smaller "
                  "steps may show another";
    return out;
  }
  const auto place = [&](double part) {
    return grid.is_static() ? fmt::format("{:.6g} of the load", part)
                            : fmt::format("t = {:.6g}", grid.t(n - 1) + part * grid.length(n));
  };
  out += fmt::format("{}snap: the branch ended at {} (a limit point)", out.empty() ? "" : "; ",
                     place(ends.front()));
  if (ends.size() > 1)
    out += fmt::format(", the next ones up to {}, {} in all", place(ends.back()), ends.size());
  return out + "; on with the next stable state of the equilibrium curve at that load";
}

/// Worst numbers over the steps, and the notes.
void note(const StepResult& step, int n, double t, const TimeGrid& grid, const Plan& plan,
          RunResult& result) {
  auto& certificate = result.certificate;
  if (std::max(step.equilibrium, step.inclusion.worst) >
      std::max(certificate.equilibrium, certificate.inclusion))
    certificate.worst_step = n;
  if (step.equilibrium > certificate.equilibrium || n == 1) certificate.equilibrium_step = n;
  if (step.inclusion.worst > certificate.inclusion || n == 1) certificate.inclusion_step = n;
  certificate.equilibrium = std::max(certificate.equilibrium, step.equilibrium);
  certificate.inclusion = std::max(certificate.inclusion, step.inclusion.worst);
  const Origin origin = plan.law_terms.empty() ? Origin{} : plan.law_terms.front().origin;
  if (const auto what = what_happened(step, n, grid, plan.options.branch); !what.empty())
    result.notes.push_back({n, t, what, origin});
  if (const auto what = what_is_below(step.inequality.least_gap); !what.empty())
    result.notes.push_back({n, t, what, origin});
}

/// The law term to blame: of the worst point, else the first.
Origin blamed(const StepResult& step, const Plan& plan, const Contact& contact) {
  if (step.inclusion.worst_term >= 0) return plan.law_terms[step.inclusion.worst_term].origin;
  const int worst = step.inequality.worst_point;
  if (worst >= 0 && worst < static_cast<int>(contact.problem.points.size()))
    return plan.law_terms[contact.problem.points[worst].application].origin;
  return plan.law_terms.empty() ? plan.space.origin : plan.law_terms.front().origin;
}

[[noreturn]] void not_certified(const StepResult& step, int n, const Stepper& stepper,
                                const Plan& plan) {
  const auto& grid = stepper.grid();
  const auto place = grid.is_static() ? std::string("the static problem")
                                      : fmt::format("step {} (t = {:.6g})", n, grid.t(n));
  throw Failure(
      FailureKind::not_certified, blamed(step, plan, stepper.contact()),
      fmt::format("no certified solution at {}: equilibrium error {:.2e}, inclusion error "
                  "{:.2e}, tolerance {:.0e}{}{}",
                  place, step.equilibrium, step.inclusion.worst, plan.options.tolerance,
                  step.inequality.verdict.empty() ? "" : "; ", step.inequality.verdict),
      "a smaller step, or a law that softens less, makes the step's problem convex; "
      "`check` prints the step margin");
}

/// Laws beyond the theorem: that jump down (the run says which solution it follows), or are
/// coupled.
void note_choices(const Plan& plan, const Contact& contact, RunResult& result) {
  for (const auto& term : contact.terms) {
    if (term.n_points() == 0) continue;
    const auto& spec = plan.law_terms[term.points.law_term];
    const auto& law = *contact.laws[spec.law];
    if (law.coupled())
      result.notes.push_back(
          {0, 0.0,
           fmt::format("the bound of `{}` is the multiplier of `{}` (Coulomb): beyond the theory, "
                       "found with it in each step; there may be other solutions",
                       law.spec().name, law.spec().coupled),
           spec.origin});
    if (std::isfinite(
            law.constants(term.points.x[0], plan.time.is_static ? 0.0 : plan.time.grid[0]).m))
      continue;
    result.notes.push_back(
        {0, 0.0,
         fmt::format("`{}` jumps down, so uniqueness is not guaranteed; {}; it is "
                     "reversible: what broke holds again on the way back",
                     law.spec().name, sentence(plan.options.branch)),
         spec.origin});
  }
}

void put_note(StateWriter& w, const StepNote& note) {
  w.put(note.step);
  w.put(note.t);
  put_text(w, note.what);
  w.put(note.origin);
}

StepNote get_note(StateReader& r) {
  StepNote out{};
  out.step = r.get<int>();
  out.t = r.get<double>();
  out.what = get_text(r);
  out.origin = r.get<Origin>();
  return out;
}

/// The counters that grow with the steps.
std::array<int, 9> grown(const WorkCounters& w) {
  return {w.analyses,       w.factorisations, w.sweeps,      w.products,        w.newton,
          w.fallback_steps, w.followed_steps, w.inner_steps, w.unfollowed_steps};
}

/// What audits of the memory have changed so far: the routes, and the notes on them.
struct Restarts {
  std::vector<int> routes;     ///< by history; -1: the plan's own
  bool checks_at_once = false; ///< a check that was put off has failed before
  std::vector<StepNote> notes;

  void save(StateWriter& w) const {
    w.put(routes);
    w.put(static_cast<std::uint64_t>(notes.size()));
    for (const auto& note : notes) put_note(w, note);
  }
  void restore(StateReader& r, std::size_t n_histories) {
    routes = r.get_vector<int>(n_histories);
    for (const int route : routes)
      if (route < -1 || route > static_cast<int>(HistoryRoute::direct)) r.fail("is inconsistent");
    notes.clear();
    for (auto n = r.get<std::uint64_t>(); n > 0; --n) notes.push_back(get_note(r));
  }
  Plan applied(const Plan& plan) const {
    Plan out = plan;
    for (std::size_t m = 0; m < routes.size(); ++m)
      if (routes[m] >= 0) out.histories[m].route = static_cast<HistoryRoute>(routes[m]);
    return out;
  }
};

/// Any error found while reading the state names the file.
template <class Read>
void with_its_name(const std::filesystem::path& file, const Read& read) {
  try {
    read();
  } catch (const HorizonFailure&) {
    throw;
  } catch (const Failure& failure) {
    refuse_checkpoint(file, std::string("does not fit: ") + failure.what());
  }
}

class Run {
public:
  Run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
      const Restarts& restarts, const std::string* saved)
      : plan_(plan), restarts_(restarts), discretisation_(discretisation), settings_(settings),
        start_(cpu_seconds()), spared_(spared()), stepper_(plan, discretisation, result_.timing),
        reporter_(plan, discretisation, stepper_, settings) {
    result_.timing.mesh = discretisation.seconds;
    result_.unknowns = stepper_.formulation().whole_layout().n_unknowns;
    result_.path = stepper_.formulation().obstacle();
    if (result_.path.empty())
      result_.certificate.mode =
          fmt::format("contact rows every step; all rows at outputs, at the last step and at {} "
                      "random steps",
                      random_checks);
    result_.contact_unknowns = static_cast<int>(stepper_.contact().unknowns.size());
    result_.certificate.tolerance = plan.options.tolerance;
    note_choices(plan, stepper_.contact(), result_);
    if (settings.monitors) monitor_.emplace(plan, discretisation, stepper_);
    if (settings.checkpoint_every > 0) fingerprint_ = fingerprint(plan, discretisation.mesh);
    // No output shows a step before the last check: no callback, no file, no checkpoint.
    if (!restarts.checks_at_once && !settings.on_step && settings.checkpoint_every == 0 &&
        saved == nullptr && plan.report.fields.empty() && !settings.monitors)
      stepper_.let_checks_wait();
    if (saved != nullptr) go_on(*saved);
  }

  void march() {
    const int steps = stepper_.grid().steps();
    LapClock<> clock;
    for (int n = stepper_.step() + 1; n <= steps; ++n) {
      if (settings_.stop != nullptr && settings_.stop->load()) {
        if (settings_.checkpoint_every > 0 && stepper_.step() > 0) checkpoint();
        throw Failure(settings_.checkpoint_every > 0 ? FailureKind::suspended
                                                     : FailureKind::interrupted,
                      {}, fmt::format("interrupted before step {}", n));
      }
      step(n);
      clock.charge(result_.timing.steps);
      record(n == steps);
      if (n < steps) reporter_.stream(stepper_.checked_up_to(), !stepper_.not_unique().empty());
      if (settings_.checkpoint_every > 0 && (n == steps || n % settings_.checkpoint_every == 0))
        checkpoint();
      clock.charge(result_.timing.output);
    }
    result_.certificate.certified = true;
  }

  /// Puts everything known so far into the result and writes the tables.
  RunResult conclude() {
    LapClock<> clock;
    stepper_.make_checks();
    clock.charge(result_.timing.steps);
    note_late_errors();
    record(true);
    tell_choice();
    reporter_.finish(result_);
    if (monitor_) finish_monitors();
    reporter_.tell_unwritten(result_);
    clock.charge(result_.timing.output);
    account(result_.work, result_.timing);
    result_.histories = stepper_.evolution().memory().reports();
    result_.steps = stepper_.step();
    note_proofs(plan_, result_);
    result_.u = Vector::Zero(discretisation_.space.n_dofs());
    stepper_.formulation().scatter(stepper_.u(), result_.u);
    if (stepper_.step() > 0) estimate_forward_error();
    const Spared now = spared();
    result_.timing.assembly += now.seconds_assembly - spared_.seconds_assembly;
    result_.timing.total =
        cpu_seconds() - start_ + result_.timing.mesh + now.seconds() - spared_.seconds();
    return std::move(result_);
  }

private:
  Spared spared() const {
    return discretisation_.shared ? discretisation_.shared->spared() : Spared{};
  }

  void step(int n) {
    const auto outcome = stepper_.advance(n);
    if (!outcome.certified) not_certified(outcome, n, stepper_, plan_);
    note(outcome, n, stepper_.t(), stepper_.grid(), plan_, result_);
    reporter_.mark(outcome);
    if (monitor_) {
      monitor_->take(stepper_, outcome);
      monitor_times_.push_back(stepper_.t());
    }
    if (settings_.progress)
      settings_.progress(
          {n, stepper_.grid().steps(), outcome.inequality.iterations, cpu_seconds() - start_});
  }

  /// Of checks that were put off.
  void note_late_errors() {
    auto& certificate = result_.certificate;
    for (const auto& [step, error] : stepper_.late_errors()) {
      if (error > std::max(certificate.equilibrium, certificate.inclusion))
        certificate.worst_step = step;
      if (error > certificate.equilibrium) certificate.equilibrium_step = step;
      certificate.equilibrium = std::max(certificate.equilibrium, error);
    }
  }

  void record(bool last) {
    if (stepper_.step() == 0) return; // nothing certified yet
    reporter_.record(stepper_, last);
    if (!settings_.on_step || stepper_.step() == told_) return;
    told_ = stepper_.step();
    Vector full = Vector::Zero(discretisation_.space.n_dofs());
    stepper_.formulation().scatter(stepper_.u(), full);
    settings_.on_step(told_, stepper_.t(), full, stepper_.xi());
  }

  /// What rounding may have done to the columns.
  void estimate_forward_error() {
    const PhaseClock<> clock(result_.timing.output);
    auto& error = result_.forward_error;
    const auto samples = stepper_.rounding_errors(result_.certificate.equilibrium);
    // Where a body sticks everywhere displacements are rounding of what its loads amount to.
    const Vector& reach = stepper_.contact().reach;
    const double moved = reach.size() > 0 ? reach.lpNorm<Eigen::Infinity>() : 0.0;
    const double nothing = negligible_share * std::max(stepper_.rounding().largest_size(), moved);
    const double size = std::max(stepper_.rounding().largest_size(), nothing);
    double square = 0.0;
    for (const auto& sample : samples)
      square = std::max(square, sample.u.lpNorm<Eigen::Infinity>());
    error.solution = size > 0.0 ? 3.0 * square / size : 0.0;
    error.solution = std::max(error.solution, stepper_.solver().refinement().last_correction());
    error.refined = stepper_.solver().refinement().on();
    error.amplification = stepper_.rounding().amplification();
    error.columns = reporter_.errors(samples, result_.u, {size, nothing});
    if (settings_.condition || error.refined || result_.work.bytes < cheap_bytes)
      error.condition = stepper_.condition();
  }

  /// Where several solutions are possible: that it is so, which branch this is, and its energy.
  void tell_choice() {
    result_.unique = stepper_.not_unique().empty();
    if (stepper_.step() == 0 || result_.unique) return;
    const bool said = std::any_of(result_.notes.begin(), result_.notes.end(),
                                  [](const StepNote& n) { return n.step == 0; });
    if (!said)
      result_.notes.insert(result_.notes.begin(),
                           {0, 0.0,
                            fmt::format("uniqueness is not guaranteed: {}; {}",
                                        stepper_.not_unique(), sentence(plan_.options.branch)),
                            plan_.law_terms.empty() ? Origin{} : plan_.law_terms.front().origin});
    std::optional<EnergyMonitor> own;
    EnergyMonitor& monitor = monitor_ ? *monitor_ : own.emplace(plan_, discretisation_, stepper_);
    if (monitor.has_energy()) result_.energy = monitor.energy(stepper_);
  }

  void finish_monitors() {
    result_.monitors = MonitorTable{monitor_->names(), monitor_times_, monitor_->columns(),
                                    monitor_->balance_error()};
    if (settings_.output_folder.empty() || monitor_times_.empty()) return;
    ReportTable table{{"t"}, {monitor_times_}};
    for (std::size_t c = 0; c < monitor_->names().size(); ++c) {
      table.names.push_back(monitor_->names()[c]);
      table.columns.push_back(monitor_->columns()[c]);
    }
    const auto file = settings_.name + "_monitors.csv";
    reporter_.attempt([&] {
      write_atomically(std::filesystem::path(settings_.output_folder) / file, csv_text(table));
      result_.files.push_back(file);
    });
  }

  void account(WorkCounters& work, Timing& timing) const {
    stepper_.account(work, timing);
    int* const all[] = {&work.analyses,       &work.factorisations, &work.sweeps,
                        &work.products,       &work.newton,         &work.fallback_steps,
                        &work.followed_steps, &work.inner_steps,    &work.unfollowed_steps};
    for (std::size_t i = 0; i < grown_before_.size(); ++i) *all[i] += grown_before_[i];
  }

  void go_on(const std::string& saved) {
    std::istringstream in(saved);
    with_its_name(checkpoint_path(settings_.output_folder, settings_.name), [&] { restore(in); });
  }

  void checkpoint() {
    std::ostringstream out;
    out.exceptions(std::ios::badbit); // memory that runs out is no shorter state
    StateWriter w(out);
    restarts_.save(w);
    w.put(static_cast<std::uint8_t>(monitor_.has_value()));
    stepper_.save(out);
    reporter_.save(out);
    w.put(result_.certificate.inclusion);
    w.put(result_.certificate.equilibrium);
    w.put(std::array<int, 3>{result_.certificate.worst_step, result_.certificate.inclusion_step,
                             result_.certificate.equilibrium_step});
    w.put(static_cast<std::uint64_t>(result_.notes.size()));
    for (const auto& note : result_.notes) put_note(w, note);
    WorkCounters work;
    Timing timing;
    account(work, timing);
    w.put(grown(work));
    if (monitor_) {
      w.put(monitor_times_);
      monitor_->save(out);
    }
    reporter_.attempt([&] {
      write_checkpoint(checkpoint_path(settings_.output_folder, settings_.name), fingerprint_,
                       out.view());
    });
  }

  void restore(std::istream& in) {
    StateReader r(in, {});
    Restarts().restore(r, plan_.histories.size()); // read before: they decide the plan
    if ((r.get<std::uint8_t>() != 0) != monitor_.has_value())
      r.fail(monitor_ ? "was saved without monitors" : "was saved with monitors");
    stepper_.restore(in);
    reporter_.restore(in, stepper_);
    result_.certificate.inclusion = r.get<double>();
    result_.certificate.equilibrium = r.get<double>();
    const auto worst = r.get_counts<3>();
    result_.certificate.worst_step = worst[0];
    result_.certificate.inclusion_step = worst[1];
    result_.certificate.equilibrium_step = worst[2];
    result_.notes.clear();
    for (auto n = r.get<std::uint64_t>(); n > 0; --n) result_.notes.push_back(get_note(r));
    // Work counted from here on is added to the work before the checkpoint.
    WorkCounters now;
    Timing timing;
    stepper_.account(now, timing);
    const auto saved = r.get_counts<9>(), here = grown(now);
    for (std::size_t i = 0; i < saved.size(); ++i) grown_before_[i] = saved[i] - here[i];
    if (monitor_) {
      monitor_times_ = r.get_vector<double>();
      monitor_->restore(in, monitor_times_.size());
    }
    told_ = result_.resumed_from = stepper_.step();
  }

  const Plan& plan_;
  const Restarts& restarts_;
  const Discretisation& discretisation_;
  const RunSettings& settings_;
  double start_;
  Spared spared_; ///< by earlier runs' work, when this one began
  int told_ = 0;
  RunResult result_;
  Stepper stepper_;
  Reporter reporter_;
  std::optional<EnergyMonitor> monitor_;
  std::vector<double> monitor_times_;
  std::uint64_t fingerprint_ = 0;
  std::array<int, 9> grown_before_{};
};

RunResult run_once(const Plan& plan, const Discretisation& discretisation,
                   const RunSettings& settings, const Restarts& restarts, const std::string* saved,
                   RunResult* partial) {
  Run run(plan, discretisation, settings, restarts, saved);
  try {
    run.march();
  } catch (const MemoryMistrust&) {
    throw; // nothing that was computed with it is a result
  } catch (const HorizonFailure&) {
    throw; // begun again
  } catch (const LateCheck&) {
    throw; // begun again
  } catch (const Failure&) {
    try {
      auto so_far = run.conclude(); // writes the last good state before the failure is reported
      if (partial != nullptr) *partial = std::move(so_far);
    } catch (const LateCheck&) {
      throw;                   // begun again: a step before failed already
    } catch (const Failure&) { // the reason to stop comes before a disk that is full as well
    }
    throw;
  }
  auto result = run.conclude();
  try {
    refuse_rounding(result, plan);
  } catch (const Failure&) {
    result.certificate.certified = false;
    if (partial != nullptr) *partial = std::move(result);
    throw;
  }
  return result;
}

/// The state to resume from, if that was requested and there is one.
std::optional<std::string> saved_state(const Plan& plan, const Discretisation& discretisation,
                                       const RunSettings& settings) {
  if (settings.checkpoint_every == 0 && !settings.resume) return std::nullopt;
  if (settings.output_folder.empty())
    throw Failure(FailureKind::bad_value, {}, "a checkpoint needs an output folder");
  const auto file = checkpoint_path(settings.output_folder, settings.name);
  remove_leftovers(file.parent_path());
  if (!settings.resume || !std::filesystem::exists(file)) return std::nullopt;
  return read_checkpoint(file, fingerprint(plan, discretisation.mesh));
}

} // namespace

/// A memory that an audit finds outside its tolerance makes the run start again with another route;
/// the direct sum is the last. One that was made for an earlier end and cannot go on beyond it
/// makes the run start again for the later one.
RunResult run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
              RunResult* partial) {
  Restarts restarts;
  restarts.routes.assign(plan.histories.size(), -1);
  std::optional<std::string> saved = saved_state(plan, discretisation, settings);
  if (saved) {
    std::istringstream in(*saved);
    StateReader r(in, {});
    with_its_name(checkpoint_path(settings.output_folder, settings.name),
                  [&] { restarts.restore(r, plan.histories.size()); });
  }
  for (;;) {
    const Plan tried = restarts.applied(plan);
    try {
      auto result =
          run_once(tried, discretisation, settings, restarts, saved ? &*saved : nullptr, partial);
      for (const auto& sentence : route_notes(plan, result.histories))
        if (restarts.notes.empty()) result.notes.push_back({0, 0.0, sentence, Origin{}});
      result.notes.insert(result.notes.begin(), restarts.notes.begin(), restarts.notes.end());
      return result;
    } catch (const MemoryMistrust& mistrust) {
      restarts.notes.push_back({0, 0.0, mistrust.said, mistrust.origin});
      restarts.routes[mistrust.history] = static_cast<int>(mistrust.next);
      saved.reset();
    } catch (const LateCheck&) {
      restarts.checks_at_once = true;
    } catch (const HorizonFailure& failure) {
      if (!saved) throw;
      restarts.notes.push_back({0, 0.0,
                                std::string(failure.what()) + ": started again from the first step",
                                failure.origin});
      saved.reset();
    }
  }
}

} // namespace hvi::solver
