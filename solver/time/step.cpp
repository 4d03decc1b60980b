// The state of a run and how it advances; see step.hpp. Called by the loop in run.cpp.
#include "solver/time/step.hpp"

#include "solver/common/memory_room.hpp"
#include "solver/time/saved_state.hpp"
#include "solver/time/snap.hpp"
#include "solver/time/uniqueness.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// What memories will hold must fit, and factors leave room for it.
Formulation& with_room_for_memories(const Plan& plan, Formulation& formulation,
                                    const Memory& memory) {
  const double bytes = history_bytes_to_come(plan, memory.reports(), formulation.layout().n_state);
  formulation.expect_memory(bytes);
  require_memory(bytes, "the fields its memories will hold");
  return formulation;
}

StepResult start_again(Restart why) {
  StepResult out;
  out.restart = std::move(why);
  return out;
}

} // namespace

/// The clock runs while the members are made.
Stepper::Stepper(const Plan& plan, const Discretisation& d, Timing& timing)
    : Stepper(plan, d, timing, PhaseClock<>(timing.assembly)) {}

Stepper::Stepper(const Plan& plan, const Discretisation& d, Timing& timing, const PhaseClock<>&)
    : plan_(plan), timing_(timing), formulation_(formulate(plan, d)),
      evolution_(plan, formulation_->initial(), formulation_->imposed()),
      balance_(plan, d, with_room_for_memories(plan, *formulation_, evolution_.memory()),
               evolution_),
      solver_(plan, d, evolution_, *formulation_, balance_),
      rounding_(plan, *formulation_, evolution_, balance_),
      checks_(formulation_->row_checks(plan)) {
  const int n_unknowns = formulation_->layout().n_unknowns, n_rows = contact().n_rows();
  trial_.d = trial_.kd = trial_.gap = Vector::Zero(n_unknowns);
  trial_.z = trial_.dz = Vector::Zero(n_rows);
  evolution_.start();
}

void Stepper::let_checks_wait() {
  if (checks_) checks_->let_wait();
}

bool Stepper::make_checks() { return !checks_ || checks_->settle(); }

int Stepper::checked_up_to() const { return checks_ ? checks_->checked_up_to(step()) : step(); }

std::vector<std::pair<int, double>> Stepper::late_errors() {
  return checks_ ? checks_->late_errors() : std::vector<std::pair<int, double>>();
}

void Stepper::judge_uniqueness(StepMatrix& matrix) {
  uniqueness_judged_ = true;
  Uniqueness uniqueness(plan_, formulation_->operators(), contact());
  if (!uniqueness.settled()) {
    if (uniqueness.condensed() && step() == 0) // a restored solver goes on with the same bits
      uniqueness.judge(matrix.unique());
    else
      uniqueness.judge_all(matrix.factorisation());
  }
  not_unique_ = uniqueness.obstacle();
}

/// Steps may have several solutions: branches are followed. Coupled laws: their own passes settle
/// the bounds, the path matters where a law softens.
bool Stepper::follows() const {
  return !not_unique_.empty() &&
         (!contact().coupled ||
          std::ranges::any_of(contact().softening, [](double m) { return m != 0.0; }));
}

/// From the last accepted state to equation_.known = u_n, with its certificate; nothing is
/// accepted.
StepResult Stepper::attempt(int n, StepMatrix& matrix) {
  auto out = solver_.attempt(n, matrix, follows(), equation_, trial_);
  counted_.newton += out.inequality.iterations;
  counted_.fallback_steps += out.inequality.used_fallback ? 1 : 0;
  if (checks_ && checks_->at_once(n)) {
    const auto error = checks_->error(n, balance_.question(n, trial_.d, xi()));
    if (!error) return start_again(LateCheck());
    out.equilibrium = std::max(out.equilibrium, *error);
  }
  const double tolerance = plan_.options.tolerance;
  out.certified =
      out.inequality.converged && out.equilibrium <= tolerance && out.inclusion.worst <= tolerance;
  return out;
}

void Stepper::count(const StepResult& result) {
  const auto& inequality = result.inequality;
  counted_.inner_steps += inequality.inner_steps;
  counted_.unfollowed_steps += inequality.not_followed ? 1 : 0;
  counted_.followed_steps += inequality.inner_steps > 0 && !inequality.not_followed ? 1 : 0;
}

StepResult Stepper::advance(int n) {
  {
    const PhaseClock<wall_seconds> clock(timing_.history);
    if (auto mistrust = evolution_.begin_step(n)) return start_again(std::move(*mistrust));
  }
  auto& matrix = solver_.matrix_for(n);
  if (!uniqueness_judged_) judge_uniqueness(matrix);
  auto out = attempt(n, matrix);
  if (!out.restart && !out.certified && solver_.can_begin_anew()) out = attempt(n, matrix);
  if (out.restart) return out;
  const bool guess = out.inequality.inner_steps == 0 || out.inequality.not_followed;
  if (!out.branch_ends.empty())
    out.snap = true;
  else if (out.certified && guess && formulation_->operators().symmetric && !contact().none())
    out.snap = is_snap(contact(), solver_.laws().c, trial_.kd.dot(trial_.d), trial_.dz);
  if (!out.certified)
    solver_.give_up();
  else if (!accept(n, matrix, out))
    return start_again(LateCheck());
  return out;
}

/// False: a check that was put off failed, and nothing is accepted.
bool Stepper::accept(int n, StepMatrix& matrix, const StepResult& result) {
  count(result);
  if (checks_) {
    if (checks_->later(n)) checks_->put_off(n, balance_.question(n, trial_.d, xi()));
    if (!checks_->settle_in_time(n)) return false;
  }
  solver_.accept(n, matrix, result, trial_);
  {
    const PhaseClock<wall_seconds> clock(timing_.history);
    evolution_.accept(n, equation_.known, trial_.d);
  }
  rounding_.note(result.equilibrium, trial_.gap, xi(), equation_.known);
  return true;
}

std::vector<ErrorSample> Stepper::rounding_errors(double backward_error) {
  StepMatrix* const matrix = solver_.matrices().latest();
  if (step() == 0 || matrix == nullptr) return {};
  return rounding_.samples(*matrix, solver_.accepted(), backward_error);
}

void Stepper::account(WorkCounters& work, Timing& timing) const {
  work.matrices = formulation_->operators().n_bases();
  work.products = balance_.products;
  work.newton = counted_.newton;
  work.fallback_steps = counted_.fallback_steps;
  work.followed_steps = counted_.followed_steps;
  work.inner_steps = counted_.inner_steps;
  work.unfollowed_steps = counted_.unfollowed_steps;
  work.field_reads = evolution_.field_reads();
  for (const auto& report : evolution_.memory().reports()) {
    work.history_fields += static_cast<int>(report.fields);
    work.bytes += report.bytes;
  }
  charge(formulation_->statistics(), work, timing);
  work.bytes += balance_.bytes();
  solver_.matrices().account(work, timing);
}

void Stepper::save(std::ostream& out) const {
  StateWriter w(out);
  evolution_.save(out);
  put_text(w, not_unique_);
  solver_.save(out);
  rounding_.save(w);
}

void Stepper::restore(std::istream& in) {
  StateReader r(in, {});
  uniqueness_judged_ = evolution_.restore(in); // for another end there are other steps to judge
  not_unique_ = get_text(r);
  solver_.restore(in);
  rounding_.restore(r);
}

} // namespace hvi::solver
