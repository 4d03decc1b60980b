// Exact weights: integrals of q(t, .) over an interval of lags, with and without the affine weight.
#pragma once

#include "solver/history/breaks.hpp"
#include "solver/history/kernel_function.hpp"

#include <boost/math/quadrature/tanh_sinh.hpp>

#include <memory>
#include <string>

namespace hvi::solver {

/// zero = int q dlag, one = int q x dlag with x = (lag - low) / (high - low).
struct Moments {
  double zero = 0, one = 0;
};
inline Moments operator+(const Moments& a, const Moments& b) {
  return {a.zero + b.zero, a.one + b.one};
}

using TanhSinh = boost::math::quadrature::tanh_sinh<double>;

/// The exact weights of one kernel.
class KernelIntegral {
public:
  /// `singular_exponent` e < 1: q ~ lag^-e near lag 0 (0: bounded or logarithmic).
  KernelIntegral(const Expr& expression, const KernelFunction& kernel, const Breaks& breaks,
                 double singular_exponent, Origin origin, std::string name);
  /// Over lags [low, high], 0 <= low <= high. Throws Failure(bad_kernel) when not finite.
  Moments operator()(double t, double low, double high) const;

private:
  struct Piece; // [from, to] inside [low, high]
  struct Tally; // what could not be resolved, of all pieces
  Moments at_zero(double t, const Piece& piece, Tally& tally) const;
  Moments away(double t, const Piece& piece, Tally& tally) const;
  [[noreturn]] void refuse(double t, double low, double high, double at) const;

  Moments from_source(double t, const Piece& piece, Tally& tally) const;

  KernelFunction kernel_;
  std::shared_ptr<const KernelFunction> by_source_; ///< (t, s), where s = 0 may be singular
  Breaks breaks_;
  double exponent_;
  std::shared_ptr<TanhSinh> rule_; ///< its tables grow when asked for more: not const
  Origin origin_;
  std::string name_;
};

} // namespace hvi::solver
