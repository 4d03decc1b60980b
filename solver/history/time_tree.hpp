// The past of a run in blocks of time that grow with their age: the newest steps as fields, older
// ones as Chebyshev moments of u, which are merged in pairs.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/history/block_test.hpp"
#include "solver/history/moments.hpp"
#include "solver/history/steps.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// Steps [index * 2^level, (index + 1) * 2^level) * leaf: fields or moments.
struct TimeNode {
  int level = 0; ///< -1: raw
  std::int64_t index = 0;
  TimeBlock block;
  double next_test = 0;
  double error = 0;
  std::vector<double> times;  ///< of raw steps
  std::vector<double> fields; ///< raw values (order 1: also the one before), or moments
  bool raw() const { return level < 0; }
};

class TimeTree {
public:
  struct Shape {
    std::size_t n; ///< numbers of a field
    int order;     ///< of the history
    int moments;   ///< of a block
    /// Steps of a leaf: twice the moments, so that it saves half.
    std::size_t leaf() const { return 2 * static_cast<std::size_t>(moments); }
  };
  explicit TimeTree(const Shape& shape) : shape_(shape) {}

  void start(double t0, std::span<const double> u0);
  /// Adds a step; true: the open node is full, and a new one is open.
  bool accept(double t, std::span<const double> u);
  /// Leaves out what lies more than `reach` behind.
  void forget(double now, double reach);
  /// One pass from old to new: raw nodes become moments, siblings merge, as the test allows. The
  /// last node is still being filled.
  void compress(const ChebyshevMoments& moments, const BlockTest& test, double start, double now);
  /// The error of all blocks, each asked again.
  double errors(const BlockTest& test, double start, double now);

  /// From old to new; the last one is raw and open.
  const std::vector<TimeNode>& nodes() const { return nodes_; }
  /// Accepted steps after the end of a raw node.
  std::int64_t steps_after(const TimeNode& node) const;

  void save(StateWriter& out) const;
  void restore(StateReader& in, const AcceptedSteps& accepted);

private:
  void open(double t, std::span<const double> u);

  Shape shape_;
  std::vector<TimeNode> nodes_;
  std::int64_t steps_ = 0;
};

} // namespace hvi::solver
