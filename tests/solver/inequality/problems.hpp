// Reduced problems for the tests: builders, and a certificate recomputed without the solver.
#pragma once

#include "solver/inequality/inequality.hpp"
#include "tests/solver/law/laws.hpp"

#include <Eigen/Eigenvalues>

#include <memory>
#include <random>

namespace hvi::solver::test {

/// A problem that owns its laws. Points are added one by one; `finish` makes G.
struct Bench {
  std::vector<std::unique_ptr<Law>> owned;
  ReducedProblem problem;
  DenseMatrix s;
  Vector r;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> offsets;

  int law(LawSpec spec, const Point& x = {0.5, 0, 0}, double t = 0.25) {
    owned.push_back(std::make_unique<Law>(std::move(spec)));
    problem.laws.push_back(owned.back().get());
    problem.graphs.push_back(owned.back()->graph(x, t));
    return static_cast<int>(owned.size()) - 1;
  }
  int slope(const Expr& e, bool radial = false) { return law({"law", Origin{1}, radial, true, e}); }
  int potential(const Expr& e, bool radial = false) {
    return law({"law", Origin{1}, radial, false, e});
  }
  /// rows[k] lists (unknown, coefficient) of row k.
  void point(int law_index, double weight,
             const std::vector<std::vector<std::pair<int, double>>>& rows,
             std::vector<double> offset = {}) {
    ContactPoint p;
    p.law = p.graph = law_index;
    p.first_row = static_cast<int>(offsets.size());
    p.rows = static_cast<int>(rows.size());
    p.weight = weight;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (const auto& [unknown, v] : rows[k])
        entries.emplace_back(p.first_row + static_cast<int>(k), unknown, v);
      offsets.push_back(k < offset.size() ? offset[k] : 0.0);
    }
    problem.points.push_back(p);
  }
  void finish() {
    const auto rows = static_cast<int>(offsets.size());
    problem.g.resize(rows, s.rows());
    problem.g.setFromTriplets(entries.begin(), entries.end());
    problem.offset = Eigen::Map<Vector>(offsets.data(), rows);
  }
  /// sum m w G^T G with the laws' own m: the step margin is positive iff this is below S.
  DenseMatrix descent() const {
    DenseMatrix out = DenseMatrix::Zero(s.rows(), s.rows());
    const DenseMatrix g = problem.g;
    std::vector<double> m_of;
    for (const Law* law : problem.laws) m_of.push_back(law->constants({0.5, 0, 0}, 0.25).m);
    for (const ContactPoint& p : problem.points) {
      const double m = m_of[static_cast<std::size_t>(p.law)];
      const DenseMatrix rows = g.middleRows(p.first_row, p.rows);
      out += m * p.weight * rows.transpose() * rows;
    }
    return out;
  }
  /// Scales S so that lambda_max(descent, S) = ratio.
  void set_margin(double ratio) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<DenseMatrix> eigen(descent(), s,
                                                                      Eigen::EigenvaluesOnly);
    s *= eigen.eigenvalues().maxCoeff() / ratio;
  }
};

inline DenseMatrix random_spd(int n, double condition, std::mt19937& random) {
  std::normal_distribution<double> normal;
  DenseMatrix a(n, n);
  for (int i = 0; i < n * n; ++i) a.data()[i] = normal(random);
  const DenseMatrix q = a.householderQr().householderQ();
  Vector d(n);
  for (int i = 0; i < n; ++i) d[i] = std::pow(condition, -i / std::max(1.0, n - 1.0));
  const DenseMatrix s = q * d.asDiagonal() * q.transpose();
  return 0.5 * (s + s.transpose());
}

/// A chain of springs: the Schur complement of a 1D body, ill conditioned as meshes make it.
inline DenseMatrix chain(int n, double ground) {
  DenseMatrix s = DenseMatrix::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    s(i, i) = 2.0 + ground;
    if (i > 0) s(i, i - 1) = s(i - 1, i) = -1.0;
  }
  return s;
}

/// max of the residual's componentwise backward error and the scaled distance to the graph,
/// computed here from the definition: slopes of `known` at z, hulls of its limits at its breaks,
/// which count within `snap` of the displacements.
struct Certificate {
  double residual = 0.0, inclusion = 0.0;
};
inline Certificate recompute(const Bench& setup, const std::vector<const KnownLaw*>& known,
                             const InequalityState& state, double snap = 1e-12) {
  Certificate out;
  const ReducedProblem& problem = setup.problem;
  const DenseMatrix g = problem.g;
  Vector weighted = state.xi;
  for (const ContactPoint& p : problem.points) weighted.segment(p.first_row, p.rows) *= p.weight;
  const Vector residual = setup.s * state.c + g.transpose() * weighted - setup.r;
  const Vector size = setup.s.cwiseAbs() * state.c.cwiseAbs() +
                      g.cwiseAbs().transpose() * weighted.cwiseAbs() + setup.r.cwiseAbs();
  // Rows 0 = 0 hold rounding of the others: of a few terms, by half a unit in the last place each.
  const double noise = 0x1p-50 * size.maxCoeff();
  for (int i = 0; i < residual.size(); ++i)
    if (std::abs(residual[i]) > noise)
      out.residual = std::max(out.residual, std::abs(residual[i]) / size[i]);
  const Vector z = g * state.c + problem.offset;
  const double largest = state.xi.size() > 0 ? state.xi.lpNorm<Eigen::Infinity>() : 0.0;
  // Rounding of displacements: of the largest one, or of what the load would cause.
  const double eps = snap * (state.c.lpNorm<Eigen::Infinity>() +
                             setup.r.lpNorm<Eigen::Infinity>() / setup.s.diagonal().maxCoeff());
  for (const ContactPoint& p : problem.points) {
    const KnownLaw& law = *known[p.law];
    const bool radial = law.spec.radial;
    const Vector zp = z.segment(p.first_row, p.rows), xp = state.xi.segment(p.first_row, p.rows);
    const double r = radial ? zp.norm() : zp[0];
    double distance = 0.0, scale = std::max(largest, std::abs(law.slope(0.0)));
    if (radial && r <= eps) {
      distance = std::max(0.0, xp.norm() - std::abs(law.slope(1e-14)));
    } else {
      double low = law.slope(r), high = low;
      for (const double b : law.breaks) {
        scale = std::max(
            {scale, std::abs(law.slope(b * (1 - 1e-15))), std::abs(law.slope(b * (1 + 1e-15)))});
        if (std::abs(r - b) > eps) continue;
        for (const double side : {b - 2 * eps, b + 2 * eps})
          low = std::min(low, law.slope(side)), high = std::max(high, law.slope(side));
      }
      const double along = radial ? xp.dot(zp) / r : xp[0];
      const double across = radial ? (xp - along * zp / r).norm() : 0.0;
      distance = std::hypot(std::max({0.0, low - along, along - high}), across);
    }
    if (distance > 0.0) out.inclusion = std::max(out.inclusion, distance / scale);
  }
  return out;
}

} // namespace hvi::solver::test
