// See one_run.hpp.
#include "solver/time/one_run.hpp"

#include "solver/formulation/reduce.hpp"
#include "solver/output/file.hpp"
#include "solver/time/step_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

namespace hvi::solver {
namespace {

/// Displacements smaller than this part of those that the loads alone would cause are rounding.
constexpr double negligible_share = 1e-8;
/// The condition number of a problem that takes less memory than this costs almost nothing.
constexpr double cheap_bytes = 1e5;

/// Unknowns that laws act on: iterations keep the others, too.
int touched_by_laws(const Contact& contact) {
  if (!contact.whole) return static_cast<int>(contact.unknowns.size());
  const SparseMatrix& force = contact.force;
  int out = 0;
  for (int i = 0; i < force.rows(); ++i)
    out += force.outerIndexPtr()[i] < force.outerIndexPtr()[i + 1];
  return out;
}

/// The counters that grow with the steps.
std::array<int, 9> grown(const WorkCounters& w) {
  return {w.analyses,       w.factorisations, w.triangular_solves, w.products,        w.newton,
          w.fallback_steps, w.followed_steps, w.inner_steps,       w.unfollowed_steps};
}

std::string interrupted_before(int step) { return fmt::format("interrupted before step {}", step); }

} // namespace

OneRun::OneRun(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
               const Restarts& restarts, const std::string* saved, Shown* shown)
    : plan_(plan), restarts_(restarts), discretisation_(discretisation), settings_(settings),
      start_(cpu_seconds()), spared_(spared()), stepper_(plan, discretisation, result_.timing),
      state_(stepper_.state()), reporter_(plan, discretisation, state_, settings, shown) {
  result_.timing.mesh = discretisation.seconds;
  result_.unknowns = state_.formulation->whole_layout().n_unknowns;
  result_.path = state_.formulation->obstacle();
  result_.solver = restarts.solver.value_or(state_.formulation->operators().chosen);
  if (result_.path.empty())
    result_.certificate.mode =
        fmt::format("contact rows every step; all rows at outputs, at the last step and at {} "
                    "random steps",
                    random_checks);
  result_.contact_unknowns = touched_by_laws(state_.contact());
  result_.certificate.tolerance = plan.options.tolerance;
  note_choices(plan, state_.contact(), result_);
  if (settings.monitors) monitor_.emplace(plan.problem, discretisation, state_);
  if (settings.checkpoint_every > 0) fingerprint_ = fingerprint(plan, discretisation.mesh);
  // No output shows a step before the last check: no callback, no file, no checkpoint.
  if (!restarts.checks_at_once && !settings.on_step && settings.checkpoint_every == 0 &&
      saved == nullptr && plan.report.fields.empty() && !settings.monitors)
    if (RowChecks* const checks = state_.checks.get()) checks->let_wait();
  if (saved != nullptr) go_on(*saved);
}

std::optional<Restart> OneRun::march() {
  if (ended_) return *ended_;
  if (settings_.stop != nullptr) stepper_.call_before_iterations([this] { stop_within_step(); });
  LapClock<> clock;
  while (!at_end())
    if (auto restart = take_step(clock)) return restart;
  certify();
  return std::nullopt;
}

std::optional<Restart> OneRun::take_step(LapClock<>& clock) {
  const int steps = state_.evolution.grid().steps();
  const int n = state_.evolution.step() + 1;
  if (settings_.stop != nullptr && settings_.stop->load()) stop_before(n);
  if (n == 1) begin();
  if (auto restart = step(n)) return restart;
  clock.charge(result_.timing.steps);
  record(n == steps);
  if (n < steps) reporter_.stream(checked_up_to(), !stepper_.not_unique().empty());
  if (settings_.checkpoint_every > 0 && (n == steps || n % settings_.checkpoint_every == 0))
    checkpoint();
  clock.charge(result_.timing.output);
  return std::nullopt;
}

/// The state before the step cannot be written any more: the step is finished first unless there is
/// a file of that state, or none is wanted.
void OneRun::stop_within_step() const {
  const int last = state_.evolution.step();
  if (concludes_ || !settings_.stop->load() ||
      (settings_.checkpoint_every > 0 && last > 0 && last != saved_))
    return;
  throw Failure(saved_ > 0 ? FailureKind::suspended : FailureKind::interrupted, {},
                interrupted_before(last + 1));
}

/// The user asked for it.
void OneRun::stop_before(int step) {
  const std::string what = interrupted_before(step);
  if (settings_.checkpoint_every == 0 || step == 1)
    throw Failure(FailureKind::interrupted, {}, what);
  if (checkpoint()) throw Failure(FailureKind::suspended, {}, what);
  throw Failure(FailureKind::interrupted, {}, what + "; its state could not be saved");
}

bool OneRun::at_end() const { return state_.evolution.step() == state_.evolution.grid().steps(); }

RunOutcome OneRun::conclude() {
  concludes_ = true;
  LapClock<> clock;
  if (RowChecks* const checks = state_.checks.get(); checks && !checks->settle())
    return LateCheck();
  clock.charge(result_.timing.steps);
  note_late_errors();
  record(true);
  tell_choice();
  reporter_.finish(result_);
  if (monitor_) finish_monitors();
  result_.unwritten = reporter_.files().unwritten();
  clock.charge(result_.timing.output);
  account(result_.work, result_.timing);
  result_.histories = state_.evolution.memory().reports();
  result_.steps = state_.evolution.step();
  note_proofs(plan_, result_);
  note_precision(plan_, state_, result_);
  result_.u = Vector::Zero(discretisation_.space.n_dofs());
  state_.formulation->scatter(state_.evolution.u(), result_.u);
  if (state_.evolution.step() > 0) estimate_forward_error();
  const Spared now = spared();
  result_.timing.assembly += now.seconds_assembly - spared_.seconds_assembly;
  result_.timing.total =
      cpu_seconds() - start_ + result_.timing.mesh + now.seconds() - spared_.seconds();
  return std::move(result_);
}

Spared OneRun::spared() const {
  return discretisation_.shared ? discretisation_.shared->spared() : Spared{};
}

std::optional<Restart> OneRun::step(int n) {
  const auto outcome = stepper_.advance(n);
  if (outcome.restart) return outcome.restart;
  if (!outcome.certified) refuse_step(outcome, n, state_, plan_);
  note_step(outcome, n, state_.evolution.t(), state_.evolution.grid(), plan_, result_);
  note_negative_bounds(state_, n, plan_, result_);
  reporter_.mark(outcome);
  if (monitor_) {
    monitor_->take(state_, outcome);
    monitor_times_.push_back(state_.evolution.t());
  }
  if (settings_.progress)
    settings_.progress({n, state_.evolution.grid().steps(), outcome.inequality.iterations,
                        cpu_seconds() - start_});
  return std::nullopt;
}

int OneRun::checked_up_to() {
  const int step = state_.evolution.step();
  RowChecks* const checks = state_.checks.get();
  return checks ? checks->checked_up_to(step) : step;
}

void OneRun::note_late_errors() {
  auto& certificate = result_.certificate;
  RowChecks* const checks = state_.checks.get();
  if (checks == nullptr) return;
  for (const auto& [step, error] : checks->late_errors()) {
    if (error > std::max(certificate.equilibrium, certificate.inclusion))
      certificate.worst_step = step;
    if (error > certificate.equilibrium) certificate.equilibrium_step = step;
    certificate.equilibrium = std::max(certificate.equilibrium, error);
  }
}

void OneRun::begin() {
  reporter_.begin(state_);
  if (!settings_.on_start || plan_.problem.time.is_static) return;
  Vector full = Vector::Zero(discretisation_.space.n_dofs());
  state_.formulation->scatter(state_.evolution.u(), full);
  settings_.on_start(state_.evolution.t(), full);
}

void OneRun::record(bool last) {
  if (state_.evolution.step() == 0) return; // nothing certified yet
  reporter_.record(state_, last);
  if (!settings_.on_step || state_.evolution.step() == told_) return;
  told_ = state_.evolution.step();
  Vector full = Vector::Zero(discretisation_.space.n_dofs());
  state_.formulation->scatter(state_.evolution.u(), full);
  settings_.on_step(told_, state_.evolution.t(), full, state_.xi());
}

void OneRun::estimate_forward_error() {
  const PhaseClock<> clock(result_.timing.output);
  auto& error = result_.forward_error;
  StepMatrix* const matrix = state_.solver.equations.matrices.latest();
  std::vector<ErrorSample> samples;
  if (matrix != nullptr)
    samples = state_.rounding.samples(*matrix, state_.solver.equations.laws.accepted(),
                                      result_.certificate.equilibrium);
  // Where a body sticks everywhere displacements are rounding of what its loads amount to.
  const Vector& reach = state_.contact().reach;
  const double moved = reach.size() > 0 ? reach.lpNorm<Eigen::Infinity>() : 0.0;
  const double nothing = negligible_share * std::max(state_.rounding.largest_size(), moved);
  const double size = std::max(state_.rounding.largest_size(), nothing);
  double square = 0.0;
  for (const auto& sample : samples) square = std::max(square, sample.u.lpNorm<Eigen::Infinity>());
  error.solution = size > 0.0 ? 3.0 * square / size : 0.0;
  error.solution = std::max(error.solution, state_.solver.refinement.last_correction());
  error.refined = state_.solver.refinement.on();
  error.amplification = state_.rounding.amplification();
  error.columns = reporter_.errors(
      samples, result_.u, {size, nothing, nothing_of_each(matrix), nothing_of_multipliers(matrix)});
  if (settings_.condition || error.refined || result_.work.bytes < cheap_bytes)
    error.condition = state_.formulation->condition(state_.solver.equations.matrices.latest());
}

namespace {

/// sum_j |K_ij u_j|: the forces in each row before they cancel.
Vector forces_in_rows(const StepMatrix& k, const Vector& u) {
  Vector out;
  if (k.dealt() != nullptr)
    k.dealt()->apply_magnitude(u.head(k.dealt()->size()), out);
  else
    HeldRows(k.k(), {}).apply_magnitude(u.head(k.k().cols()), out);
  return out;
}

} // namespace

double OneRun::nothing_of_multipliers(const StepMatrix* matrix) const {
  const SparseMatrix& force = state_.contact().force;
  double out = 0.0;
  if (matrix == nullptr) return out;
  const Vector forces = forces_in_rows(*matrix, state_.evolution.u());
  for (int i = 0; i < std::min(force.rows(), forces.size()); ++i) {
    double weight = 0.0;
    for (SparseMatrix::InnerIterator it(force, i); it; ++it) weight += std::abs(it.value());
    if (weight > 0.0) out = std::max(out, negligible_share * forces[i] / weight);
  }
  return out;
}

ByUnknown OneRun::nothing_of_each(const StepMatrix* matrix) const {
  ByUnknown out{};
  const auto& of_unknown = state_.contact().of_unknown;
  if (matrix == nullptr || of_unknown.empty()) return out;
  const Vector forces = forces_in_rows(*matrix, state_.evolution.u());
  const Vector own =
      matrix->dealt() != nullptr ? matrix->dealt()->diagonal() : Vector(matrix->k().diagonal());
  for (Eigen::Index i = 0; i < own.size(); ++i) {
    double& most = out[of_unknown[static_cast<std::size_t>(i)]];
    if (own[i] != 0.0) most = std::max(most, negligible_share * forces[i] / std::abs(own[i]));
  }
  return out;
}

bool OneRun::branches_are_followed() const {
  const Contact& contact = state_.contact();
  const bool soften = std::ranges::any_of(contact.softening, [](double m) { return m != 0.0; });
  return follows_branches(stepper_.not_unique(), contact) &&
         (soften || !contact.readings.empty()) &&
         std::ranges::all_of(contact.problem.points,
                             [](const auto& point) { return point.rows == 1; });
}

void OneRun::tell_choice() {
  result_.unique = stepper_.not_unique().empty();
  if (state_.evolution.step() == 0 || result_.unique) return;
  const bool said = std::any_of(result_.notes.begin(), result_.notes.end(),
                                [](const StepNote& n) { return n.step == 0; });
  if (!said)
    result_.notes.insert(
        result_.notes.begin(),
        {0, 0.0,
         fmt::format("uniqueness is not guaranteed: {}; {}", stepper_.not_unique(),
                     branches_are_followed()
                         ? sentence(plan_.options.branch)
                         : "each step's solution is sought from the last step's"),
         plan_.problem.law_terms.empty() ? Origin{} : plan_.problem.law_terms.front().origin});
  StoredEnergy stored(plan_.problem, discretisation_, state_, false);
  if (stored.is_least_at_rest()) result_.energy = stored.energy(state_);
}

void OneRun::finish_monitors() {
  result_.monitors = MonitorTable{monitor_->names(), monitor_times_, monitor_->columns(),
                                  monitor_->balance_error()};
  if (settings_.output_folder.empty() || monitor_times_.empty()) return;
  ReportTable table{{"t"}, {monitor_times_}, {plan_.report.unit_of_time}};
  for (std::size_t c = 0; c < monitor_->names().size(); ++c) {
    const std::string& name = monitor_->names()[c];
    table.names.push_back(name);
    table.columns.push_back(monitor_->columns()[c]);
    table.units.push_back(is_energy(name) ? plan_.report.unit_of_energy : "");
  }
  const auto file = settings_.name + "_monitors.csv";
  reporter_.files().attempt([&] {
    for (const std::string& one : write_table(settings_.output_folder, file, table))
      result_.files.push_back(one);
  });
}

void OneRun::account(WorkCounters& work, Timing& timing) const {
  stepper_.account(work, timing);
  int* const all[] = {&work.analyses,       &work.factorisations, &work.triangular_solves,
                      &work.products,       &work.newton,         &work.fallback_steps,
                      &work.followed_steps, &work.inner_steps,    &work.unfollowed_steps};
  for (std::size_t i = 0; i < grown_before_.size(); ++i) *all[i] += grown_before_[i];
}

void OneRun::go_on(const std::string& saved) {
  std::istringstream in(saved);
  with_its_name(checkpoint_path(settings_.output_folder, settings_.name),
                [&] { ended_ = restore(in); });
}

void OneRun::save_findings(std::ostream& out) const {
  StateWriter w(out);
  reporter_.save(out);
  w.put(result_.certificate.inclusion);
  w.put(result_.certificate.equilibrium);
  w.put(std::array<int, 3>{result_.certificate.worst_step, result_.certificate.inclusion_step,
                           result_.certificate.equilibrium_step});
  if (!plan_.problem.states.empty()) w.put(result_.certificate.states.value_or(0.0));
  put_notes(w, result_.notes);
  WorkCounters work;
  Timing timing;
  account(work, timing);
  w.put(grown(work));
}

bool OneRun::checkpoint() {
  std::ostringstream out;
  out.exceptions(std::ios::badbit); // memory that runs out is no shorter state
  StateWriter w(out);
  restarts_.save(w, result_.solver);
  w.put(static_cast<std::uint8_t>(monitor_.has_value()));
  stepper_.save(out);
  save_findings(out);
  if (monitor_) {
    w.put(monitor_times_);
    monitor_->save(out);
  }
  const bool written = reporter_.files().attempt([&] {
    write_checkpoint(checkpoint_path(settings_.output_folder, settings_.name), fingerprint_,
                     out.view());
  });
  if (written) saved_ = state_.evolution.step();
  return written;
}

void OneRun::restore_findings(std::istream& in) {
  StateReader r(in, {});
  reporter_.restore(in, state_);
  result_.certificate.inclusion = r.get<double>();
  result_.certificate.equilibrium = r.get<double>();
  const auto worst = r.get_counts<3>();
  result_.certificate.worst_step = worst[0];
  result_.certificate.inclusion_step = worst[1];
  result_.certificate.equilibrium_step = worst[2];
  if (!plan_.problem.states.empty()) result_.certificate.states = r.get<double>();
  result_.notes = get_notes(r);
  // Work counted from here on is added to the work before the checkpoint.
  WorkCounters now;
  Timing timing;
  stepper_.account(now, timing);
  const auto saved = r.get_counts<9>(), here = grown(now);
  for (std::size_t i = 0; i < saved.size(); ++i) grown_before_[i] = saved[i] - here[i];
}

std::optional<HorizonEnd> OneRun::restore(std::istream& in) {
  StateReader r(in, {});
  Restarts().restore(r, plan_); // read before: they decide the plan
  if ((r.get<std::uint8_t>() != 0) != monitor_.has_value())
    r.fail(monitor_ ? "was saved without monitors" : "was saved with monitors");
  if (auto end = stepper_.restore(in)) return end;
  restore_findings(in);
  if (monitor_) {
    monitor_times_ = r.get_vector<double>();
    monitor_->restore(in, monitor_times_.size(), state_);
  }
  told_ = result_.resumed_from = saved_ = state_.evolution.step();
  return std::nullopt;
}

} // namespace hvi::solver
