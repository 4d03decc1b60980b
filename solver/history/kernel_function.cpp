// Calls of a kernel q(t, lag), at one point and on batches.
#include "solver/history/kernel_function.hpp"

#include <algorithm>
#include <array>

namespace hvi::solver {

KernelFunction::KernelFunction(const Expr& expression, Origin origin) {
  tape_ = compile(std::span<const Expr>(&expression, 1));
  for (const Slot s : tape_.inputs) {
    if (s != slot::t && s != slot::lag) {
      throw Failure(FailureKind::bad_kernel, origin,
                    "a memory kernel may depend on the time and the lag only");
    }
    reads_time_ = reads_time_ || s == slot::t;
  }
}

double KernelFunction::operator()(double t, double lag) const {
  std::array<double, 2> values{};
  for (std::size_t i = 0; i < tape_.inputs.size(); ++i) {
    values[i] = tape_.inputs[i] == slot::t ? t : lag;
  }
  return evaluate_one(tape_, std::span<const double>(values.data(), tape_.inputs.size()),
                      workspace_);
}

void KernelFunction::evaluate(double t, std::span<const double> lags, std::span<double> out) const {
  times_.assign(reads_time_ ? lags.size() : 0, t);
  evaluate(times_, lags, out);
}

void KernelFunction::evaluate(std::span<const double> times, std::span<const double> lags,
                              std::span<double> out) const {
  std::array<const double*, 2> inputs{};
  for (std::size_t i = 0; i < tape_.inputs.size(); ++i) {
    inputs[i] = tape_.inputs[i] == slot::t ? times.data() : lags.data();
  }
  hvi::solver::evaluate(tape_, std::span<const double* const>(inputs.data(), tape_.inputs.size()),
                        lags.size(), out, workspace_);
}

} // namespace hvi::solver
