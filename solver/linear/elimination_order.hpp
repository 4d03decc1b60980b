// The order in which a factorisation eliminates the unknowns, and vectors in that order.
#pragma once

#include "solver/linear/basis_change.hpp"
#include "solver/linear/sparse.hpp"

#include <memory>
#include <stdexcept>
#include <vector>

namespace hvi::solver {

struct EliminationOrder {
  std::vector<int> unknown; ///< by position; the contact unknowns last, in their own order
  int interior = 0;         ///< positions before the first contact unknown
  /// u = T x, where not the u of the matrix are eliminated; null: they are.
  std::shared_ptr<const BasisChange> change{};

  int size() const { return static_cast<int>(unknown.size()); }
  int contacts() const { return size() - interior; }

  /// y = b, or T^T b, in this order: y[position] = b[unknown[position]].
  void gather(const Vector& b, Vector& y) const {
    if (change) return gather_changed(b, y);
    y.resize(size());
    for (int position = 0; position < size(); ++position) y[position] = b[unknown[position]];
  }
  /// The way back, from y in this order to u.
  void scatter(const Vector& y, Vector& u) const {
    u.resize(size());
    for (int position = 0; position < size(); ++position) u[unknown[position]] = y[position];
    if (change) change->to_old(u);
  }

private:
  void gather_changed(const Vector& b, Vector& y) const {
    Vector of_changed = b;
    change->transposed(of_changed);
    y.resize(size());
    for (int position = 0; position < size(); ++position)
      y[position] = of_changed[unknown[position]];
  }
};

/// Right-hand sides or solutions in the order of elimination, side by side: the numbers of one
/// unknown lie next to each other.
struct RightHandSides {
  double* values;
  /// Numbers of an unknown: 1, or a multiple of `at_once`, the last of them zeros that nobody asks
  /// for.
  int stride;
  int count; ///< right-hand sides

  /// What a triangular solve takes at once: one pack of the widest registers.
  static constexpr int at_once = 8;
  static constexpr int stride_of(int count) { return (count + at_once - 1) / at_once * at_once; }

  /// Of one right-hand side only.
  double* only() const {
    if (stride != 1) throw std::logic_error("a solve for one right-hand side is given several");
    return values;
  }

  RightHandSides(Vector& one) : values(one.data()), stride(1), count(1) {}
  /// A row for each right-hand side.
  RightHandSides(DenseMatrix& rows, int used)
      : values(rows.data()), stride(static_cast<int>(rows.rows())), count(used) {}
};

} // namespace hvi::solver
