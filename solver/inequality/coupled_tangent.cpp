// Linearised coupled laws (coupled_tangent.hpp).
#include "solver/inequality/coupled_tangent.hpp"

namespace hvi::solver {

CoupledTangent::CoupledTangent(Position& at, const CoupledBounds& bounds, const ReducedOperator& s)
    : at_(at), bounds_(bounds), lu_(s.unsymmetric()) {}

/// H = sum_p w_p G_p^T D_p G_p, and w_t G_t^T e (d slope / d multiplier) D_n G_n for coupled
/// points.
void CoupledTangent::assemble() {
  const ContactPoints& points = at_.points;
  const SparseMatrix& g = points.g;
  entries_.clear();
  const auto add = [&](int row, int column, double factor) {
    if (factor == 0.0) return;
    for (SparseMatrix::InnerIterator i(g, row); i; ++i)
      for (SparseMatrix::InnerIterator j(g, column); j; ++j)
        entries_.emplace_back(static_cast<int>(i.col()), static_cast<int>(j.col()),
                              factor * i.value() * j.value());
  };
  for (int p = 0; p < points.size(); ++p) {
    const PointData& q = points[p];
    for (int a = 0; a < q.rows; ++a)
      for (int b = 0; b < q.rows; ++b)
        add(q.first + a, q.first + b, q.weight * q.share[a] * at_.places.d[p][3 * a + b]);
  }
  for (const CoupledBound& b : bounds_.all) {
    const PointData &q = points[b.point], &other = points[b.normal];
    const Small e = bounds_.slip(b);
    for (int a = 0; a < q.rows; ++a)
      add(q.first + a, other.first,
          q.weight * q.share[a] * e[a] * b.rate * at_.places.d[b.normal][0]);
  }
  matrix_.resize(points.unknowns, points.unknowns);
  matrix_.setFromTriplets(entries_.begin(), entries_.end());
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
    const Small v = at_.places.times_stiffness(p, points[p].of(dz)), x = points[p].of(xi);
    points[p].put(xi, {x[0] + v[0], x[1] + v[1], x[2] + v[2]});
  }
  for (const CoupledBound& b : bounds_.all)
    add_slip(b, b.rate * at_.places.d[b.normal][0] * dz[points[b.normal].first], xi);
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
  if (!lu_->factor(matrix_, {})) return false;
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
