// Blocks of the past, and how they age; see time_tree.hpp. Used by the route `tree`.
#include "solver/history/time_tree.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

std::size_t fields_in(const TimeTree::Shape& shape, const TimeNode& node) {
  if (!node.raw()) return static_cast<std::size_t>(shape.moments);
  return node.times.empty() ? 0 : node.times.size() - (shape.order == 1 ? 0 : 1);
}

/// Number of accepted steps up to the end of a raw node.
std::int64_t steps_to_end(const TimeTree::Shape& shape, const TimeNode& node) {
  return node.index * static_cast<std::int64_t>(shape.leaf()) +
         static_cast<std::int64_t>(node.times.size()) - 1;
}

TimeNode restored_node(StateReader& r, const TimeTree::Shape& shape,
                       const AcceptedSteps& accepted) {
  const std::int64_t steps = accepted.count();
  TimeNode node;
  node.level = r.get_between(-1, 62);
  node.index = r.get_between<std::int64_t>(0, steps);
  node.block.a = r.get_between(accepted.start_time(), accepted.now());
  node.block.b = r.get_between(node.block.a, accepted.now());
  node.next_test = r.get_finite();
  node.error = r.get_finite();
  node.times = r.get_numbers();
  node.fields = r.get_numbers();
  bool good = node.fields.size() == fields_in(shape, node) * shape.n;
  if (node.raw())
    good = good && !node.times.empty() && node.times.size() <= shape.leaf() + 1 &&
           std::is_sorted(node.times.begin(), node.times.end()) &&
           node.times.front() >= accepted.start_time() && node.times.back() <= accepted.now() &&
           steps_to_end(shape, node) <= steps;
  if (!good) r.fail("is inconsistent");
  return node;
}

/// A failed test is repeated when the block is noticeably further away.
double later(const TimeBlock& block, double now) {
  return now + std::max(0.25 * (block.b - block.a), 0.1 * (now - block.b));
}

/// What happens to nodes at one time.
struct Ageing {
  const ChebyshevMoments& moments;
  const BlockTest& test;
  double start, now;

  void to_moments(TimeNode& node, const TimeTree::Shape& shape) const {
    const auto error = test.passes(node.block, start, now);
    if (!error) {
      node.next_test = later(node.block, now);
      return;
    }
    std::vector<double> fields(static_cast<std::size_t>(shape.moments) * shape.n, 0.0);
    add_product(moments.of_intervals(node.block, node.times, shape.order), node.fields.data(),
                fields.data(), shape.n);
    node.fields = std::move(fields);
    node.times.clear();
    node.times.shrink_to_fit();
    node.level = 0;
    node.error = *error;
    node.next_test = now;
  }

  /// `left` becomes both; false: they stay.
  bool merge(TimeNode& left, const TimeNode& right, std::size_t n) const {
    const bool siblings = !left.raw() && left.level == right.level && left.index % 2 == 0 &&
                          right.index == left.index + 1;
    if (!siblings || now < left.next_test) return false;
    const TimeBlock parent{left.block.a, right.block.b};
    const auto error = test.passes(parent, start, now);
    if (!error) {
      left.next_test = later(parent, now);
      return false;
    }
    std::vector<double> fields(left.fields.size(), 0.0);
    add_product(moments.to_parent(left.block, parent), left.fields.data(), fields.data(), n);
    add_product(moments.to_parent(right.block, parent), right.fields.data(), fields.data(), n);
    left.fields = std::move(fields);
    left.block = parent;
    left.level += 1;
    left.index /= 2;
    left.error = *error;
    left.next_test = now;
    return true;
  }
};

} // namespace

void TimeTree::start(double t0, std::span<const double> u0) {
  nodes_.clear();
  steps_ = 0;
  open(t0, u0);
}

void TimeTree::open(double t, std::span<const double> u) {
  TimeNode node;
  node.level = -1;
  node.index = steps_ / static_cast<std::int64_t>(shape_.leaf());
  node.block = {t, t};
  node.times.push_back(t);
  if (shape_.order == 1) node.fields.assign(u.begin(), u.end());
  nodes_.push_back(std::move(node));
}

bool TimeTree::accept(double t, std::span<const double> u) {
  ++steps_;
  TimeNode& last = nodes_.back();
  last.times.push_back(t);
  last.block.b = t;
  last.fields.insert(last.fields.end(), u.begin(), u.end());
  const bool full = last.times.size() == shape_.leaf() + 1;
  if (full) open(t, u);
  return full;
}

void TimeTree::forget(double now, double reach) {
  const auto visible = std::find_if(nodes_.begin(), nodes_.end() - 1, [&](const TimeNode& node) {
    return now - node.block.b < reach;
  });
  nodes_.erase(nodes_.begin(), visible);
}

void TimeTree::compress(const ChebyshevMoments& moments, const BlockTest& test, double start,
                        double now) {
  const Ageing ageing{moments, test, start, now};
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
    if (nodes_[i].raw() && now >= nodes_[i].next_test) ageing.to_moments(nodes_[i], shape_);
  for (bool merged = true; merged;) {
    merged = false;
    for (std::size_t i = 0; i + 2 < nodes_.size() && !merged; ++i) {
      merged = ageing.merge(nodes_[i], nodes_[i + 1], shape_.n);
      if (merged) nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  }
}

double TimeTree::errors(const BlockTest& test, double start, double now) {
  double total = 0;
  for (TimeNode& node : nodes_) {
    if (!node.raw()) node.error = test.error(node.block, start, now);
    total += node.error;
  }
  return total;
}

std::int64_t TimeTree::steps_after(const TimeNode& node) const {
  return steps_ - steps_to_end(shape_, node);
}

void TimeTree::save(StateWriter& w) const {
  w.put(static_cast<std::uint64_t>(nodes_.size()));
  for (const TimeNode& node : nodes_) {
    w.put(node.level);
    w.put(node.index);
    w.put(node.block);
    w.put(node.next_test);
    w.put(node.error);
    w.put(node.times);
    w.put(node.fields);
  }
}

void TimeTree::restore(StateReader& r, const AcceptedSteps& accepted) {
  steps_ = accepted.count();
  const auto count = r.get<std::uint64_t>();
  nodes_.clear();
  for (std::uint64_t i = 0; i < count; ++i) nodes_.push_back(restored_node(r, shape_, accepted));
  if (nodes_.empty() || !nodes_.back().raw()) r.fail("is inconsistent");
}

} // namespace hvi::solver
