// Numerical checks behind the symbolic findings on a kernel.
#pragma once

#include "solver/history/history.hpp"
#include "solver/history/recognise.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Points (t - t0, lag), 0 < lag <= t - t0 <= horizon: lags log-spaced down to 1e-12 of the horizon
/// and evenly spaced, for several times.
std::vector<std::pair<double, double>> sample_points(double horizon);

struct VerifiedTerms {
  ExponentialTerms terms;
  double error = 0;    ///< largest difference to the kernel at the sample points
  double integral = 0; ///< of the difference over the lags up to the latest times, from them
};
/// The kernel as an exponential sum, if it is one symbolically and also at sample points, and if
/// its factors g and h stay far from overflow.
std::optional<VerifiedTerms> verified_terms(const Expr& expression, double horizon, double t0 = 0);

/// Everything found out about a kernel.
struct StudiedKernel {
  KernelTraits traits;
  std::optional<VerifiedTerms> terms; ///< of an exponential sum
};
/// For times t0 < t <= t0 + horizon.
StudiedKernel study_kernel(const KernelSpec& kernel, double horizon, double t0 = 0);

/// `kernel_traits` for times t0 < t <= t0 + horizon.
KernelTraits kernel_traits(const Expr& expression, double horizon, double t0);

/// int_0^length |q(lag)| dlag of a Prony series, real exponentials whose factors have one sign;
/// none for other sums.
std::optional<double> prony_integral(const ExponentialTerms& terms, double length);

/// int_0^length |q(t, lag)| dlag.
double absolute_integral(const Expr& expression, double singular_exponent, double t, double length);

} // namespace hvi::solver
