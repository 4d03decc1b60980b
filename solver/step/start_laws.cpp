// See start_laws.hpp.
#include "solver/step/start_laws.hpp"

#include "solver/discrete/contact_states.hpp"

#include <fmt/format.h>

#include <set>

namespace hvi::solver {
namespace {

/// Where nothing moves and nothing has been the argument of a law on rates is its offset: does zero
/// belong to the subdifferential there?
void require_no_force(const Problem& problem, const Contact& contact, int l) {
  const LawTerm& spec = problem.law_terms[static_cast<std::size_t>(l)];
  const ContactTerm& term = contact.terms[static_cast<std::size_t>(l)];
  const Law& law = *contact.laws[static_cast<std::size_t>(spec.law)];
  const double t0 = problem.time.grid.front();
  Vector at;
  offsets_of(contact, problem, term, t0, contact.state_values, at);
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

/// The multipliers of a term from what is written from `from` on; returns where that ends.
Eigen::Index take_rows(const ContactTerm& term, const std::vector<double>& written,
                       Eigen::Index from, Vector& xi) {
  const int rows = term.points.rows;
  for (int p = 0; p < term.n_points(); ++p) {
    auto own = xi.segment(term.first_row + p * rows, rows);
    if (term.points.frames.empty()) {
      own = Eigen::Map<const Vector>(written.data() + from, rows);
      from += rows;
      continue;
    }
    const DenseMatrix& frame = term.points.frames[static_cast<std::size_t>(p)];
    own = frame.transpose() * Eigen::Map<const Vector>(written.data() + from, frame.rows());
    from += frame.rows();
  }
  return from;
}

} // namespace

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
    taken = take_rows(contact.terms[static_cast<std::size_t>(l)], start.xi, taken, xi);
  }
  run.solver.equations.laws.start(xi);
  run.balance.load.note_multipliers(xi);
}

} // namespace hvi::solver
