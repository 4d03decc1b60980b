// What an audit compares a memory with: sums over the past and weights by a quadrature of their
// own, which shares neither rule nor panels nor tolerances with the routes.
#pragma once

#include "solver/history/prepared.hpp"
#include "solver/history/steps.hpp"

#include <map>
#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

class StateWriter;
class StateReader;

/// int over the lags (0, k) of q(t, .) by a composite Gauss rule on panels that grow twofold from
/// both ends, cut at breaks and at what the proof of `resolved_edges` finds.
/// Near a weak singularity lag = k v^(1/(1 - e)).
Moments independent_integral(const PreparedKernel& kernel, double t, double k);

/// Stores few values of each step and sums them with weights of its own: 6-point Gauss rules on
/// pieces that are halved until the two halves agree with the whole.
class IndependentSum {
public:
  IndependentSum(const PreparedKernel& kernel, std::size_t n, int order, double expected_step);
  void start(double t0, std::span<const double> u0);
  void commit(double t, std::span<const double> u);
  /// As History::rhs.
  void sum(double t_new, std::span<double> out);
  double bytes() const;
  void save(StateWriter& out) const;
  void restore(StateReader& in);

private:
  struct Interval {
    double low, high; ///< lags
  };
  void integrate(double t, std::span<const Interval> intervals, std::span<Moments> out);
  std::vector<double> find_cuts(double t, double low, double high) const;
  const std::vector<double>& cuts(double t, const Interval& interval);
  bool plain(double t, const Interval& interval);
  Moments weight(double t, const Interval& interval);
  Moments from_source(double t, double from, const Interval& interval) const;
  bool reaches_source_zero(double t, const Interval& interval) const;

  PreparedKernel kernel_;
  std::size_t n_;
  int order_;
  AcceptedSteps accepted_;
  std::shared_ptr<const KernelFunction> by_source_; ///< where q is singular at s = 0
  std::vector<double> times_, values_;              ///< n values a step; order 1: and at t0
  std::vector<double> cuts_;                        ///< of the sum at hand
  std::map<int, std::vector<double>> octave_cuts_;  ///< of a convolution: of the lags (0, 2^k)
  std::vector<Moments> by_index_;                   ///< of a convolution on equal steps
  std::vector<double> lags_, kernel_values_, node_weights_;
};

} // namespace hvi::solver
