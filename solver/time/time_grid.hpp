// Steps of a time grid, and the difference formula of each.
#pragma once

#include "solver/plan/plan.hpp"

#include <vector>

namespace hvi::solver {

/// The grid with its step lengths. Lengths that differ by the rounding of the grid's times only are
/// one length, so that a uniform grid has one matrix.
class TimeGrid {
public:
  explicit TimeGrid(const TimeSpec& spec);

  bool is_static() const { return is_static_; }
  int steps() const { return is_static_ ? 1 : static_cast<int>(times_.size()) - 1; }
  double t(int n) const { return is_static_ ? 0.0 : times_[n]; }
  double length(int n) const { return lengths_[n]; } ///< t_n - t_{n-1}, n >= 1; static: 1
  /// Relative rounding error of the step length: |t_n| eps / k, a few times.
  double rounding(int n) const;

  /// u'(t_n) = rate(n) d_n - carry(n) d_{n-1},  d_n = u_n - u_{n-1}.
  ///   backward Euler: 1/k, 0.   BDF2, w = k_n / k_{n-1}: (1 + 2 w) / ((1 + w) k), w^2 / ((1 + w)
  ///   k);
  /// its first step is backward Euler, whose single local error of order k^2 keeps the second order
  /// (M. Crouzeix, F. J. Lisbona, The convergence of variable-stepsize, variable-formula, multistep
  /// methods, SIAM J. Numer. Anal. 21 (1984) 512-534).
  double rate(int n) const;
  double carry(int n) const;
  /// How many factors are worth keeping: 1 when no step length occurs again after another one.
  int useful_factors() const { return useful_factors_; }
  /// The length of the shortest step; equal steps have one length.
  double shortest() const;

private:
  int count_factors() const;
  double ratio(int n) const { return lengths_[n] / lengths_[n - 1]; }
  bool second_order(int n) const { return scheme_ == Scheme::bdf2 && n > 1; }

  bool is_static_;
  Scheme scheme_;
  std::vector<double> times_, lengths_;
  int useful_factors_ = 1;
};

} // namespace hvi::solver
