// Linearised coupled laws (coupled_tangent.hpp).
#include "solver/inequality/coupled_tangent.hpp"

namespace hvi::solver {

CoupledTangent::CoupledTangent(Position& at, const CoupledBounds& bounds,
                               const StiffnessPattern& pattern, const ReducedOperator& s)
    : at_(at), bounds_(bounds), pattern_(pattern), lu_(s.unsymmetric()), plain_(pattern.zero()),
      by_bounds_(at.points.unknowns, at.points.unknowns) {}

/// H = sum_p w_p G_p^T D_p G_p, and w_t G_t^T e (d slope / d multiplier) D_n G_n for coupled
/// points.
void CoupledTangent::assemble() {
  const ContactPoints& points = at_.points;
  const SparseMatrix& g = points.g;
  pattern_.assemble(at_.places.d, plain_);
  entries_.clear();
  const auto add = [&](int row, int column, double factor) {
    if (factor == 0.0) return;
    for (SparseMatrix::InnerIterator i(g, row); i; ++i)
      for (SparseMatrix::InnerIterator j(g, column); j; ++j)
        entries_.emplace_back(static_cast<int>(i.col()), static_cast<int>(j.col()),
                              factor * i.value() * j.value());
  };
  for (const CoupledBound& b : bounds_.all) {
    const PointData &q = points[b.point], &other = points[b.normal];
    const Small e = bounds_.slip(b);
    for (int a = 0; a < q.rows; ++a)
      add(q.first + a, other.first,
          q.weight * q.share[a] * e[a] * b.rate * other.block(at_.places.d)[0]);
  }
  by_bounds_.setFromTriplets(entries_.begin(), entries_.end());
}

void CoupledTangent::add_slip(const CoupledBound& b, double size, Vector& xi) const {
  const PointData& q = at_.points[b.point];
  const Small e = bounds_.slip(b);
  for (int k = 0; k < q.rows; ++k) xi[q.first + k] += size * e[k];
}

/// How the multipliers change with the displacements.
void CoupledTangent::add_linear_change(const Vector& dc, Vector& xi) const {
  const ContactPoints& points = at_.points;
  const Vector dz = points.g * dc;
  for (int p = 0; p < points.size(); ++p) {
    const PointData& q = points[p];
    q.put(xi, q.of(xi) + at_.places.times_stiffness(p, q.of(dz)));
  }
  for (const CoupledBound& b : bounds_.all) {
    const PointData& normal = points[b.normal];
    add_slip(b, b.rate * normal.block(at_.places.d)[0] * dz[normal.first], xi);
  }
}

bool CoupledTangent::step(CoupledStep& out, InequalityReport& report) {
  const ContactPoints& points = at_.points;
  out.xi = at_.xi;
  for (int p = 0; p < points.size(); ++p) points[p].put(out.xi, at_.places.on_tangent(p, at_.z));
  for (const CoupledBound& b : bounds_.all)
    add_slip(b, b.rate * (out.xi[points[b.normal].first] - b.multiplier), out.xi);
  at_.balance.product.update(at_.c);
  const Vector& residual = at_.balance.residual(out.xi);
  assemble();
  ++report.factorisations, ++report.iterations;
  if (!lu_->factor(plain_ + by_bounds_, {})) return false;
  lu_->solve(residual, out.c);
  if (!out.c.allFinite()) return false;
  add_linear_change(out.c, out.xi);
  return true;
}

bool CoupledTangent::by_share(CoupledStep& out) const {
  out.xi.setZero(at_.points.rows);
  for (const CoupledBound& b : bounds_.all) // bounds know share times the multiplier
    add_slip(b, b.rate * b.multiplier / bounds_.share(), out.xi);
  const Vector force = -(at_.points.force_of * out.xi);
  lu_->solve(force, out.c);
  add_linear_change(out.c, out.xi);
  return out.c.allFinite();
}

} // namespace hvi::solver
