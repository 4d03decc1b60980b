// See node_weights.hpp. Used by the route `tree`.
#include "solver/history/node_weights.hpp"

namespace hvi::solver {

/// At t, `ahead` steps after the next one.
std::vector<double> NodeWeights::of_raw(const TimeTree& tree, const AcceptedSteps& accepted,
                                        const TimeNode& node, double t, std::size_t ahead) {
  std::vector<double> weights;
  const auto after = static_cast<std::size_t>(tree.steps_after(node)) + ahead;
  put_node_weights(past_(kernel_, accepted.common_step(t, ahead), t, node.times, after), order_,
                   weights);
  return weights;
}

std::vector<std::vector<double>> NodeWeights::of_nodes(const TimeTree& tree,
                                                       const AcceptedSteps& accepted,
                                                       std::size_t first, double t) {
  const auto nodes = std::span(tree.nodes()).subspan(first);
  std::vector<double> lags, values;
  for (const TimeNode& node : nodes)
    if (!node.raw()) moments_.add_nodes(node.block, t, lags);
  values.resize(lags.size());
  kernel_.function.evaluate(t, lags, values);
  std::vector<std::vector<double>> out;
  const double* of_block = values.data();
  for (const TimeNode& node : nodes) {
    if (node.raw()) {
      out.push_back(of_raw(tree, accepted, node, t, 0));
      continue;
    }
    out.emplace_back(static_cast<std::size_t>(moments_.count()));
    moments_.coefficients(of_block, out.back().data());
    of_block += moments_.count();
  }
  if (order_ == 1) out.back().back() += current(accepted, t).one;
  return out;
}

std::vector<double> NodeWeights::at_times(const TimeTree& tree, const AcceptedSteps& accepted,
                                          const TimeNode& node, std::span<const double> times) {
  std::vector<double> out;
  if (node.raw()) {
    for (std::size_t j = 0; j < times.size(); ++j) {
      const auto weights = of_raw(tree, accepted, node, times[j], j);
      out.insert(out.end(), weights.begin(), weights.end());
    }
    return out;
  }
  std::vector<double> lags, at;
  for (const double t : times) {
    moments_.add_nodes(node.block, t, lags);
    at.resize(lags.size(), t);
  }
  std::vector<double> values(lags.size());
  kernel_.function.evaluate(at, lags, values);
  out.resize(lags.size());
  const auto moments = static_cast<std::size_t>(moments_.count());
  for (std::size_t i = 0; i < lags.size(); i += moments) moments_.coefficients(&values[i], &out[i]);
  return out;
}

} // namespace hvi::solver
