// See step_notes.hpp.
#include "solver/time/step_notes.hpp"

#include "solver/discrete/contact_states.hpp"
#include "solver/fem/pointwise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// "3 points released, 1 re-attached (downward jump)".
std::string crossings(const InequalityReport& report) {
  const int back = report.reattached, off = report.events - back;
  std::string out;
  if (off > 0) out = fmt::format("{} point{} released", off, off == 1 ? "" : "s");
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

std::string where_it_went(const Problem& problem, int state) {
  return fmt::format("the state `{}` was not followed from its last values, where no solution was "
                     "found for the whole step: it may have jumped; smaller steps may show another",
                     problem.states[static_cast<std::size_t>(state)].name);
}

/// The force against the smallest motion: the slope to the right of 0. Of friction its bound.
double force_at_zero(const Law& law, const LawGraph& graph) {
  if (law.spec().radial) return law.slope(graph, 0, 0.0);
  for (std::size_t i = 0; i < graph.breaks.size(); ++i)
    if (graph.breaks[i] == 0.0) return graph.right[i];
  return 0.0;
}

/// The law term to blame: of the worst point, else the first.
Origin blamed(const StepResult& step, const Problem& problem, const Contact& contact) {
  if (const int state = step.states.state;
      state >= 0 && step.states.worst > std::max(step.equilibrium, step.inclusion.worst) &&
      problem.states[static_cast<std::size_t>(state)].algebraic)
    return problem.states[static_cast<std::size_t>(state)].origin;
  if (step.inclusion.worst_term >= 0) return problem.law_terms[step.inclusion.worst_term].origin;
  const int worst = step.inequality.worst_point;
  if (worst >= 0 && worst < static_cast<int>(contact.problem.points.size()))
    return problem.law_terms[contact.problem.points[worst].application].origin;
  return problem.law_terms.empty() ? problem.space.origin : problem.law_terms.front().origin;
}

} // namespace

void note_choices(const Plan& plan, const Contact& contact, RunResult& result) {
  for (const auto& term : contact.terms) {
    if (term.n_points() == 0) continue;
    const auto& spec = plan.problem.law_terms[term.points.law_term];
    const auto& law = *contact.laws[spec.law];
    const double start = plan.problem.time.is_static ? 0.0 : plan.problem.time.grid[0];
    if (law.coupled())
      result.notes.push_back(
          {0, 0.0,
           fmt::format("the bound of `{}` is the multiplier of `{}` (Coulomb): beyond the theory, "
                       "found with it in each step; there may be other solutions",
                       law.spec().name, law.spec().coupled),
           spec.origin});
    if (law.reads())
      result.notes.push_back({0, 0.0,
                              fmt::format("`{}` reads the solution: beyond the theorems here, "
                                          "found with it in each step",
                                          law.spec().name),
                              spec.origin});
    const LawConstants known = law.constants(
        term.points.x[0],
        initial_law_times(plan.problem, law, term.points, start, term.first_readings).front());
    if (std::isfinite(known.m)) continue;
    result.notes.push_back(
        {0, 0.0,
         fmt::format("`{}` {}, so uniqueness is not guaranteed; {}; it is "
                     "reversible: what broke holds again on the way back",
                     law.spec().name, known.jumps_down ? "jumps down" : "falls arbitrarily steeply",
                     sentence(plan.options.branch)),
         spec.origin});
  }
}

void note_step(const StepResult& step, int n, double t, const TimeGrid& grid, const Plan& plan,
               RunResult& result) {
  auto& certificate = result.certificate;
  if (std::max({step.equilibrium, step.inclusion.worst, step.states.worst}) >
      std::max({certificate.equilibrium, certificate.inclusion, certificate.states.value_or(0.0)}))
    certificate.worst_step = n;
  if (!plan.problem.states.empty())
    certificate.states = std::max(certificate.states.value_or(0.0), step.states.worst);
  if (step.equilibrium > certificate.equilibrium || n == 1) certificate.equilibrium_step = n;
  if (step.inclusion.worst > certificate.inclusion || n == 1) certificate.inclusion_step = n;
  certificate.equilibrium = std::max(certificate.equilibrium, step.equilibrium);
  certificate.inclusion = std::max(certificate.inclusion, step.inclusion.worst);
  const Origin origin =
      plan.problem.law_terms.empty() ? Origin{} : plan.problem.law_terms.front().origin;
  if (const auto what = what_happened(step, n, grid, plan.options.branch); !what.empty())
    result.notes.push_back({n, t, what, origin});
  if (step.not_followed >= 0)
    result.notes.push_back(
        {n, t, where_it_went(plan.problem, step.not_followed),
         plan.problem.states[static_cast<std::size_t>(step.not_followed)].origin});
  if (const auto what = what_is_below(step.inequality.least_gap); !what.empty())
    result.notes.push_back({n, t, what, origin});
}

void note_negative_bounds(const RunState& run, int n, const Plan& plan, RunResult& result) {
  const Contact& contact = run.contact();
  if (!contact.coupled) return;
  const ReducedProblem& problem = contact.problem;
  const double rounding = plan.options.tolerance * run.xi().lpNorm<Eigen::Infinity>();
  std::vector<double> least(plan.problem.law_terms.size(), 0.0);
  std::vector<bool> pressed(least.size(), false); // where the bound is least
  for (const CoupledPoint& q : problem.coupled) {
    const ContactPoint& point = problem.points[q.point];
    const Law& law = *problem.laws[point.law];
    const double bound = force_at_zero(law, problem.graphs[point.graph]);
    auto& of_term = least[point.application];
    if (!(bound < of_term)) continue;
    of_term = bound;
    pressed[point.application] = run.xi()[q.row] > rounding;
  }
  for (std::size_t i = 0; i < least.size(); ++i) {
    if (!(least[i] < -rounding)) continue;
    const LawTerm& term = plan.problem.law_terms[i];
    const LawSpec& law = contact.laws[term.law]->spec();
    const auto what = fmt::format("the bound of `{}` is below 0 where `{}` {}", law.name,
                                  law.coupled, pressed[i] ? "presses" : "pulls");
    const auto said = [&](const auto& note) { return note.what.starts_with(what); };
    if (std::ranges::any_of(result.notes, said)) continue;
    result.notes.push_back(
        {n, run.evolution.t(),
         fmt::format("{} (down to {:.3g}): friction drives what slides there, and there may be "
                     "other solutions; {}",
                     what, least[i],
                     pressed[i] ? std::string("a coefficient of friction is positive")
                                : fmt::format("`max({0}.xi, 0)` in place of `{0}.xi` avoids it",
                                              law.coupled)),
         term.origin});
  }
}

void note_proofs(const Plan& plan, RunResult& result) {
  if (plan.options.branch != Branch::least_energy || plan.problem.law_terms.empty()) return;
  const auto open = std::count_if(result.notes.begin(), result.notes.end(), [](const auto& note) {
    return note.what.starts_with(not_proved);
  });
  result.notes.push_back(
      {0, 0.0,
       fmt::format("least energy: proved in {} of {} steps, to {:.0e} of the energies involved",
                   result.steps - open, result.steps, proved_least_gap),
       plan.problem.law_terms.front().origin});
}

void note_precision(const Plan& plan, const RunState& run, RunResult& result) {
  if (plan.options.factor != FactorEntries::singles || result.work.singles) return;
  const Operators& operators = run.formulation->operators();
  const char* const why = operators.iterative    ? "iterations have none"
                          : run.contact().whole  ? "the laws act on most of the unknowns"
                          : operators.coupled    ? "unknowns act on each other"
                          : !operators.symmetric ? "the matrix is not symmetric"
                                                 : "that is too little for the matrix";
  result.notes.push_back(
      {0, 0.0, fmt::format("the factor is not in single precision: {}", why), Origin{}});
}

namespace {

/// A rate of place and time alone is a value of the script; another one is none where the step has
/// led to.
[[noreturn]] void refuse_rate(const StateError::NoRate& found, double t, const std::string& place,
                              const Plan& plan) {
  const StateTerm& state = plan.problem.states[static_cast<std::size_t>(found.state)];
  const auto what = state.algebraic ? fmt::format("what the {} reads", state.name)
                                    : fmt::format("the rate of the state `{}`", state.name);
  if (is_of_place_and_time(state))
    throw_not_finite(state.origin, what, found.rate, found.x, found.dim, &t);
  const std::string wrong = fmt::format("no certified solution at {}: {} is {} at {}", place, what,
                                        std::isnan(found.rate) ? "no number" : "infinite",
                                        describe_point(found.x, found.dim));
  if (state.algebraic)
    throw Failure(FailureKind::not_certified, state.origin, wrong,
                  "let it be a number whatever the solution is (`max(.., 0)` under a root, cases), "
                  "or take smaller steps");
  throw Failure(FailureKind::not_certified, state.origin,
                fmt::format("{}, where `{}` is {:.6g}", wrong, state.name, found.value),
                "let the rate be a number whatever it reads (`max(.., 0)` under a root, cases, a "
                "range `in [a, b]` of the state), or take smaller steps");
}

} // namespace

void refuse_step(const StepResult& step, int n, const RunState& run, const Plan& plan) {
  const auto& grid = run.evolution.grid();
  const auto place = grid.is_static() ? std::string("the static problem")
                                      : fmt::format("step {} (t = {:.6g})", n, grid.t(n));
  if (step.states.no_rate)
    refuse_rate(*step.states.no_rate, grid.is_static() ? 0.0 : grid.t(n), place, plan);
  throw Failure(
      FailureKind::not_certified, blamed(step, plan.problem, run.contact()),
      fmt::format(
          "no certified solution at {}: equilibrium error {:.2e}, inclusion error "
          "{:.2e}, {}tolerance {:.0e}{}{}",
          place, step.equilibrium, step.inclusion.worst,
          plan.problem.states.empty() ? "" : fmt::format("state error {:.2e}, ", step.states.worst),
          plan.options.tolerance, step.inequality.verdict.empty() ? "" : "; ",
          step.inequality.verdict),
      grid.is_static()
          ? "bring the load on in steps, each of which begins at the last one's solution: `for t "
            "in "
            "[0, 1] by 10 steps from u = 0`, loads and imposed values times t; a law that softens "
            "less makes the problem convex, `check` prints the step margin"
          : "a smaller step, or a law that softens less, makes the step's problem convex; "
            "`check` prints the step margin");
}

} // namespace hvi::solver
