// The matrices of all steps of a run as points, and the search for the worst of them.
//
// Step n has the matrix  K_n = sum_f c_f(n) F_f  with F = B, A, E_1, ... and
// c(n) = (1, rate(n), w0_1(n), ...). What is asked of it, for instance that K_n - D be positive
// definite, is answered on boxes of c: the c with lambda_max(D, sym K(c)) <= r are a convex set, so
// that a box is no worse than the worst of its corners.
#pragma once

#include "solver/plan/problem.hpp"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace hvi::solver {

/// The c(n) that differ, a column each, with the first step that has it.
struct StepWeights {
  std::vector<int> steps;
  std::vector<Eigen::VectorXd> c;
};
/// By exact integrals, as the direct sum has them. Static: one, (1, 0, ...).
StepWeights step_weights(const Problem& problem);
/// Have all steps surely one matrix? Without an integral: backward Euler with equal steps and
/// kernels written without t.
bool surely_one_matrix(const Problem& problem);

/// int |q_m(t_n, s)| ds over the last interval, for every column of `weights` and memory m.
std::vector<Eigen::VectorXd> absolute_weights(const Problem& problem, const StepWeights& weights);

struct WorstStep {
  int step = 1;
  double ratio = 0.0; ///< of that step
  double bound = 0.0; ///< no step exceeds it
  bool within_budget = true;
};

/// The step whose ratio is the largest, to `room` (relative) or surely below 1. `ratio` must be
/// quasi-convex (see above), and may be infinite; it is asked at most `most` times, and then
/// `bound` is what is known. Best bound first: halves the box whose bound is worst.
WorstStep worst_step(const StepWeights& weights,
                     const std::function<double(const Eigen::VectorXd&)>& ratio, int most);

} // namespace hvi::solver
