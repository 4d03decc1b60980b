// A square matrix that is asked for what it makes of vectors. Who holds its rows, this process or
// several, is no affair of the caller.
#pragma once

#include "solver/linear/pieces.hpp"
#include "solver/linear/sparse.hpp"

#include <cstdint>
#include <functional>
#include <span>

namespace hvi::solver {

class MatrixRows {
public:
  virtual ~MatrixRows() = default;
  virtual int size() const = 0;
  virtual void apply(const Vector& x, Vector& y) const = 0;           ///< y = A x
  virtual void apply_magnitude(const Vector& x, Vector& y) const = 0; ///< y = |A| |x|
  virtual Vector diagonal() const = 0;
  /// own_stiffness (own_stiffness.hpp).
  virtual Vector own_stiffness() const = 0;
  /// |A_ii| max |x_j| over the columns j of row i that are of its own unknown: the size of the
  /// row's terms in axes that are turned. As a function of i, while x lives.
  virtual std::function<double(int)> whole_sizes(const Vector& x) const = 0;
  virtual Pieces pieces() const = 0; ///< what its entries couple
};

/// All rows are here.
class HeldRows final : public MatrixRows {
public:
  /// Keeps references. `of_unknown`: by row, which of several unknowns it is of; empty: there is
  /// one.
  HeldRows(const SparseMatrix& a, std::span<const std::uint8_t> of_unknown)
      : a_(a), of_unknown_(of_unknown) {}
  int size() const override { return static_cast<int>(a_.rows()); }
  void apply(const Vector& x, Vector& y) const override { y.noalias() = a_ * x; }
  void apply_magnitude(const Vector& x, Vector& y) const override;
  Vector diagonal() const override { return a_.diagonal(); }
  Vector own_stiffness() const override;
  std::function<double(int)> whole_sizes(const Vector& x) const override;
  Pieces pieces() const override { return Pieces(a_); }

private:
  const SparseMatrix& a_;
  std::span<const std::uint8_t> of_unknown_;
};

} // namespace hvi::solver
