// The times of a run, and the lengths of its steps.
#pragma once

#include "solver/plan/problem.hpp"

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
  /// The length of the shortest step; equal steps have one length.
  double shortest() const;

private:
  bool is_static_;
  std::vector<double> times_, lengths_;
};

} // namespace hvi::solver
