// What the memories of a run will cost; see rehearsal.hpp.
#include "solver/discrete/rehearsal.hpp"

#include "solver/common/clock.hpp"
#include "solver/discrete/memory.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

struct Mark {
  double steps, seconds, reads;
};

double reads_of(const Memory& memory) {
  double sum = 0.0;
  for (const auto& report : memory.reports()) sum += static_cast<double>(report.reads);
  return sum;
}

/// What `of` is after n steps, from the marks of fewer.
double continued(const std::vector<Mark>& marks, double Mark::*of, double n) {
  const Mark& last = marks.back();
  if (n <= last.steps) return last.*of;
  const auto half = std::find_if(marks.begin(), marks.end(),
                                 [&](const Mark& m) { return 2.0 * m.steps >= last.steps; });
  double power = 1.0; // a direct sum: 2
  if (half->steps < last.steps && (*half).*of > 0.0)
    power = std::log(last.*of / ((*half).*of)) / std::log(last.steps / half->steps);
  return last.*of * std::pow(n / last.steps, std::clamp(power, 1.0, 2.5));
}

} // namespace

MemoryForecast rehearse_memory(const Plan& plan, int from, double most_reads) {
  MemoryForecast out;
  if (plan.problem.time.is_static || plan.problem.histories.empty()) return out;
  const auto& grid = plan.problem.time.grid;
  const int steps = static_cast<int>(grid.size()) - 1;
  Memory memory(plan, 1);
  const Vector one = Vector::Ones(1);
  const int stride = std::max(1, std::min(16, steps / 16));
  memory.start(grid.front(), one);
  const double begin = cpu_seconds();
  std::vector<Mark> marks;
  Mark first{};
  double least = 0.0, last = 0.0; // seconds of the cheapest first step, up to the last step
  try {
    for (int n = 1; n <= steps; ++n) {
      if (memory.begin_step(grid[static_cast<std::size_t>(n)])) break; // a run takes another route
      memory.commit(grid[static_cast<std::size_t>(n)], one);
      if (n <= from) {
        const double now = cpu_seconds() - begin;
        least = n <= 2 ? now - last : std::min(least, now - last); // the first one prepares
        last = now;
      }
      if (n != from && n != steps && n % stride != 0) continue;
      marks.push_back({static_cast<double>(n), cpu_seconds() - begin, reads_of(memory)});
      if (n == from) first = marks.back();
      out.rehearsed = n;
      if (n >= 4 * from && marks.back().reads > most_reads) break;
    }
  } catch (const Failure&) { // the run itself will say it
  }
  if (marks.empty()) return out;
  const double later = steps - from, all = continued(marks, &Mark::seconds, steps);
  out.all_reads = continued(marks, &Mark::reads, steps);
  const double each = from > 0 ? first.reads / from : 0.0;
  out.seconds = std::max(0.0, all - first.seconds - least * later);
  out.reads = std::max(0.0, out.all_reads - first.reads - each * later);
  return out;
}

} // namespace hvi::solver
