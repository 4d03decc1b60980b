// What the data do in time; see data_times.hpp.
#include "solver/study/data_times.hpp"

#include "solver/kernel/algebra.hpp"
#include "solver/kernel/interval.hpp"
#include "solver/kernel/node.hpp"
#include "solver/kernel/table.hpp"
#include "solver/kernel/zeros.hpp"
#include "solver/study/time_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>

namespace hvi::solver {
namespace {

constexpr std::size_t most_breaks = 2000, most_pieces = 8192;
constexpr double quiet = 0.5; ///< of its whole range: what a function may vary by on a piece
constexpr int most_halvings = 26;
constexpr double finest_for_moving = 64.0; ///< parts of the time that functions of x and t ask for
constexpr int range_parts = 400;           ///< that the search for a function's range looks at

double at(const Expr& f, double t) {
  return evaluate(f, [&](Slot) { return t; });
}
Bounds over(const Expr& f, double a, double b) {
  return bounds(f, [&](Slot) { return Bounds{a, b}; });
}

/// The least and the largest value of f, to a few per cent of their difference: the parts whose
/// bounds reach farthest beyond what was seen are halved first.
struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  double size() const { return high > low ? high - low : 0.0; }
  void see(double v) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
};

Range range_of(const Expr& f, const std::vector<double>& times) {
  Range out;
  struct Part {
    double a, b, beyond;
    bool operator<(const Part& other) const { return beyond < other.beyond; }
  };
  std::priority_queue<Part> parts;
  const auto add = [&](double a, double b) {
    out.see(at(f, a)), out.see(at(f, b)), out.see(at(f, 0.5 * (a + b)));
    const Bounds here = over(f, a, b);
    parts.push({a, b, std::max(here.high - out.high, out.low - here.low)});
  };
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const double edge = 1e-9 * (times[i + 1] - times[i]); // limits of a piece, not its jumps
    add(times[i] + edge, times[i + 1] - edge);
  }
  for (int k = 0; k < range_parts && !parts.empty(); ++k) {
    const Part worst = parts.top();
    if (worst.beyond <= 0.05 * out.size()) break;
    parts.pop();
    if (worst.b - worst.a <= 1e-9 * (times.back() - times.front())) continue;
    const double middle = 0.5 * (worst.a + worst.b);
    add(worst.a, middle), add(middle, worst.b);
  }
  return out;
}

/// Functions whose zeros are the times at which `node` may switch from one formula to another or
/// has no derivative. Whole tables have their knots.
std::vector<Expr> switches_of(const Expr& node) {
  const auto args = node.args();
  switch (node.op()) {
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::min:
  case Op::max:
    return {args[0] - args[1]};
  case Op::abs:
  case Op::sign:
  case Op::sqrt:
  case Op::log:
    return {args[0]};
  case Op::pow:
    if (args[1].is_constant() && args[1].value() == std::trunc(args[1].value())) return {};
    return {args[0]};
  case Op::asin:
  case Op::acos:
    return {Expr(1.0) - args[0] * args[0]};
  case Op::table:
  case Op::table_slope: {
    std::vector<Expr> out;
    for (const double knot : node.table()->abscissae()) out.push_back(args[0] - Expr(knot));
    return out;
  }
  default:
    return {};
  }
}

class DataSearch {
public:
  DataSearch(const Problem& problem, double least_size)
      : begin_(problem.time.grid.front()), end_(problem.time.grid.back()),
        functions_(time_functions(problem)), lags_(kernel_breaks(problem)),
        negligible_(least_size) {}

  DataTimes find() {
    std::vector<double> candidates;
    for (const auto& one : functions_) collect(one.f, candidates);
    std::sort(candidates.begin(), candidates.end());
    const std::vector<double> smooth = with_ends(candidates);
    measure(smooth);
    for (const double t : candidates) classify(t);
    merge();
    delay();
    if (out_.breaks.size() > most_breaks) out_.breaks.clear(), out_.complete = false;
    std::vector<double> times;
    for (const auto& b : out_.breaks) times.push_back(b.t);
    const auto edges = with_ends(times);
    out_.pieces = {begin_};
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) divide(edges[i], edges[i + 1], 0);
    return std::move(out_);
  }

private:
  double beside() const { return beside_a_jump * (end_ - begin_); }

  std::vector<double> with_ends(const std::vector<double>& times) const {
    std::vector<double> out = {begin_};
    for (const double t : times)
      if (t > out.back() + 4 * beside() && t < end_ - 4 * beside()) out.push_back(t);
    out.push_back(end_);
    return out;
  }

  void collect(const Expr& f, std::vector<double>& times) {
    postorder(f, [&](const Expr& node) {
      if (!node.depends_on(slot::t)) return;
      for (const Expr& g : switches_of(node)) {
        if (!g.depends_on(slot::t)) continue;
        if (const auto line = affine_in(g, slot::t);
            line && line->first.is_constant() && line->second.is_constant()) {
          const double t = -line->first.value() / line->second.value();
          if (t > begin_ && t <= end_) times.push_back(t);
          continue;
        }
        const Zeros found = zeros(g, slot::t, begin_, end_);
        out_.complete = out_.complete && found.complete;
        times.insert(times.end(), found.at.begin(), found.at.end());
      }
    });
  }

  /// Ranges of the functions; those that are small against others of their kind are dropped.
  void measure(const std::vector<double>& smooth) {
    std::array<double, 4> largest{};
    for (const auto& one : functions_) {
      ranges_.push_back(range_of(one.f, smooth));
      auto& most = largest[static_cast<std::size_t>(one.kind)];
      most = std::max(most, one.weight * ranges_.back().size());
    }
    for (std::size_t m = functions_.size(); m-- > 0;) {
      const double size = functions_[m].weight * ranges_[m].size();
      if (size > negligible_ * largest[static_cast<std::size_t>(functions_[m].kind)]) continue;
      functions_.erase(functions_.begin() + static_cast<std::ptrdiff_t>(m));
      ranges_.erase(ranges_.begin() + static_cast<std::ptrdiff_t>(m));
    }
    for (const auto& one : functions_) {
      slopes_.push_back(derivative(one.f, slot::t));
      ++members_[one.group];
    }
  }

  /// Does any function jump at t, or its slope? What is smooth there is no break.
  void classify(double t) {
    DataBreak found{t, false, false};
    std::map<int, int> seen; // points of a group
    bool any = false;
    const double step = beside(), left = std::max(begin_, t - step),
                 right = std::min(end_, t + step);
    if (left <= begin_) return;
    for (std::size_t m = 0; m < functions_.size(); ++m) {
      const double size = ranges_[m].size();
      const auto leap = [&](double width) {
        return std::abs(at(functions_[m].f, std::min(end_, t + width)) -
                        at(functions_[m].f, t - width));
      };
      // A steep slope is no jump: a jump stays where the two sides come closer.
      const bool jump = !(leap(step) <= 1e-6 * size) && !(leap(step / 32) <= 1e-6 * size);
      const double bend = std::abs(at(slopes_[m], right) - at(slopes_[m], left));
      const bool kink = !(bend <= 1e-6 * size / (end_ - begin_));
      if (!jump && (!kink || t >= end_ - step)) continue;
      // What only some points see moves through the body, and is no time of a grid.
      const int group = functions_[m].group;
      if (group > 0 && 2 * ++seen[group] <= members_.at(group)) continue;
      any = true;
      found.jump = found.jump || jump;
      found.imposed = found.imposed || functions_[m].kind == TimeFunction::Kind::imposed;
    }
    if (any) out_.breaks.push_back(found);
  }

  void merge() {
    std::vector<DataBreak> kept;
    for (const auto& b : out_.breaks) {
      if (!kept.empty() && b.t - kept.back().t <= 8 * beside()) {
        kept.back().jump = kept.back().jump || b.jump;
        kept.back().imposed = kept.back().imposed || b.imposed;
      } else {
        kept.push_back(b);
      }
    }
    out_.breaks = std::move(kept);
  }

  /// A kernel that breaks at a lag passes every break of the data on, and the beginning.
  void delay() {
    const auto own = out_.breaks;
    for (const double lag : lags_) {
      out_.breaks.push_back({begin_ + lag, false, false});
      for (const auto& b : own) out_.breaks.push_back({b.t + lag, false, false});
    }
    std::erase_if(out_.breaks, [&](const DataBreak& b) {
      return b.t <= begin_ + 4 * beside() || (b.t >= end_ - 4 * beside() && !b.jump);
    });
    std::sort(out_.breaks.begin(), out_.breaks.end(),
              [](const DataBreak& a, const DataBreak& b) { return a.t < b.t; });
    merge();
  }

  bool is_quiet(double a, double b) const {
    for (std::size_t m = 0; m < functions_.size(); ++m) {
      if (functions_[m].group > 0 && b - a < (end_ - begin_) / finest_for_moving) continue;
      const Bounds value = over(functions_[m].f, a, b);
      const double most = quiet * ranges_[m].size();
      if (value.high - value.low <= most) continue;
      const Bounds slope = over(slopes_[m], a, b);
      const double steepest = std::max(std::abs(slope.low), std::abs(slope.high));
      if (slope.defined && steepest * (b - a) <= most) continue;
      if (!value.known && sampled(m, a, b) <= most) continue;
      return false;
    }
    return true;
  }

  /// What a function without an interval rule is seen to vary.
  double sampled(std::size_t m, double a, double b) const {
    double sum = 0.0, before = at(functions_[m].f, a);
    for (int k = 1; k <= 16; ++k) {
      const double now = at(functions_[m].f, a + (b - a) * k / 16);
      sum += std::abs(now - before), before = now;
    }
    return sum;
  }

  void divide(double a, double b, int depth) {
    const double edge = std::min(beside(), 1e-6 * (b - a));
    const bool full = out_.pieces.size() >= most_pieces;
    if (depth >= most_halvings || full || is_quiet(a + edge, b - edge)) {
      out_.complete = out_.complete && !full;
      out_.pieces.push_back(b);
      return;
    }
    const double middle = a + 0.5 * (b - a);
    divide(a, middle, depth + 1);
    divide(middle, b, depth + 1);
  }

  double begin_, end_;
  std::vector<TimeFunction> functions_;
  std::vector<double> lags_;
  double negligible_;
  std::vector<Range> ranges_;
  std::vector<Expr> slopes_;
  std::map<int, int> members_; ///< of each group
  DataTimes out_;
};

} // namespace

DataTimes data_times(const Problem& problem, double negligible) {
  if (problem.time.is_static || problem.time.grid.size() < 2) return {};
  return DataSearch(problem, negligible).find();
}

} // namespace hvi::solver
