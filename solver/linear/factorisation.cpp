// Solves in the numbering of K by any direct solver; see factorisation.hpp.
#include "solver/linear/factorisation.hpp"

#include <stdexcept>

namespace hvi::solver {
namespace {

RightHandSides several(DenseMatrix& y, std::size_t count) { return {y, static_cast<int>(count)}; }

void gather_each(const EliminationOrder& order, std::span<const Vector> b, DenseMatrix& y) {
  Vector one;
  for (std::size_t k = 0; k < b.size(); ++k) {
    order.gather(b[k], one);
    y.row(static_cast<Eigen::Index>(k)) = one.transpose();
  }
}

} // namespace

void forward(Factorisation& factor, const Vector& b, Vector& y, Vector& r) {
  factor.order().gather(b, y);
  factor.forward(y, Columns::interior);
  r = y.tail(factor.order().contacts());
}

void back(Factorisation& factor, const Vector& c, Vector& y, Vector& x) {
  y.tail(factor.order().contacts()) = c;
  factor.back(y, Columns::interior);
  factor.order().scatter(y, x);
}

void solve(Factorisation& factor, const Vector& b, Vector& x, Columns columns) {
  Vector y;
  factor.order().gather(b, y);
  factor.forward(y, columns);
  factor.back(y, columns);
  factor.order().scatter(y, x);
}

void forward(Factorisation& factor, std::span<const Vector> b, DenseMatrix& y,
             std::vector<Vector>& r) {
  const EliminationOrder& order = factor.order();
  const auto count = static_cast<int>(b.size());
  y.setZero(count == 1 ? 1 : RightHandSides::stride_of(count), order.size());
  if (order.change)
    gather_each(order, b, y);
  else
    for (int position = 0; position < order.size(); ++position)
      for (int k = 0; k < count; ++k) y(k, position) = b[k][order.unknown[position]];
  factor.forward(several(y, b.size()), Columns::interior);
  r.resize(b.size());
  for (int k = 0; k < count; ++k) r[k] = y.row(k).tail(order.contacts());
}

void back(Factorisation& factor, std::span<const Vector> c, DenseMatrix& y,
          std::vector<Vector>& x) {
  const EliminationOrder& order = factor.order();
  const auto count = static_cast<int>(c.size());
  if (y.rows() < count) throw std::logic_error("a backward solve before its forward solve");
  for (int k = 0; k < count; ++k) y.row(k).tail(order.contacts()) = c[k].transpose();
  factor.back(several(y, c.size()), Columns::interior);
  x.resize(c.size());
  for (Vector& one : x) one.resize(order.size());
  for (int position = 0; position < order.size(); ++position)
    for (int k = 0; k < count; ++k) x[k][order.unknown[position]] = y(k, position);
  if (order.change)
    for (Vector& one : x) order.change->to_old(one);
}

} // namespace hvi::solver
