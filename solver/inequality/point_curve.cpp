// The points' compliance and their curve (point_curve.hpp).
#include "solver/inequality/point_curve.hpp"

#include <cmath>

namespace hvi::solver {

namespace {
/// Beyond these the dense compliance of the points takes too much room or time.
constexpr int most_points = 1200;
constexpr double most_entries = 2.5e7;
} // namespace

bool PointCurve::prepare(const ReducedOperator& s) {
  graphs_.clear();
  for (const PreparedLaw& law : points_.laws.all()) graphs_.emplace_back(law);
  if (curve_) return true;
  if (!s.symmetric() || points_.size() > most_points ||
      1.0 * points_.unknowns * points_.rows > most_entries)
    return false;
  for (const PointData& q : points_.data)
    if (q.rows != 1) return false;
  std::optional<DenseMatrix> c = compliance(s);
  if (!c) return false;
  curve_.emplace(std::move(*c), curve_points());
  return true;
}

std::vector<CurvePoint> PointCurve::curve_points() const {
  std::vector<CurvePoint> all;
  for (const PointData& q : points_.data) all.push_back({&graphs_[q.law], q.weight});
  return all;
}

std::optional<DenseMatrix> PointCurve::compliance(const ReducedOperator& s) {
  const SparseMatrix& g = points_.g;
  const int count = points_.size();
  Vector column(points_.unknowns), right(points_.unknowns);
  response_.resize(points_.unknowns, count);
  for (int p = 0; p < count; ++p) {
    right.setZero();
    for (SparseMatrix::InnerIterator it(g, points_[p].first); it; ++it)
      right[it.col()] += it.value();
    s.solve(right, column);
    response_.col(p) = column;
  }
  DenseMatrix out(count, count);
  for (int p = 0; p < count; ++p) {
    out.row(p).setZero();
    for (SparseMatrix::InnerIterator it(g, points_[p].first); it; ++it)
      out.row(p) += it.value() * response_.row(it.col());
  }
  if (!out.allFinite() || !(out.diagonal().minCoeff() > 0.0)) return {};
  return out;
}

Vector PointCurve::start(const StepStart& start) const {
  Vector z0(points_.size());
  for (int p = 0; p < points_.size(); ++p) {
    z0[p] = start.z[points_[p].first];
    const PreparedLaw& law = points_.law(p);
    const int state = start.state[p];
    if (!law.valid_state(state)) continue;
    if (state < 0) z0[p] = 0.0;
    if (state >= 0 && state % 2 == 1) {
      const double at_break = law.graph().breaks[state / 2];
      z0[p] = law.radial() ? std::copysign(at_break, z0[p]) : at_break;
    }
  }
  return z0;
}

CurveSolution PointCurve::solution(const CurveState& at, const Vector& free) const {
  CurveSolution out{free, at.z, at.xi, at.place};
  for (int p = 0; p < points_.size(); ++p)
    out.c -= response_.col(p) * (points_[p].weight * out.xi[p]);
  return out;
}

void PointCurve::go(const CurveSolution& to, Position& at) const {
  at.load(InequalityState{});
  at.c = to.c;
  for (int p = 0; p < points_.size(); ++p) at.xi[points_[p].first] = to.xi[p];
  at.update_arguments();
  for (int p = 0; p < points_.size(); ++p) {
    const CurveGraph& g = graphs_[points_[p].law];
    at.places.state[p] = g.engine_state(to.places[p]);
    at.places.component[p] = g.component(to.places[p]);
  }
  at.enter_states();
  at.z_start = at.z;
}

} // namespace hvi::solver
