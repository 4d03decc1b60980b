// A kernel as something to call: the compiled tape of an expression in (t, lag).
#pragma once

#include "solver/common/failure.hpp"
#include "solver/history/function_table.hpp"
#include "solver/history/strip.hpp"
#include "solver/kernel/tape.hpp"

#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

/// q(t, lag), lag = t - s. In batches, Mittag-Leffler functions of fixed parameters come from
/// tables that agree with them to rounding; single values are exact. Not for several threads at
/// once: the workspace is shared by the calls.
class KernelFunction {
public:
  /// Throws Failure(bad_kernel) when the expression reads anything but slot::t and slot::lag.
  KernelFunction(const Expr& expression, Origin origin);

  double operator()(double t, double lag) const;
  /// out[i] = q(t, lags[i]).
  void evaluate(double t, std::span<const double> lags, std::span<double> out) const;
  /// out[i] = q(times[i], lags[i]).
  void evaluate(std::span<const double> times, std::span<const double> lags,
                std::span<double> out) const;
  bool convolution() const { return !reads_time_; }
  /// A bound of |q(t, .)| over a set of complex lags.
  Modulus modulus(double t, const Strip& lags) const;
  /// Adds the ends of panels between these lags on which q(t, .) is proved to be resolved by a few
  /// points: bounded on the ellipse around each by a multiple of its values, or as narrow as
  /// rounding. Nothing where an operation has no bound.
  void resolved_edges(double t, double low, double high, std::vector<double>& edges) const;

private:
  void tabulate(const Expr& expression);

  Tape tape_;
  /// With tables: first their arguments, then the kernel that reads their values as slots.
  Tape arguments_, with_values_;
  std::vector<std::shared_ptr<FunctionTable>> tables_;
  bool reads_time_ = false;
  mutable TapeWorkspace workspace_;
  mutable std::vector<double> times_, table_values_;
  mutable std::vector<Strip> strips_;
};

/// A function of one variable, compiled: the factors g(t) and h(s) of a separable kernel.
class LineFunction {
public:
  /// Of an expression in `variable` alone (else its values are no numbers).
  LineFunction(const Expr& expression, Slot variable);
  double operator()(double x) const;
  Modulus modulus(const Strip& x) const;
  bool constant() const { return tape_.inputs.empty(); }

private:
  Tape tape_;
  bool other_ = false; ///< reads something else
  mutable TapeWorkspace workspace_;
  mutable std::vector<Strip> strips_;
};

} // namespace hvi::solver
