// Checks common to the routes.
#include "solver/history/prepared.hpp"

#include "solver/history/cancellation.hpp"

namespace hvi::solver {

double PreparedKernel::norm(double t0, double horizon) const {
  if (terms)
    if (const auto exact = prony_integral(terms->terms, horizon)) return *exact;
  return memory_norm(spec.expression, traits, t0, horizon);
}

PreparedKernel prepare_kernel(const KernelSpec& kernel, const HistoryOptions& options) {
  KernelSpec spec = kernel;
  spec.expression = without_cancellation(kernel.expression);
  const double t0 = options.times.empty() ? 0.0 : options.times.front();
  return {spec, study_kernel(spec, options.horizon, t0)};
}

void check_step(const PreparedKernel& kernel, double t_before, double t_new) {
  if (!(t_new > t_before) || !std::isfinite(t_new)) {
    throw Failure(FailureKind::bad_value, kernel.spec.origin,
                  "the times of a memory must increase: " + std::to_string(t_before) +
                      " is followed by " + std::to_string(t_new));
  }
}

void check_field(const PreparedKernel& kernel, std::size_t expected, std::size_t given) {
  if (expected != given) {
    throw Failure(FailureKind::bad_value, kernel.spec.origin,
                  "a memory of " + std::to_string(expected) + " unknowns was given " +
                      std::to_string(given));
  }
}

} // namespace hvi::solver
