// The points' compliance and their curve (point_curve.hpp).
#include "solver/inequality/point_curve.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
/// Beyond these the dense compliance of the points takes too much room or time.
constexpr int most_points = 1200;
constexpr double most_entries = 2.5e7;
} // namespace

bool PointCurve::serves(const ReducedOperator& s) const {
  return s.symmetric() && points_.size() <= most_points &&
         1.0 * points_.unknowns * points_.rows <= most_entries &&
         std::ranges::all_of(points_.data, [](const PointData& q) { return q.rows == 1; });
}

bool PointCurve::prepare(const ReducedOperator& s, const std::function<void()>& before_solve) {
  graphs_.clear();
  for (const PreparedLaw& law : points_.laws.all()) graphs_.emplace_back(law);
  if (curve_) return true;
  moved_.clear();
  for (int p = 0; p < points_.size(); ++p)
    if (SparseMatrix::InnerIterator(points_.g, points_[p].first)) moved_.push_back(p);
  std::optional<DenseMatrix> c = compliance(s, before_solve);
  if (!c) return false;
  curve_.emplace(std::move(*c), curve_points());
  return true;
}

std::vector<CurvePoint> PointCurve::curve_points() const {
  std::vector<CurvePoint> all;
  for (const int p : moved_) all.push_back({&graphs_[points_[p].law], points_[p].weight});
  return all;
}

Vector PointCurve::on_curve(const Vector& rows) const {
  Vector out(moved_.size());
  for (std::size_t k = 0; k < moved_.size(); ++k) out[k] = rows[points_[moved_[k]].first];
  return out;
}

Vector PointCurve::forces(const Vector& xi) const {
  Vector out = on_curve(xi);
  for (std::size_t k = 0; k < moved_.size(); ++k) out[k] *= points_[moved_[k]].weight;
  return out;
}

Vector PointCurve::multipliers(const Vector& force) const {
  Vector out = Vector::Zero(points_.rows);
  for (std::size_t k = 0; k < moved_.size(); ++k)
    out[points_[moved_[k]].first] = force[k] / points_[moved_[k]].weight;
  return out;
}

std::optional<DenseMatrix> PointCurve::compliance(const ReducedOperator& s,
                                                  const std::function<void()>& before_solve) {
  const SparseMatrix& g = points_.g;
  const auto count = static_cast<int>(moved_.size());
  Vector column(points_.unknowns), right(points_.unknowns);
  response_.resize(points_.unknowns, count);
  for (int p = 0; p < count; ++p) {
    if (before_solve) before_solve();
    right.setZero();
    for (SparseMatrix::InnerIterator it(g, points_[moved_[p]].first); it; ++it)
      right[it.col()] += it.value();
    s.solve(right, column);
    response_.col(p) = column;
  }
  DenseMatrix out(count, count);
  for (int p = 0; p < count; ++p) {
    out.row(p).setZero();
    for (SparseMatrix::InnerIterator it(g, points_[moved_[p]].first); it; ++it)
      out.row(p) += it.value() * response_.row(it.col());
  }
  if (count == 0 || !out.allFinite() || !(out.diagonal().minCoeff() > 0.0)) return {};
  return out;
}

Vector PointCurve::start(const StepStart& start) const {
  Vector z0 = on_curve(start.z);
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const int p = moved_[k];
    const PreparedLaw& law = points_.law(p);
    const int state = start.state[p];
    if (!law.valid_state(state)) continue;
    if (state < 0) z0[k] = 0.0;
    if (state >= 0 && state % 2 == 1) {
      const double at_break = law.graph().breaks[state / 2];
      z0[k] = law.radial() ? std::copysign(at_break, z0[k]) : at_break;
    }
  }
  return z0;
}

CurveSolution PointCurve::solution(const CurveState& at, const Vector& free) const {
  CurveSolution out{free, at.z, at.xi, at.place};
  for (std::size_t k = 0; k < moved_.size(); ++k)
    out.c -= response_.col(k) * (points_[moved_[k]].weight * out.xi[k]);
  return out;
}

void PointCurve::go(const CurveSolution& to, Position& at) const {
  InequalityState state;
  state.c = to.c;
  at.load(state);
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const int p = moved_[k];
    const CurveGraph& g = graphs_[points_[p].law];
    at.xi[points_[p].first] = to.xi[k];
    at.places.state[p] = g.engine_state(to.places[k]);
    at.places.component[p] = g.component(to.places[k]);
  }
  at.enter_states();
}

} // namespace hvi::solver
