// Chebyshev moments of u over blocks of time: M_k = int_a^b T_k(x(s)) u(s) ds, x(a) = -1, x(b) = 1.
// They know nothing of the kernel; q(t, .) interpolated in Chebyshev polynomials reads them.
#pragma once

#include "solver/history/kernel_function.hpp"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace hvi::solver {

struct TimeBlock {
  double a = 0, b = 0;
};

/// The algebra of `count` moments.
class ChebyshevMoments {
public:
  explicit ChebyshevMoments(int count);
  int count() const { return count_; }

  /// Lags t - s of the interpolation nodes of a block, added to `lags`.
  void add_nodes(const TimeBlock& block, double t, std::vector<double>& lags) const;
  /// Weights of the moments from values of q at the nodes.
  void coefficients(const double* values, double* weights) const { apply(values, weights); }

  /// Rows k: the moments of values at the ends of the intervals `times` within `block`.
  /// Order 0: column j is the value on interval j; order 1: the value at times[j].
  Eigen::MatrixXd of_intervals(const TimeBlock& block, std::span<const double> times,
                               int order) const;
  /// T_k(x_parent) = sum_j C(k, j) T_j(x_child): the moments of a child, seen from its parent.
  Eigen::MatrixXd to_parent(const TimeBlock& child, const TimeBlock& parent) const;

  /// max |q(t, .) - its interpolant| over points between the nodes; not finite where q is not.
  double interpolation_error(const KernelFunction& kernel, const TimeBlock& block, double t) const;

private:
  void apply(const double* values, double* weights) const;
  int count_;
  std::vector<double> nodes_;
  Eigen::MatrixXd to_coefficients_;  ///< values at nodes -> Chebyshev coefficients
  std::vector<double> check_points_; ///< in (-1, 1), ends included
  Eigen::MatrixXd to_checks_;        ///< values at nodes -> values at check points
};

/// target (rows x n) += matrix * source (columns x n), fields one after the other.
void add_product(const Eigen::MatrixXd& matrix, const double* source, double* target,
                 std::size_t n);

} // namespace hvi::solver
