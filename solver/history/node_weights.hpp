// Weights of the fields of a time tree in the memory at coming times.
#pragma once

#include "solver/history/past_weights.hpp"
#include "solver/history/time_tree.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

class NodeWeights {
public:
  /// Keeps references to the kernel and its moments.
  NodeWeights(const PreparedKernel& kernel, const ChebyshevMoments& moments, int order)
      : kernel_(kernel), moments_(moments), order_(order) {}
  void reset() { past_.reset(); }

  /// Of the nodes from `first` on, at the next time t.
  std::vector<std::vector<double>> of_nodes(const TimeTree& tree, const AcceptedSteps& accepted,
                                            std::size_t first, double t);
  /// Of one node at the times of the next steps, one after the other.
  std::vector<double> at_times(const TimeTree& tree, const AcceptedSteps& accepted,
                               const TimeNode& node, std::span<const double> times);
  /// Of u over the step that ends at t.
  Moments current(const AcceptedSteps& accepted, double t) {
    return near_(kernel_, t, 0, accepted.step_to(t));
  }

private:
  std::vector<double> of_raw(const TimeTree& tree, const AcceptedSteps& accepted,
                             const TimeNode& node, double t, std::size_t ahead);

  const PreparedKernel& kernel_;
  const ChebyshevMoments& moments_;
  int order_;
  WeightCache near_;
  PastWeights past_;
};

} // namespace hvi::solver
