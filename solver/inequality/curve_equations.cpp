// Tangents of the equilibrium curve, and corrections back onto it (curve_equations.hpp).
#include "solver/inequality/curve_equations.hpp"

#include "solver/common/numbers.hpp"
#include "solver/linear/dense.hpp"

#include <cmath>

namespace hvi::solver {

namespace {
constexpr int most_corrections_to_curve = 8;
} // namespace

CurveEquations::CurveEquations(const CurveProblem& problem, Vector b0, const Vector& b1,
                               double size)
    : problem_(problem), b0_(std::move(b0)), db_(b1 - b0_), size_(size) {}

double CurveEquations::cosine(const CurveTangent& a, const CurveTangent& b) const {
  return a.way.dot(b.way) / (size_ * size_ * problem_.size()) + a.load * b.load;
}

/// Of z + C W xi by the points' unknowns.
void CurveEquations::fill_jacobian(const CurveState& at, Eigen::Ref<DenseMatrix> jacobian) const {
  const DenseMatrix& a = problem_.a;
  for (int p = 0; p < problem_.size(); ++p) {
    jacobian.col(p) = a.col(p) * (at.upright(p) ? 1.0 / a(p, p) : at.curvature[p]);
    if (!at.upright(p)) jacobian(p, p) += 1.0;
  }
}

std::optional<CurveTangent> CurveEquations::tangent(const CurveState& at) const {
  const int n = problem_.size();
  DenseMatrix jacobian(n, n);
  fill_jacobian(at, jacobian);
  CurveTangent out;
  out.way = DenseLu(jacobian).solve(db_);
  const double length = std::hypot(out.way.norm() / (size_ * std::sqrt(1.0 * n)), 1.0);
  out.way /= length, out.load = 1.0 / length;
  if (!out.way.allFinite() || !std::isfinite(length)) return std::nullopt;
  return out;
}

std::optional<CurveTangent> CurveEquations::tangent(const CurveState& at,
                                                    const CurveTangent& before) const {
  auto out = tangent(at);
  if (out && cosine(*out, before) < 0.0) out->reverse();
  return out;
}

/// What the unknowns and the load change by: the linearised equations, with a row that keeps the
/// change at right angles to the tangent.
Vector CurveEquations::correction(const CurveState& at, const CurveTangent& tangent,
                                  const Vector& error) const {
  const int n = problem_.size();
  const double weight = 1.0 / (size_ * size_ * n);
  DenseMatrix bordered(n + 1, n + 1);
  fill_jacobian(at, bordered.topLeftCorner(n, n));
  bordered.topRightCorner(n, 1) = -db_;
  bordered.bottomLeftCorner(1, n) = weight * tangent.way.transpose();
  bordered(n, n) = tangent.load;
  Vector right(n + 1);
  right.head(n) = -error;
  right[n] = 0.0;
  return DenseLu(bordered).solve(right);
}

bool CurveEquations::correct(CurveState& at, const CurveTangent& tangent) const {
  const int n = problem_.size();
  double last = infinity;
  for (int k = 0; k < most_corrections_to_curve; ++k) {
    problem_.take_slopes(at);
    const Vector f = at.z + problem_.a * at.xi - b0_ - at.load * db_;
    const double error = f.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(error)) return false;
    if (error <= 1e-14 * size_ || (error <= 1e-12 * size_ && error > 0.1 * last)) return true;
    if (error > last) return false;
    last = error;
    const Vector x = correction(at, tangent, f);
    if (!x.allFinite()) return false;
    for (int p = 0; p < n; ++p) problem_.move(at, p, x[p]);
    at.load += x[n];
  }
  return last <= 1e-10 * size_;
}

} // namespace hvi::solver
