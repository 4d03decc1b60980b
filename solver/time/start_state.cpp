// See start_state.hpp. Called by run.cpp, and when the state of a run is made.
#include "solver/time/start_state.hpp"

#include "solver/time/contact_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace hvi::solver {
namespace {

/// The law terms of a problem that another one of the same laws has, too.
std::vector<int> shared_terms(const Problem& problem, const Problem& start) {
  std::vector<int> out;
  for (int l = 0; l < static_cast<int>(problem.law_terms.size()); ++l) {
    const LawTerm& term = problem.law_terms[static_cast<std::size_t>(l)];
    if (std::ranges::any_of(start.law_terms, [&](const LawTerm& other) {
          return other.name == term.name && other.part == term.part;
        }))
      out.push_back(l);
  }
  return out;
}

/// Where nothing moves and nothing has been the argument of a law on rates is its offset: does zero
/// belong to the subdifferential there?
void require_no_force(const Problem& problem, const Contact& contact, int l) {
  const LawTerm& spec = problem.law_terms[static_cast<std::size_t>(l)];
  const ContactTerm& term = contact.terms[static_cast<std::size_t>(l)];
  const Law& law = *contact.laws[static_cast<std::size_t>(spec.law)];
  const double t0 = problem.time.grid.front();
  Vector at;
  law_offsets(term.points, spec, t0, at);
  auto times = initial_law_times(problem, law, term.points, t0, term.first_readings);
  const std::vector<double> none(static_cast<std::size_t>(term.points.rows), 0.0);
  for (int p = 0; p < term.n_points(); ++p) {
    auto& time = times[static_cast<std::size_t>(p)];
    time.coupled = 1.0; // of a bound only this matters: it is not zero
    const Point& x = term.points.x[static_cast<std::size_t>(p)];
    const LawGraph graph = law.graph(x, time);
    const double* const z = at.data() + static_cast<std::ptrdiff_t>(p) * term.points.rows;
    constexpr double no_force = 1e-12;
    const double force = inclusion_distance(law, graph, z, none.data(), term.points.rows, 0.0);
    if (force <= no_force * law.constants(x, time).slope_scale) continue;
    throw Failure(
        FailureKind::bad_value, spec.origin,
        fmt::format("`{}` exerts a force at ({:.4g}, {:.4g}, {:.4g}) where nothing moves: "
                    "the static problem does not know it",
                    spec.name, x[0], x[1], x[2]),
        "start from given values, or let the force grow from zero");
  }
}

/// The problem of the start on the mesh and in the space of the run.
Plan start_of(const Plan& plan) {
  Plan out = *plan.start;
  out.problem.mesh = plan.problem.mesh;
  out.problem.parts = plan.problem.parts;
  out.problem.space = plan.problem.space;
  out.options = plan.options;
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
  Plan out = plan;
  out.start.reset();
  out.problem.time.start = std::move(state);
  return out;
}

void take_start(const Problem& problem, RunState& run) {
  const StartState& start = *problem.time.start;
  const Contact& contact = run.contact();
  const std::set<int> known(start.terms.begin(), start.terms.end());
  Vector xi = Vector::Zero(contact.n_rows());
  Eigen::Index taken = 0;
  for (int l = 0; l < static_cast<int>(contact.terms.size()); ++l) {
    if (!known.contains(l)) {
      require_no_force(problem, contact, l);
      continue;
    }
    const ContactTerm& term = contact.terms[static_cast<std::size_t>(l)];
    xi.segment(term.first_row, term.n_rows()) =
        Eigen::Map<const Vector>(start.xi.data() + taken, term.n_rows());
    taken += term.n_rows();
  }
  run.solver.equations.laws.start(xi);
  run.balance.load.note_multipliers(xi);
}

} // namespace hvi::solver
