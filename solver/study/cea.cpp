// The terms of the Cea type inequality; see cea.hpp.
#include "solver/study/cea.hpp"

#include "solver/discrete/contact.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/history/history.hpp"
#include "solver/mesh/generate.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// u, u' and the memory in the fine space, and what the paper makes of them at one time.
class Residual {
public:
  Residual(const FineSolution& solution, const TimeSpec& time)
      : problem_(solution.problem), d_(*solution.discretisation),
        layout_(make_layout(d_.space, d_.dofs)), contact_(make_contact(problem_, d_, layout_)),
        loads_(d_.space, d_.parts, problem_.loads),
        viscous_(matrix_of_field(problem_, d_, field_of_u(1))),
        elastic_(matrix_of_field(problem_, d_, field_of_u(0))) {
    for (std::size_t m = 0; m < problem_.histories.size(); ++m) {
      memory_.push_back(matrix_of_field(problem_, d_, field_of_memory(static_cast<int>(m))));
      HistoryOptions options;
      options.order = 1;
      options.horizon = time.grid.back() - time.grid.front();
      options.steps = static_cast<std::int64_t>(time.grid.size()) - 1;
      histories_.push_back(make_history(problem_.histories[m].kernel,
                                        static_cast<std::size_t>(d_.space.n_dofs()), options));
    }
  }

  /// Has a law an infinite slope?
  bool unbounded() const {
    const auto infinite = [](double s) { return std::abs(s) >= unbounded_slope; };
    return std::any_of(contact_.problem.graphs.begin(), contact_.problem.graphs.end(),
                       [&](const LawGraph& g) {
                         return std::any_of(g.left.begin(), g.left.end(), infinite) ||
                                std::any_of(g.right.begin(), g.right.end(), infinite);
                       });
  }

  void start(double t, const Vector& u) {
    for (auto& history : histories_)
      history->start(t, {u.data(), static_cast<std::size_t>(u.size())});
  }

  /// Goes on to the next time, then S(v) for v - u = `off`; ||M off||_X in `trace`.
  double at(double t, const Vector& u, const Vector& rate, const Vector& off, double& trace) {
    Vector r = viscous_ * rate + elastic_ * u, load = Vector::Zero(u.size());
    loads_.add(t, load);
    r -= load;
    Vector w(u.size());
    const auto n = static_cast<std::size_t>(u.size());
    for (std::size_t m = 0; m < histories_.size(); ++m) {
      histories_[m]->rhs(t, {w.data(), n});
      w += histories_[m]->w0(t) * u;
      r += memory_[m] * w;
      histories_[m]->commit(t, {u.data(), n});
    }
    return r.dot(off) + directional(t, u, off, trace);
  }

private:
  /// J^0(M u; M off) by the points of the laws.
  double directional(double t, const Vector& u, const Vector& off, double& trace) {
    double sum = 0.0, square = 0.0;
    if (contact_.none()) return trace = 0.0;
    Vector state = Vector::Zero(layout_.n_state);
    layout_.gather(u, state);
    prepare(contact_, problem_, t, LawFields(state), Vector::Zero(contact_.n_rows()));
    for (const auto& term : contact_.terms) {
      const Vector z = term.points.g * u + contact_.offset.segment(term.first_row, term.n_rows());
      const Vector direction = term.points.g * off;
      for (int p = 0; p < term.n_points(); ++p) {
        const auto& point = contact_.problem.points[term.first_point + p];
        const int first = point.first_row - term.first_row;
        const Vector zp = z.segment(first, point.rows), dp = direction.segment(first, point.rows);
        sum += point.weight * clarke_derivative(point, zp, dp);
        square += point.weight * dp.squaredNorm();
      }
    }
    trace = std::sqrt(square);
    return sum;
  }

  /// j^0(z; d) = max over the subdifferential at z.
  double clarke_derivative(const ContactPoint& point, const Vector& z, const Vector& d) const {
    const Law& law = *contact_.laws[point.law];
    const LawGraph& graph = contact_.problem.graphs[point.graph];
    if (!law.spec().radial) {
      const Interval xi = clarke(law, graph, z[0]);
      return std::max(xi.low * d[0], xi.high * d[0]);
    }
    const double r = z.norm();
    if (r == 0.0) return std::abs(law.slope(graph, piece_of(graph, 0.0), 0.0)) * d.norm();
    const Interval xi = clarke(law, graph, r);
    const double along = z.dot(d) / r;
    return std::max(xi.low * along, xi.high * along);
  }

  const Problem& problem_;
  const Discretisation& d_;
  StateLayout layout_;
  Contact contact_;
  LoadAssembler loads_;
  SparseMatrix viscous_, elastic_;
  std::vector<SparseMatrix> memory_;
  std::vector<std::unique_ptr<History>> histories_;
};

/// Has the problem nothing but what the theorem has: one unknown and its rate, a memory, loads of
/// time, laws on u that read nothing of the solution?
bool is_of_the_theorem(const Problem& problem) {
  const auto on_u_alone = [&](const LawTerm& term) {
    const LawSpec& law = problem.laws[static_cast<std::size_t>(term.law)];
    return term.field == field_of_u(0) && term.seen.empty() && law.coupled.empty() &&
           law.readings.empty();
  };
  return !problem.time.is_static && !in_motion(problem) && problem.space.more.empty() &&
         problem.states.empty() && std::ranges::all_of(problem.law_terms, on_u_alone);
}

} // namespace

FineSolution fine_exact(const Problem& problem, const Mesh& coarse, std::vector<Expr> exact) {
  FineSolution out;
  out.problem = problem;
  out.problem.space.order = 2;
  auto d = std::make_shared<Discretisation>();
  const auto failures = discretise_on({out.problem, {}, {}}, refine(coarse), *d);
  if (!failures.empty()) throw failures.front();
  out.discretisation = d;
  const Origin origin = problem.time.origin;
  std::vector<Expr> rates;
  for (const Expr& e : exact) rates.push_back(derivative(e, slot::t));
  out.u = [d, exact, origin](double t) { return interpolate(d->space, exact, t, origin); };
  out.rate = [d, rates, origin](double t) { return interpolate(d->space, rates, t, origin); };
  return out;
}

FineSolution fine_trajectory(const Problem& problem, std::shared_ptr<const Trajectory> trajectory) {
  FineSolution out;
  out.problem = problem;
  out.discretisation = trajectory->discretisation;
  out.u = [trajectory](double t) { return trajectory->at(t); };
  out.rate = [trajectory](double t) -> Vector {
    const auto& times = trajectory->times;
    auto after =
        std::lower_bound(times.begin(), times.end(), t - 1e-9 * (times.back() - times.front()));
    const auto n = std::clamp<std::ptrdiff_t>(after - times.begin(), 1,
                                              static_cast<std::ptrdiff_t>(times.size()) - 1);
    const auto i = static_cast<std::size_t>(n);
    return (trajectory->states[i] - trajectory->states[i - 1]) / (times[i] - times[i - 1]);
  };
  return out;
}

std::optional<CeaTerms> cea_terms(const FineSolution& solution, const Problem& problem,
                                  const Discretisation& coarse) {
  CeaTerms out;
  if (!is_of_the_theorem(problem)) return std::nullopt;
  const Space& fine = solution.discretisation->space;
  // v = the interpolant of u: values of the fine function at the coarse nodes, seen in the fine
  // space.
  const SparseMatrix down = transfer(fine, coarse.space), up = transfer(coarse.space, fine);
  const SparseMatrix gram = gram_of_unknown(fine, 0, false);
  const auto square = [&](const Vector& w) { return std::max(0.0, w.dot(gram * w)); };
  const auto& grid = problem.time.grid;
  Residual residual(solution, problem.time);
  if (residual.unbounded()) return std::nullopt;
  Vector before = solution.u(grid.front());
  Vector off_before = up * (down * before) - before;
  residual.start(grid.front(), before);
  out.start = out.interpolation = square(off_before);
  for (std::size_t n = 1; n < grid.size(); ++n) {
    const double k = grid[n] - grid[n - 1];
    const Vector u = solution.u(grid[n]), rate = solution.rate(grid[n]);
    const Vector off = up * (down * u) - u;
    double trace = 0.0;
    const double s = std::abs(residual.at(grid[n], u, rate, off, trace));
    out.interpolation = std::max(out.interpolation, square(off));
    out.interpolation_rate += square(off - off_before) / k;
    out.trace += k * trace;
    out.residual += k * s;
    out.largest_residual = std::max(out.largest_residual, s);
    out.rate += k * square((u - before) / k - rate);
    out.step = std::max(out.step, k * k);
    before = u, off_before = off;
  }
  return out;
}

} // namespace hvi::solver
