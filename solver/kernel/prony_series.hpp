// A Prony series, the kernel of a material made of springs and dashpots.
#pragma once

#include "solver/kernel/expr.hpp"

#include <vector>

namespace hvi::solver {

/// constant + sum_i weights[i] exp(-lag / times[i]).
struct PronySeries {
  double constant = 0;
  std::vector<double> weights, times;
  double value(double lag) const;
};

/// The series of what stands for the lag.
Expr expression(const PronySeries& series, const Expr& lag);

} // namespace hvi::solver
