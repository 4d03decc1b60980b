// Exact line search along a direction of a convex function.
#pragma once

#include <functional>

namespace hvi::solver {

/// A step with the slope along it reduced to a third or less, at most 1: regula falsi with
/// bisection. `slope` of the function at a step; monotone.
double line_search(const std::function<double(double)>& slope);

} // namespace hvi::solver
