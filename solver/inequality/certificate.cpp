// The certificate of a solve (certificate.hpp).
#include "solver/inequality/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

void certify(Position& at, double tolerance, InequalityReport& report, double snap) {
  const ContactPoints& points = at.points;
  at.update_arguments();
  at.balance.product.update(at.c);
  at.snap.update(at.c, at.balance, snap);
  report.residual = at.balance.errors(at.c, at.xi).worst;
  const double largest = points.rows > 0 ? at.xi.lpNorm<Eigen::Infinity>() : 0.0;
  report.inclusion = 0.0;
  for (int p = 0; p < points.size(); ++p) {
    const PreparedLaw& law = points.law(p);
    const Small z = points[p].of(at.z), xi = points[p].of(at.xi);
    const double distance =
        inclusion_distance(law.law(), law.graph(), z.data(), xi.data(), points[p].rows, at.snap(p));
    const double scale = std::max(largest, law.slope_scale());
    double ratio = distance == 0.0 ? 0.0 : distance / scale;
    if (std::isnan(ratio)) ratio = std::numeric_limits<double>::infinity(); // no later one is worse
    if (!(ratio <= report.inclusion)) report.inclusion = ratio, report.worst_point = p;
  }
  report.converged = report.residual <= tolerance && report.inclusion <= tolerance;
}

namespace {

/// Which of several unknowns a point's law acts on.
std::size_t acts_on(const ReducedProblem& problem, const ContactPoint& point) {
  const SparseMatrix::InnerIterator first(problem.g, point.first_row);
  return problem.of_unknown.empty() || !first ? 0 : problem.of_unknown[first.col()];
}

} // namespace

bool drop_rounding(const ReducedProblem& problem, const ByUnknown& most, Vector& xi) {
  bool any = false;
  for (const ContactPoint& point : problem.points) {
    auto of_point = xi.segment(point.first_row, point.rows);
    if (of_point.isZero(0.0) || point.weight * of_point.norm() > most[acts_on(problem, point)])
      continue;
    of_point.setZero();
    any = true;
  }
  return any;
}

} // namespace hvi::solver
