// A kernel as something to call: the compiled tape of an expression in (t, lag).
#pragma once

#include "solver/common/failure.hpp"
#include "solver/history/function_table.hpp"
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

private:
  void tabulate(const Expr& expression);

  Tape tape_;
  /// With tables: first their arguments, then the kernel that reads their values as slots.
  Tape arguments_, with_values_;
  std::vector<std::shared_ptr<FunctionTable>> tables_;
  bool reads_time_ = false;
  mutable TapeWorkspace workspace_;
  mutable std::vector<double> times_, table_values_;
};

} // namespace hvi::solver
