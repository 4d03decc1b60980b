// What the laws take from the body (split_energy.hpp).
#include "solver/inequality/split_energy.hpp"

#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// Part of the body's stiffness that the laws are given at most.
constexpr double most_given = 0.9;
/// Points of convex laws take this much less of it.
constexpr double convex_share = 0.02;

/// The roots of what the points would take before it is made to fit.
Vector roots_of_shares(const DenseMatrix& c, const std::vector<PointEnergy>& points) {
  const auto n = static_cast<int>(points.size());
  Vector d(n);
  for (int p = 0; p < n; ++p)
    d[p] = (points[p].convex() ? convex_share : 1.0) / c.row(p).cwiseAbs().sum();
  return d.cwiseSqrt();
}

} // namespace

/// (C^-1 - D)^-1 = C (1 - D C)^-1, with the symmetric matrix 1 - D^1/2 C D^1/2 in its place.
std::optional<SplitEnergy> split_energy(const DenseMatrix& c, std::vector<PointEnergy> points,
                                        const Vector& b) {
  const Vector shares = roots_of_shares(c, points);
  const DenseMatrix m = shares.asDiagonal() * c * shares.asDiagonal();
  Vector probe = Vector::Ones(shares.size());
  for (int k = 0; k < 30; ++k) probe = (m * probe).normalized();
  double part = most_given / std::max(1e-300, probe.dot(m * probe));
  for (int tries = 0; tries < 40; ++tries, part *= 0.95) {
    DenseMatrix rest = -part * m;
    rest.diagonal().array() += 0.5 * (1.0 + most_given);
    if (!DenseCholesky(rest).positive()) continue;
    rest.diagonal().array() += 0.5 * (1.0 - most_given);
    const DenseCholesky factor(rest);
    const Vector root = std::sqrt(part) * shares;
    SplitEnergy out;
    out.d = root.cwiseAbs2();
    out.compliance = root.cwiseInverse().asDiagonal() * factor.solve(DenseMatrix(part * m)) *
                     root.cwiseInverse().asDiagonal();
    out.compliance = (0.5 * (out.compliance + out.compliance.transpose())).eval();
    if (!out.compliance.allFinite()) return std::nullopt;
    const Vector scaled = root.cwiseProduct(b);
    out.b = factor.solve(scaled).cwiseQuotient(root);
    out.shift = -0.5 * b.dot(out.d.cwiseProduct(out.b));
    out.points = std::move(points);
    for (std::size_t p = 0; p < out.points.size(); ++p)
      out.points[p].d = out.d[static_cast<Eigen::Index>(p)];
    return out;
  }
  return std::nullopt;
}

} // namespace hvi::solver
