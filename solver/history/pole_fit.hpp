// Sums of exponentials fitted to a kernel: candidates, elimination, refinement, verification.
#pragma once

#include "solver/history/kernel_samples.hpp"
#include "solver/history/recognise.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

/// exp(-decay lag) [cos, sin](frequency lag); frequency 0: one real exponential.
struct Pole {
  double decay = 0, frequency = 0;
  std::size_t fields() const { return frequency == 0 ? 1 : 2; }
};
std::size_t fields_of(const std::vector<Pole>& poles);

/// Candidate poles: log-spaced real decays from the slowest to the shortest lag.
std::vector<Pole> real_candidates(const KernelSamples& samples, double per_decade);
/// Poles found by ESPRIT on windows of length T/4^j, and decays around the frequencies found.
std::vector<Pole> oscillating_candidates(const PreparedKernel& kernel,
                                         const KernelSamples& samples);

/// Poles found by ESPRIT on the whole range: those of a kernel that is itself a short sum.
std::vector<Pole> window_candidates(const PreparedKernel& kernel, const KernelSamples& samples);

/// Weighted least squares of the coefficients, relative to the kernel's norm: a residual r bounds
/// the L1 error on the sample points by r * norm (Cauchy-Schwarz with the density of the samples).
class PoleFit {
public:
  /// `cap`: coefficients above cap * norm are penalised (they would cancel each other).
  PoleFit(const KernelSamples& samples, double tolerance, double cap);
  struct Solution {
    std::vector<Pole> poles;
    std::vector<double> coefficients; ///< one per field; scaled columns
    std::vector<double> loss;         ///< growth of the squared residual if a pole were removed
    double residual = 1;
  };
  Solution solve(const std::vector<Pole>& poles) const;
  /// Levenberg-Marquardt on decays and frequencies; stops when the residual is below `target`.
  Solution refine(Solution start, double target, int iterations) const;
  ExponentialTerms terms(const Solution& solution) const;

private:
  struct Scaled;
  struct Free;
  struct Linearised {
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd right, size; ///< size: norms of the columns of the free numbers
  };
  std::vector<Free> free_numbers(const std::vector<Pole>& poles) const;
  Linearised linearise(const Solution& at, const std::vector<Free>& free) const;
  Solution stepped(const Solution& from, const std::vector<Free>& free, Linearised& system,
                   double damping) const;
  Scaled columns(const std::vector<Pole>& poles, bool slopes) const;

  const KernelSamples& samples_;
  double ridge_;
  std::vector<double> row_weight_, right_;
};

struct FittedSum {
  ExponentialTerms terms;
  std::size_t fields = 0;
  double error = 0; ///< L1 error on [low, high] relative to int_0^high |q|, on a denser grid
};
/// The fit on [low, high], or the reason why there is none.
struct FitOutcome {
  std::optional<FittedSum> sum;
  std::string failure;
};
FitOutcome fit_exponentials(const PreparedKernel& kernel, double low, double high,
                            double tolerance);

/// int_low^high |q - sum| / int_0^high |q| on points other than those of any fit.
double fit_error(const PreparedKernel& kernel, const ExponentialTerms& terms, double low,
                 double high);

} // namespace hvi::solver
