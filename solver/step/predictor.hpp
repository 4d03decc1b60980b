// The warm start of a step on a uniform grid: an extrapolation of the last steps, and what is left
// to solve for.
#pragma once

#include "solver/linear/sparse.hpp"

#include <array>
#include <iosfwd>

namespace hvi::solver {

/// Extrapolates the increments d_j = u_j - u_{j-1} of steps with one and the same matrix K:
///
///   d* = 3 d_{n-1} - 3 d_{n-2} + d_{n-3},   K d* the same way,   xi* = 2 xi_{n-1} - xi_{n-2}
///
/// K d_j is what the certificate of step j computed, so that b - K d* costs no product. The
/// triangular solves then find d - d* only, for which a factor in reduced precision may do.
class Predictor {
public:
  /// Forgets everything: the matrix or the step length changed.
  void clear() { known_ = 0; }
  /// After an accepted step with the matrix of these coefficients: d, K d, xi. Takes K d and leaves
  /// any vector in its place.
  void note(const Vector& gamma, const Vector& d, Vector& kd, const Vector& xi);
  bool ready() const { return known_ >= depth; }
  /// Was that the matrix of the last step noted?
  bool knows(const Vector& gamma) const { return gamma_.size() == gamma.size() && gamma_ == gamma; }
  /// d = d*
  void predict(Vector& d) const;
  /// gap = rhs - K d*
  void predict_gap(const Vector& rhs, Vector& gap) const;
  void predict_multipliers(Vector& xi) const;

  void save(std::ostream& out) const;
  /// Throws where it is of other numbers of unknowns and multipliers.
  void restore(std::istream& in, Eigen::Index n_unknowns, Eigen::Index n_rows);

private:
  static constexpr int depth = 3;
  const Vector& back(const std::array<Vector, depth>& of, int j) const {
    return of[(newest_ + j) % depth];
  }
  Vector gamma_;
  std::array<Vector, depth> d_, kd_, xi_;
  int newest_ = 0, known_ = 0;
};

} // namespace hvi::solver
