// See start_state.hpp. Called by run.cpp.
#include "solver/time/start_state.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/time/run.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

/// Not a law that stands in the start for states or bounds alone: what it would do there is asked
/// of the law itself.
bool has_force(const Problem& start, const LawTerm& term) {
  return !start.laws[static_cast<std::size_t>(term.law)].expression.is(0.0);
}

/// The law terms of a problem that another one of the same laws has, too.
std::vector<int> shared_terms(const Problem& problem, const Problem& start) {
  std::vector<int> out;
  for (int l = 0; l < static_cast<int>(problem.law_terms.size()); ++l) {
    const LawTerm& term = problem.law_terms[static_cast<std::size_t>(l)];
    if (std::ranges::any_of(start.law_terms, [&](const LawTerm& other) {
          return other.name == term.name && other.part == term.part && has_force(start, other);
        }))
      out.push_back(l);
  }
  return out;
}

/// Multipliers of a problem by the rows of its terms as they are written: of a radial law the
/// engine has a basis of the range of its rows, which may be smaller where rates are at rest.
std::vector<double> by_written_rows(const Problem& problem, const Discretisation& d,
                                    const std::vector<double>& xi) {
  std::vector<double> out;
  Eigen::Index taken = 0;
  for (int l = 0; l < static_cast<int>(problem.law_terms.size()); ++l) {
    const LawTerm& term = problem.law_terms[static_cast<std::size_t>(l)];
    const bool radial = problem.laws[static_cast<std::size_t>(term.law)].radial;
    const LawPoints points =
        assemble_law(d.space, d.parts[static_cast<std::size_t>(term.part)], term, l, radial);
    if (!has_force(problem, term)) {
      taken += static_cast<Eigen::Index>(points.x.size()) * points.rows;
      continue;
    }
    for (std::size_t p = 0; p < points.x.size(); ++p, taken += points.rows) {
      const Eigen::Map<const Vector> own(xi.data() + taken, points.rows);
      const Vector written = points.frames.empty() ? Vector(own) : Vector(points.frames[p] * own);
      out.insert(out.end(), written.begin(), written.end());
    }
  }
  return out;
}

/// The problem of the start on the mesh and in the space of the run.
Plan start_of(const Plan& plan) {
  Plan out = *plan.start;
  out.problem.mesh = plan.problem.mesh;
  out.problem.parts = plan.problem.parts;
  out.problem.space = plan.problem.space;
  out.options = plan.options;
  for (std::size_t i = 0; i < plan.problem.states.size(); ++i) // the algebraic ones behind
    if (!plan.problem.states[i].algebraic)
      out.problem.states[i].placed_by = plan.problem.states[i].rate;
  return out;
}

} // namespace

Plan with_start_solved(const Plan& plan, const Discretisation& discretisation,
                       const RunSettings& settings, std::vector<StepNote>& notes) {
  const Plan rest = start_of(plan);
  auto state = std::make_shared<StartState>();
  RunSettings quiet;
  quiet.stop = settings.stop;
  quiet.on_step = [&](int, double, const Vector& u, const Vector& xi) {
    state->u.assign(u.begin(), u.end());
    state->xi.assign(xi.begin(), xi.end());
  };
  try {
    const RunResult result = run(rest, discretisation, quiet);
    for (const StepNote& note : result.notes)
      notes.push_back({0, 0.0, "the static start: " + note.what, note.origin});
  } catch (const Failure& failure) {
    throw Failure(failure.kind, failure.origin, fmt::format("the static start: {}", failure.what()),
                  failure.help);
  }
  state->terms = shared_terms(plan.problem, rest.problem);
  state->xi = by_written_rows(rest.problem, discretisation, state->xi);
  Plan out = plan;
  out.start.reset();
  out.problem.time.start = std::move(state);
  return out;
}

} // namespace hvi::solver
