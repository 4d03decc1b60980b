// The triangular solves of a Cholesky factor, read in reduced precision.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/mixed/packed_factor.hpp"
#include "solver/linear/mixed/precision.hpp"

namespace hvi::solver {

/// Stands beside a factorisation, which stays in double precision; S and the arithmetic do, too.
class RoundedFactor {
public:
  /// Rounds the factor, unless that was done before; `single` and `fine` share the copy. False
  /// where there is none: for LU, or with entries beyond the range of float.
  bool take(const Factorisation& of);
  void forget();

  /// Factorisation::reduce and Factorisation::back, in `fine` or `single`.
  void reduce(FactorPrecision precision, const Vector& b, Vector& r);
  void back(FactorPrecision precision, const Vector& c, Vector& x);
  /// Factorisation::kept of the last `reduce`.
  Vector kept() const;

  /// Solves made here, bytes of the copy.
  FactorStatistics statistics() const;

private:
  void count(FactorPrecision precision);

  const Factorisation* of_ = nullptr;
  int factorisation_ = 0; ///< of of_, by its own count
  PackedFactor packed_;
  Vector y_, x_; ///< in the order of elimination; y over the diagonal of L
  FactorStatistics counted_;
};

} // namespace hvi::solver
