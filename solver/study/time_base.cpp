// Grids of time that follow data and solution; see time_base.hpp.
#include "solver/study/time_base.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int fewest = 4; ///< steps of any ladder
/// The later side of a jump lies so much farther from it than the earlier one: no whole number of
/// equal steps between them then has a time at the jump itself, where rounding would choose the
/// side.
constexpr double after_a_jump = 1.718281828;
constexpr std::size_t most_of_base = 1 << 16;

/// The power p with t_n = t_0 + T (n/N)^p, or 0. Few listed times show no power but 1.
double power_of(const std::vector<double>& grid) {
  const auto steps = static_cast<double>(grid.size() - 1);
  const double length = grid.back() - grid.front();
  const double p = steps > 1 ? std::log((grid[1] - grid[0]) / length) / std::log(1.0 / steps) : 1.0;
  for (std::size_t n = 0; n < grid.size(); ++n)
    if (std::abs(grid[n] - grid[0] - length * std::pow(static_cast<double>(n) / steps, p)) >
        1e-9 * length)
      return 0.0;
  if (std::abs(p - 1.0) < 1e-6) return 1.0;
  return steps < 4 ? 0.0 : p;
}

/// Times that stand for a jump are this close, relative to the whole time.
double width_of_a_jump(const std::vector<double>& grid) {
  return 3 * beside_a_jump * (grid.back() - grid.front());
}

void halve(std::vector<double>& grid, const std::vector<bool>& marked) {
  std::vector<double> out = {grid.front()};
  for (std::size_t i = 0; i + 1 < grid.size(); ++i) {
    if (marked[i]) out.push_back(grid[i] + 0.5 * (grid[i + 1] - grid[i]));
    out.push_back(grid[i + 1]);
  }
  grid = std::move(out);
}

/// Halves intervals more than twice as long as a neighbour, or longer than a part of the whole.
void balance(std::vector<double>& grid) {
  const double jump = width_of_a_jump(grid), whole = grid.back() - grid.front();
  for (bool again = true; again && grid.size() < most_of_base;) {
    again = false;
    std::vector<bool> marked(grid.size() - 1, false);
    const auto length = [&](std::size_t i) { return grid[i + 1] - grid[i]; };
    const auto longer = [&](std::size_t i, std::size_t than) {
      return length(than) > jump && length(i) > 2.01 * length(than);
    };
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (length(i) <= jump) continue;
      marked[i] = length(i) > 1.01 * whole / fewest || (i > 0 && longer(i, i - 1)) ||
                  (i + 1 < marked.size() && longer(i, i + 1));
      again = again || marked[i];
    }
    if (again) halve(grid, marked);
  }
}

TimeBase listed(std::vector<double> grid) {
  TimeBase out;
  out.power = 0.0;
  out.coarsest = static_cast<int>(grid.size()) - 1;
  out.unit = 2 * out.coarsest;
  out.grid = std::move(grid);
  return out;
}

/// Steps of a uniform grid with no interval longer than four times the shortest piece (three rungs
/// of a ladder see it), if that is not much more than there are pieces; else 0.
int uniform_steps(const DataTimes& data) {
  const auto& t = data.pieces;
  double shortest = t.back() - t.front();
  for (std::size_t i = 0; i + 1 < t.size(); ++i) shortest = std::min(shortest, t[i + 1] - t[i]);
  const double needed = 0.25 * (t.back() - t.front()) / shortest;
  if (needed > std::max(2.0 * fewest, 3.0 * static_cast<double>(t.size() - 1))) return 0;
  int steps = fewest;
  while (steps < needed * (1 - 1e-9)) steps *= 2;
  return steps;
}

} // namespace

bool is_jump(const TimeBase& base, std::size_t i) {
  return base.grid[i + 1] - base.grid[i] <= width_of_a_jump(base.grid);
}

TimeBase script_base(const TimeSpec& time) {
  TimeBase out;
  out.grid = time.grid;
  out.power = power_of(time.grid);
  if (out.power == 0.0) return listed(time.grid);
  return out;
}

TimeBase data_base(const TimeSpec& time, const DataTimes& data) {
  TimeBase out = script_base(time);
  if (data.pieces.size() < 2) return out;
  if (data.breaks.empty()) {
    const int steps = uniform_steps(data);
    if (out.power == 1.0) out.coarsest = steps;
    if (steps > 0 && (out.power == 1.0 || steps <= 2 * fewest)) return out;
  }
  const double first = time.grid.front(), last = time.grid.back();
  const double beside = beside_a_jump * (last - first);
  std::vector<double> kept = {first, last}; // times that must be there
  for (const auto& b : data.breaks) {
    const bool doubled = b.jump || b.imposed;
    kept.push_back(doubled ? std::min(b.t, last) - beside : b.t);
    if (doubled && b.t + after_a_jump * beside < last) kept.push_back(b.t + after_a_jump * beside);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<double> others = data.pieces;
  if (out.power == 0.0) others.insert(others.end(), time.grid.begin(), time.grid.end());
  if (out.power > 0.0 && out.power != 1.0)
    for (int n = 1; n < 2 * fewest; ++n)
      others.push_back(first + (last - first) * std::pow(0.5 * n / fewest, out.power));
  std::vector<double> grid = kept;
  for (const double t : others) {
    const auto near = std::lower_bound(kept.begin(), kept.end(), t - 5 * beside);
    if (near == kept.end() || *near > t + 5 * beside) grid.push_back(t);
  }
  std::sort(grid.begin(), grid.end());
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  balance(grid);
  return listed(std::move(grid));
}

TimeBase refined_base(const TimeBase& base, const std::vector<int>& halvings) {
  std::vector<double> grid = {base.grid.front()};
  for (std::size_t i = 0; i + 1 < base.grid.size(); ++i) {
    const int parts = 1 << halvings[i];
    for (int k = 1; k < parts; ++k)
      grid.push_back(base.grid[i] + (base.grid[i + 1] - base.grid[i]) * k / parts);
    grid.push_back(base.grid[i + 1]);
  }
  balance(grid);
  return listed(std::move(grid));
}

} // namespace hvi::solver
