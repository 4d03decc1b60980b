// Where a kernel has kinks or jumps: the zeros of everything it switches on. Read off the
// expression, so that integrals can be split exactly there.
#pragma once

#include "solver/history/kernel_function.hpp"

#include <optional>
#include <vector>

namespace hvi::solver {

/// time * t + lag * lag + constant.
struct AffineForm {
  double time = 0, lag = 0, constant = 0;
};
/// The expression as an affine function of t and the lag, if it is one as written.
std::optional<AffineForm> affine_form(const Expr& expression);

/// The break lags of a kernel.
class Breaks {
public:
  Breaks(const Expr& expression, Origin origin);
  bool empty() const { return lines_.empty() && fixed_.empty() && curves_.empty(); }
  /// Lags in (low, high) at which q(t, .) may have a kink or jump, sorted.
  std::vector<double> inside(double t, double low, double high) const;
  /// Some are found by search, which a long interval may hide.
  bool searched() const { return !curves_.empty(); }
  /// A power, quotient, root or logarithm of s = t - lag may be singular at s = 0.
  bool singular_at_source_zero() const { return source_zero_; }

private:
  struct Line {
    double per_time, at; ///< break at lag = per_time * t + at
  };
  void collect(const Expr& expression, Origin origin);
  void add_switch(const Expr& value, Origin origin);
  void add_singularity(const Expr& value);
  static void add_roots(const KernelFunction& curve, double t, double low, double high,
                        std::vector<double>& found);

  std::vector<Line> lines_;
  std::vector<double> fixed_; ///< lines with per_time = 0, sorted
  bool source_zero_ = false;
  std::vector<KernelFunction> curves_; ///< what is not affine: searched by sign changes
};

} // namespace hvi::solver
