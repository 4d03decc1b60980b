// A second copy of the interior part of a Cholesky factor in reduced precision, 32 or 48 bits an
// entry, stored in the order in which the triangular solves read it. For corrections whose true
// residual is known (precision.hpp).
#pragma once

#include "solver/linear/large_pages.hpp"
#include "solver/linear/supernodes.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// L = U D with D the diagonal of L and U of unit diagonal, so that no unit system leaves the range
/// of a float. The columns of a panel are cut into blocks of 8 (at the end 4, 2, 1). Of each block
/// the inverse of its triangle is stored, then the rows below in tiles of 8: one linear stream of
/// floats, read forward by the forward solve and backward by the backward solve. A second stream
/// holds the sixteen bits that follow those of the floats. The arithmetic is double.
class PackedFactor {
public:
  /// Rounds a factor of this structure. False when an entry is beyond a float; then it is empty.
  bool pack(const Supernodes& structure, const double* values);
  void clear() { *this = {}; }
  bool empty() const { return structure_ == nullptr; }

  /// y_I := D^-2 U_II^-1 y_I, y_c := y_c - L_cI (L_II^-1 y_I). `fine`: with 48 bits, else 32.
  void forward(bool fine, double* y);
  /// x_I := U_II^-T (y_I - U_cI^T x_c) for the y of `forward`, with y_I where x_I is to stand, and
  /// x_c given.
  void backward(bool fine, double* x);
  double bytes() const;
  /// That a triangular solve reads.
  double bytes_read(bool fine) const;

private:
  std::size_t lay_out(const Supernodes& structure);

  const Supernodes* structure_ = nullptr;
  LargeVector<float> values_;
  LargeVector<std::int16_t> rests_; ///< of the values, in units of 2^-39 of their power of two
  std::vector<std::size_t> end_;    ///< of a panel's values
  std::vector<double> inverse_square_, work_;
};

} // namespace hvi::solver
