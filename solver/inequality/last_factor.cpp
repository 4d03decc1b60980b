// The last factor (last_factor.hpp).
#include "solver/inequality/last_factor.hpp"

#include <algorithm>

namespace hvi::solver {

bool holds_all(const PointMatrices& d, const PointData& q) {
  const auto m = q.block(d);
  for (int i = 0; i < q.rows; ++i)
    for (int j = 0; j < q.rows; ++j) {
      const double v = m[q.rows * i + j];
      if (i == j ? !(v * q.local > holding_stiffness) : v != 0.0) return false;
    }
  return true;
}

LastFactor::LastFactor(const ContactPoints& points, const StiffnessPattern& pattern,
                       ReducedOperator& s)
    : points_(points), pattern_(pattern), op_(s), h_(pattern.zero()) {}

/// Those of points that are held in all rows and have them to themselves.
void LastFactor::find_held_unknowns() {
  held_.clear();
  for (int p = 0; p < points_.size(); ++p) {
    const PointData& q = points_[p];
    if (!q.exclusive || !holds_all(d_, q)) continue;
    for (int row = q.first; row < q.first + q.rows; ++row)
      for (SparseMatrix::InnerIterator it(points_.g, row); it; ++it)
        if (it.value() != 0.0) held_.push_back(static_cast<int>(it.col()));
  }
  std::sort(held_.begin(), held_.end());
}

bool LastFactor::factor() {
  pattern_.assemble(d_, h_);
  find_held_unknowns();
  ++number_;
  return made_ = op_.factor(h_, held_);
}

bool LastFactor::make(const PointMatrices& d, InequalityReport& report) {
  if (is_of(d)) return true;
  ++report.factorisations;
  d_ = d;
  return factor();
}

bool LastFactor::make_other(const SparseMatrix& h) {
  made_ = false;
  ++number_;
  return op_.factor(h, {});
}

void LastFactor::remake(PointMatrices d, bool made) {
  d_ = std::move(d);
  made_ = false;
  if (made) factor();
}

bool LastFactor::solve(const Position& at, const Vector& residual, bool /*settled*/,
                       InequalityReport& report, TangentStep& out) {
  if (!make(at.places.d, report)) return false;
  out.product_known = false;
  out.rest.setZero(residual.size());
  op_.solve(residual, out.dc);
  return true;
}

} // namespace hvi::solver
