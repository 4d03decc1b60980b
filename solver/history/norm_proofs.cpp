// Norms of a kernel by interval arithmetic (norm_proofs.hpp).
#include "solver/history/norm_proofs.hpp"

#include "solver/common/numbers.hpp"
#include "solver/history/breaks.hpp"
#include "solver/history/cancellation.hpp"
#include "solver/kernel/largest.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr int lag_cells = 4096;                  ///< of a kernel of the lag only
constexpr int time_cells = 48, cells_each = 384; ///< of another one

/// sup |f| over the triangle 0 <= lag <= t - t0.
Bracket largest_magnitude(const Expr& f, double t0, double t1) {
  std::vector<Slot> variables;
  for (const Slot s : slots_of(f))
    if (s == slot::t || s == slot::lag) variables.push_back(s);
  SearchSpace space;
  SearchBox box{};
  std::size_t at_t = variables.size(), at_lag = variables.size();
  for (std::size_t k = 0; k < variables.size(); ++k) {
    const bool time = variables[k] == slot::t;
    (time ? at_t : at_lag) = k;
    box[k] = time ? Bounds{t0, t1} : Bounds{0.0, t1 - t0};
  }
  space.boxes.push_back(box);
  if (at_t < variables.size() && at_lag < variables.size()) {
    space.constrained = 3U;
    space.meets = [=](const SearchBox& b) { return b[at_lag].low <= b[at_t].high - t0; };
    space.pull = [=](SearchPoint& p) { p[at_lag] = std::min(p[at_lag], p[at_t] - t0); };
  }
  Bracket out;
  for (const Expr& side : {f, -f}) {
    const LargestValue found = LargestSearch(side, variables)(space, {});
    out = larger(out, found.value);
  }
  return out;
}

/// |[low, high]| as an interval.
Bounds magnitude(const Bounds& b) {
  const double top = std::max(std::abs(b.low), std::abs(b.high));
  return {b.contains(0.0) ? 0.0 : std::min(std::abs(b.low), std::abs(b.high)), top, b.known,
          b.defined};
}

/// q and q'' in the lag over a cell, or at a point.
class Cells {
public:
  explicit Cells(const Expr& q)
      : outputs_{q, derivative(derivative(q, slot::lag), slot::lag)}, tape_(outputs_) {}

  /// False: q may jump in the cell.
  bool operator()(const Bounds& t, const Bounds& lag) {
    box_.clear();
    for (const Slot s : tape_.inputs()) box_.push_back(s == slot::t ? t : lag);
    return tape_(box_, out, work_);
  }
  std::array<Bounds, 2> out;

private:
  std::array<Expr, 2> outputs_;
  IntervalTape tape_;
  std::vector<Bounds> box_, work_;
};

Bracket integral_over_lag(const Expr& q, double t1, double length) {
  Cells cells(q);
  double low = 0.0, high = 0.0;
  for (int i = 0; i < lag_cells; ++i) {
    const double from = length * i / lag_cells, to = length * (i + 1) / lag_cells, h = to - from,
                 middle = 0.5 * (from + to);
    const bool smooth = cells({t1, t1}, {from, to});
    const Bounds value = cells.out[0], curvature = cells.out[1];
    if (!value.known || !value.defined) return {0.0, infinity};
    const Bounds size = magnitude(value);
    double least = h * size.low, most = h * size.high;
    const bool bounded = curvature.known && curvature.defined && std::isfinite(curvature.low) &&
                         std::isfinite(curvature.high);
    if (smooth && bounded && !value.contains(0.0)) {
      cells({t1, t1}, {middle, middle});
      const Bounds centre = magnitude(cells.out[0]), bend = magnitude(curvature);
      least = std::max(least, h * centre.low - h * h * h / 24.0 * bend.high);
      most = std::min(most, h * centre.high + h * h * h / 24.0 * bend.high);
    }
    low += least, high += most;
  }
  const double rounding = 4.0 * lag_cells * 0x1p-53 * high; // of the sums
  return {std::max(0.0, low - rounding), high + rounding};
}

/// The largest integral over the lags of any t, from above; from below, of the cells' own times.
Bracket integral_over_times(const Expr& q, double t0, double t1) {
  Cells cells(q);
  Bracket out{0.0, 0.0};
  for (int n = 0; n < time_cells; ++n) {
    const double early = t0 + (t1 - t0) * n / time_cells,
                 late = t0 + (t1 - t0) * (n + 1) / time_cells, length = late - t0;
    double low = 0.0, high = 0.0;
    for (int i = 0; i < cells_each; ++i) {
      const Bounds lag{length * i / cells_each, length * (i + 1) / cells_each};
      const double h = lag.high - lag.low;
      cells({early, late}, lag);
      if (!cells.out[0].known || !cells.out[0].defined) return {0.0, infinity};
      high += h * magnitude(cells.out[0]).high;
      cells({late, late}, lag);
      low += h * magnitude(cells.out[0]).low;
    }
    const double rounding = 4.0 * cells_each * 0x1p-53 * high;
    out = larger(out, {low - rounding, high + rounding});
  }
  return out;
}

/// What is known of a number: what was seen, and the bound above it.
Bracket with_bound(double seen, const Bracket& proof) {
  return {std::max(seen, proof.low), std::max(seen, proof.high)};
}

} // namespace

NormProofs prove_norms(const Expr& as_written, const KernelNorms& seen, double t0, double t1) {
  if (seen.exact)
    return {Bracket::exactly(seen.sup), Bracket::exactly(seen.lipschitz),
            Bracket::exactly(seen.l1)};
  NormProofs out{Bracket::at_least(seen.sup), Bracket::at_least(seen.lipschitz),
                 Bracket::at_least(seen.l1)};
  const Expr q = without_cancellation(as_written);
  out.sup = with_bound(seen.sup, largest_magnitude(q, t0, t1));
  if (!std::isfinite(out.sup.high)) return out; // then nothing bounds the others, either
  const bool of_lag_only = !q.depends_on(slot::t);
  out.l1 = with_bound(seen.l1, of_lag_only ? integral_over_lag(q, t1, t1 - t0)
                                           : integral_over_times(q, t0, t1));
  if (!Breaks(q, {}).empty()) return out; // slopes are blind to jumps
  const Expr slope = derivative(q, slot::t) + derivative(q, slot::lag);
  out.lipschitz = with_bound(seen.lipschitz, largest_magnitude(slope, t0, t1));
  return out;
}

} // namespace hvi::solver
