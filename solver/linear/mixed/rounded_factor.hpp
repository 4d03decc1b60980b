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

  /// Factorisation::forward and Factorisation::back of one right-hand side with the columns of the
  /// interior, in `fine` or `single`. What a forward solve leaves in y_I is for one of these
  /// backward solves, until `complete` has made of it what the factor's own would have left.
  void forward(FactorPrecision precision, Vector& y);
  void back(FactorPrecision precision, Vector& y);
  void complete(Vector& y) const;

  /// Solves made here, bytes of the copy.
  FactorStatistics statistics() const;

private:
  void count(FactorPrecision precision);

  const Factorisation* of_ = nullptr;
  int factorisation_ = 0; ///< of of_, by its own count
  PackedFactor packed_;
  FactorStatistics counted_;
};

} // namespace hvi::solver
