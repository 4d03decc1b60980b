// The interior part of a Cholesky factor once more, rounded to single precision and laid out in the
// order in which the sweeps read it. For corrections whose true residual is known (SweepStorage).
#pragma once

#include "solver/linear/supernodes.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// L = U D with D the diagonal of L and U of unit diagonal, so that no unit system leaves the range
/// of a float. The columns of a panel are cut into blocks of 8 (at the end 4, 2, 1). Of each block
/// the inverse of its triangle is stored, then the rows below in tiles of 8: one linear stream of
/// floats, forward in one sweep and backward in the other. The arithmetic is double.
class PackedFactor {
public:
  /// Rounds a factor of this structure. False when an entry is beyond a float; then it is empty.
  bool pack(const Supernodes& structure, const double* values);
  void clear() { *this = {}; }
  bool empty() const { return structure_ == nullptr; }

  /// y_I := D^-2 U_II^-1 y_I, y_c := y_c - L_cI (L_II^-1 y_I).
  void forward(double* y);
  /// x_I := U_II^-T (y_I - U_cI^T x_c) for the y of `forward`, x_c given in x.
  void backward(const double* y, double* x);
  double bytes() const;

private:
  const Supernodes* structure_ = nullptr;
  std::vector<float> values_;
  std::vector<std::size_t> end_; ///< of a panel's values
  std::vector<double> inverse_square_, work_;
};

} // namespace hvi::solver
