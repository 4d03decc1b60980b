// See factor_estimate.hpp.
#include "solver/discrete/factor_estimate.hpp"

#include <algorithm>
#include <vector>

namespace hvi::solver {
namespace {

/// Fewer nodes are one front.
constexpr std::ptrdiff_t most_in_a_leaf = 12;

using Nodes = std::span<int>;

class Dissection {
public:
  Dissection(std::span<const Point> points, const NodeGraph& graph, std::span<const int> unknowns,
             std::span<const int> last)
      : points_(points), graph_(graph), unknowns_(unknowns), last_(last), domain_(points.size(), 0),
        seen_(points.size(), 0) {}

  /// Columns of so many unknowns, which `outside` further ones see.
  void eliminate(double columns, double outside) {
    const double c = columns, o = outside;
    found_.nonzeros += 0.5 * c * (c + 1.0) + c * o;
    found_.flops += c * o * o + c * c * o + c * c * c / 3.0;
  }

  void cut(Nodes nodes) {
    if (nodes.empty()) return;
    enter(nodes);
    const double outside = unknowns_outside(nodes);
    if (std::ssize(nodes) <= most_in_a_leaf) return eliminate(unknowns_in(nodes), outside);
    const std::size_t middle = halve(nodes);
    const Nodes left = nodes.first(middle), right = nodes.subspan(middle);
    enter(right);
    const auto inner = std::partition(left.begin(), left.end(), [&](int node) {
      return std::ranges::none_of(neighbours(node), [&](int other) {
        return domain_[static_cast<std::size_t>(other)] == domains_;
      });
    });
    const Nodes separator(inner, left.end());
    eliminate(unknowns_in(separator), outside);
    cut(Nodes(left.begin(), inner));
    cut(right);
  }

  const FactorEstimate& found() const { return found_; }

private:
  std::span<const std::int32_t> neighbours(int node) const {
    const auto first = static_cast<std::size_t>(graph_.offsets[static_cast<std::size_t>(node)]);
    const auto past = static_cast<std::size_t>(graph_.offsets[static_cast<std::size_t>(node) + 1]);
    return {graph_.neighbours.data() + first, past - first};
  }

  /// They are the latest domain.
  void enter(Nodes nodes) {
    ++domains_;
    for (const int node : nodes) domain_[static_cast<std::size_t>(node)] = domains_;
  }

  double unknowns_in(Nodes nodes) const {
    double sum = 0.0;
    for (const int node : nodes) sum += inner(static_cast<std::size_t>(node));
    return sum;
  }

  int inner(std::size_t node) const { return unknowns_[node] - last_[node]; }

  /// Of the latest domain's neighbours, which are all eliminated later, and its own last ones.
  double unknowns_outside(Nodes nodes) {
    double sum = 0.0;
    for (const int node : nodes) {
      sum += last_[static_cast<std::size_t>(node)];
      for (const int other : neighbours(node)) {
        const auto at = static_cast<std::size_t>(other);
        if (domain_[at] == domains_ || seen_[at] == domains_) continue;
        seen_[at] = domains_;
        sum += unknowns_[at];
      }
    }
    return sum;
  }

  /// Across the longest side, between two layers of nodes where there are layers. How many come
  /// first.
  std::size_t halve(Nodes nodes) const {
    Point low = point(nodes.front()), high = low;
    for (const int node : nodes)
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], point(node)[a]);
        high[a] = std::max(high[a], point(node)[a]);
      }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    const std::size_t half = nodes.size() / 2;
    std::ranges::nth_element(nodes, nodes.begin() + static_cast<std::ptrdiff_t>(half), {},
                             [&](int node) { return point(node)[axis]; });
    const double middle = point(nodes[half])[axis];
    const auto before = std::partition(nodes.begin(), nodes.end(),
                                       [&](int node) { return point(node)[axis] < middle; });
    const auto first = static_cast<std::size_t>(before - nodes.begin());
    if (4 * first >= nodes.size()) return first;
    const auto after =
        std::partition(before, nodes.end(), [&](int node) { return point(node)[axis] <= middle; });
    const auto second = static_cast<std::size_t>(after - nodes.begin());
    return second < nodes.size() ? second : first > 0 ? first : half;
  }

  const Point& point(int node) const { return points_[static_cast<std::size_t>(node)]; }

  std::span<const Point> points_;
  const NodeGraph& graph_;
  std::span<const int> unknowns_, last_;
  std::vector<int> domain_, seen_; ///< by node: the latest it was in, or next to
  int domains_ = 0;
  FactorEstimate found_;
};

} // namespace

FactorEstimate estimate_factor(std::span<const Point> nodes, const NodeGraph& graph,
                               std::span<const int> unknowns, std::span<const int> last) {
  Dissection dissection(nodes, graph, unknowns, last);
  std::vector<int> inside;
  double contact = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    contact += last[i];
    if (unknowns[i] > last[i]) inside.push_back(static_cast<int>(i));
  }
  dissection.eliminate(contact, 0.0);
  dissection.cut(inside);
  return dissection.found();
}

} // namespace hvi::solver
