// How the state of a run advances; see step.hpp. Called by the loop in run.cpp.
#include "solver/step/step.hpp"

#include "solver/common/clock.hpp"
#include "solver/formulation/at_rest.hpp"
#include "solver/formulation/inf_sup.hpp"
#include "solver/formulation/uniqueness.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/step/snap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

/// The clock runs while the state is made.
RunState make_state(const Plan& plan, const Discretisation& d, Timing& timing) {
  const PhaseClock<> clock(timing.assembly);
  return {plan, d};
}

StepResult start_again(Restart why) {
  StepResult out;
  out.restart = std::move(why);
  return out;
}

/// Why the solver cannot tell whether the forms are stiffer than the laws are soft; empty: it can.
std::string nothing_proved(const Uniqueness& uniqueness, const Operators& operators,
                           const StepMatrix& matrix) {
  const char* const who = operators.iterative   ? "iterations do not"
                          : matrix.in_singles() ? "a factor in single precision does not"
                                                : nullptr;
  if (who == nullptr) return {};
  return uniqueness.softens()
             ? fmt::format("a law softens, and {} prove that the body is stiffer", who)
             : fmt::format("there are laws, and {} prove that the forms are coercive", who);
}

/// Of unknowns without a form of their own, where the others are unique. Laws on most of the body
/// leave no condensed matrix to ask.
std::string obstacle_of_multipliers(const Problem& problem, const Discretisation& d,
                                    const RunState& state, const StepMatrix& matrix) {
  const Contact& contact = state.contact();
  const std::string names = names_of_multipliers(problem);
  if (names.empty() || contact.none()) return {};
  const Formulation& on = *state.formulation;
  const bool determined =
      contact.whole ? sees_multipliers_at_rest(problem, d, on.whole_layout(), on.operators())
                    : determines_multipliers(problem, contact, matrix.factorisation()->schur());
  return determined
             ? std::string()
             : fmt::format("where points of a law with jumps rest, its forces and {}, without "
                           "a form of its own, may share what holds the body",
                           names);
}

/// Why not every step is sure to have one solution, asked at the first step with its matrix.
std::string obstacle_to_uniqueness(const Problem& problem, const Discretisation& d,
                                   const RunState& state, StepMatrix& matrix) {
  const Formulation& on = *state.formulation;
  Uniqueness uniqueness(problem, on.operators(), state.contact());
  if (const FreeBody* const body = matrix.free_body()) {
    if (!uniqueness.holds()) return uniqueness.obstacle();
    return uniqueness.settled() && held_strongly(*body, state.contact())
               ? std::string()
               : "laws alone hold the body";
  }
  if (!uniqueness.settled()) {
    if (auto why = nothing_proved(uniqueness, on.operators(), matrix); !why.empty()) return why;
    // Not in a restored run: asking would change the solver, and its later numbers.
    if (uniqueness.condensed() && state.evolution.step() == 0)
      uniqueness.judge(matrix.laws() == nullptr || matrix.laws()->convex());
    else if (uniqueness.condensed_without_symmetry())
      uniqueness.judge_condensed(matrix.k(), matrix.factorisation()->schur());
    else
      uniqueness.judge_all(matrix.factorisation().get());
  }
  if (!uniqueness.holds()) return uniqueness.obstacle();
  return obstacle_of_multipliers(problem, d, state, matrix);
}

bool is_certified(const StepResult& step, double tolerance) {
  return step.inequality.converged && step.equilibrium <= tolerance &&
         step.inclusion.worst <= tolerance && step.states.worst <= tolerance;
}

void count(const InequalityReport& inequality, WorkCounters& counted) {
  counted.inner_steps += inequality.inner_steps;
  counted.unfollowed_steps += inequality.not_followed ? 1 : 0;
  counted.followed_steps += inequality.inner_steps > 0 && !inequality.not_followed ? 1 : 0;
}

/// Did a certified step that was not followed cross unstable states?
bool is_snap(RunState& state, const StepResult& step) {
  const bool guess = step.inequality.inner_steps == 0 || step.inequality.not_followed;
  if (!guess || !state.formulation->operators().symmetric || state.contact().none()) return false;
  Trial& trial = state.trial;
  return is_snap(state.contact(), state.solver.equations.laws.now.c, trial.kd.dot(trial.d),
                 trial.dz);
}

} // namespace

/// Of laws that are coupled or read states only those that soften need it: their bounds are found
/// by passes of their own. A law that reads the solution may soften with any of its values.
bool follows_branches(const std::string& not_unique, const Contact& contact) {
  return !not_unique.empty() &&
         ((!contact.coupled && contact.state_groups.empty()) || !contact.readings.empty() ||
          std::ranges::any_of(contact.softening, [](double m) { return m != 0.0; }));
}

Stepper::Stepper(const Plan& plan, const Discretisation& d, Timing& timing)
    : plan_(plan), discretisation_(d), timing_(timing), state_(make_state(plan, d, timing)) {}

/// From the last accepted state to u_n, with its certificate; nothing is accepted.
StepResult Stepper::attempt(int n, StepMatrix& matrix) {
  auto out = state_.solver.attempt(n, matrix, follows_branches(not_unique(), state_.contact()),
                                   state_.equation, state_.trial);
  counted_.newton += out.inequality.iterations;
  counted_.fallback_steps += out.inequality.used_fallback ? 1 : 0;
  if (state_.checks && state_.checks->at_once(n)) {
    const auto error = state_.checks->error(
        n, state_.balance.question(n, state_.trial.d, state_.xi()), state_.equation.known);
    if (!error) return start_again(LateCheck());
    out.equilibrium = std::max(out.equilibrium, *error);
  }
  out.certified = is_certified(out, plan_.options.tolerance);
  return out;
}

StepResult Stepper::advance(int n) {
  {
    const PhaseClock<wall_seconds> clock(timing_.history);
    if (auto stop = state_.evolution.begin_step(n))
      return std::visit([](auto& why) { return start_again(std::move(why)); }, *stop);
  }
  if (state_.formulation->imposed() && in_motion(plan_.problem)) {
    state_.balance.known_state(n, state_.equation.known);
    state_.evolution.impose(n, state_.formulation->layout().n_unknowns, state_.equation.known);
  }
  auto& matrix = state_.solver.matrix_for(n);
  if (!std::exchange(uniqueness_.judged, true))
    uniqueness_.obstacle = obstacle_to_uniqueness(plan_.problem, discretisation_, state_, matrix);
  auto out = attempt(n, matrix);
  if (!out.restart && !out.certified && state_.solver.begin_anew(n)) out = attempt(n, matrix);
  if (out.restart) return out;
  if (!out.certified && matrix.in_singles()) return start_again(SinglesRefused());
  if (!out.certified && state_.contact().change) return start_again(JumpsRefused());
  if (!out.certified && out.inequality.converged && state_.checks)
    return start_again(RowsRefused());
  if (!out.branch_ends.empty())
    out.snap = true;
  else if (out.certified)
    out.snap = is_snap(state_, out);
  if (!out.certified)
    state_.solver.equations.laws.give_up();
  else if (!accept(n, matrix, out))
    return start_again(LateCheck());
  else if (auto end = state_.evolution.memory().ended())
    return start_again(*std::move(end));
  return out;
}

/// False: a check that was put off failed, and nothing is accepted.
bool Stepper::accept(int n, StepMatrix& matrix, const StepResult& result) {
  Trial& trial = state_.trial;
  count(result.inequality, counted_);
  if (auto* const checks = state_.checks.get()) {
    if (checks->later(n)) checks->put_off(n, state_.balance.question(n, trial.d, state_.xi()));
    if (!checks->settle_in_time(n)) return false;
  }
  state_.solver.accept(n, matrix, result, trial);
  {
    const PhaseClock<wall_seconds> clock(timing_.history);
    state_.evolution.accept(n, state_.equation.known, trial.d);
  }
  state_.balance.load.note_multipliers(state_.xi());
  state_.rounding.note(result.equilibrium, trial.gap, state_.xi(), state_.equation.known);
  return true;
}

void Stepper::account(WorkCounters& work, Timing& timing) const {
  work.matrices = state_.formulation->operators().n_bases();
  work.products = state_.balance.products;
  work.newton = counted_.newton;
  work.fallback_steps = counted_.fallback_steps;
  work.followed_steps = counted_.followed_steps;
  work.inner_steps = counted_.inner_steps;
  work.unfollowed_steps = counted_.unfollowed_steps;
  work.field_reads = state_.evolution.field_reads();
  for (const auto& report : state_.evolution.memory().reports()) {
    work.history_fields += static_cast<int>(report.fields);
    work.bytes += report.bytes;
  }
  charge(state_.formulation->statistics(), work, timing);
  const Operators& operators = state_.formulation->operators();
  work.bytes += bytes_of(operators, state_.balance.halves());
  if (operators.dealt) work.iterative.assembling = operators.dealt->processes();
  state_.solver.equations.account(work, timing);
}

void Stepper::save(std::ostream& out) const {
  StateWriter w(out);
  state_.evolution.save(out);
  put_text(w, not_unique());
  state_.solver.save(out);
  put_vector(w, state_.trial.z); // the branches of the laws, where a report asks for them
  state_.rounding.save(w);
}

std::optional<HorizonEnd> Stepper::restore(std::istream& in) {
  StateReader r(in, {});
  auto same_end = state_.evolution.restore(in);
  if (auto* end = std::get_if<HorizonEnd>(&same_end)) return std::move(*end);
  uniqueness_.judged = std::get<bool>(same_end); // a run to another end has other steps to judge
  uniqueness_.obstacle = get_text(r);
  state_.solver.restore(in);
  get_vector(r, state_.trial.z, state_.contact().n_rows());
  state_.balance.load.note_multipliers(state_.xi());
  state_.rounding.restore(r);
  return std::nullopt;
}

} // namespace hvi::solver
