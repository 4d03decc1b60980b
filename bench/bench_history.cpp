// What a memory term costs: CPU time per step and stored fields of each route against the direct
// sum in the same run, on fields of 10^4 doubles. Writes bench-history.json where it is started.
#include "solver/history/history.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <vector>

namespace {

using namespace hvi::solver;

constexpr std::size_t n = 10000;
constexpr double step = 1e-3;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Figure {
  HistoryReport report;
  double setup = 0, late = 0, mean = 0; ///< seconds; per step around the last one, and over all
  std::vector<double> last;             ///< the memory at the last step
};

/// All steps are taken. A long direct sum is asked in the last steps only: its figure there is what
/// is compared, and the mean of all steps, about half of it, is left out (0).
Figure run(const Expr& kernel, HistoryRoute route, std::int64_t steps) {
  HistoryOptions options;
  options.route = route;
  options.horizon = static_cast<double>(steps) * step;
  options.shortest_step = step;
  options.steps = steps;
  std::vector<double> grid;
  for (std::int64_t i = 0; i <= steps; ++i) grid.push_back(static_cast<double>(i) * step);
  options.times = grid;
  const bool ends_only = route == HistoryRoute::direct && steps > 1000;
  constexpr std::int64_t timed = 100;
  Figure figure;
  const double before = cpu_seconds();
  const auto history = make_history({"q", {}, kernel}, n, options);
  figure.setup = cpu_seconds() - before;
  std::vector<double> u(n, 0.0), out(n), times;
  history->start(0, u);
  const double begin = cpu_seconds();
  for (std::int64_t i = 1; i <= steps; ++i) {
    const double t = grid[static_cast<std::size_t>(i)], from = cpu_seconds();
    if (!ends_only || i > steps - timed) {
      history->rhs(t, out);
      history->w0(t);
    }
    // The new field costs the same for every route; a cheap one keeps the figures comparable.
    std::fill(u.begin(), u.end(), std::sin(3 * t));
    u[0] = t;
    history->commit(t, u);
    if (i > steps - timed) times.push_back(cpu_seconds() - from);
  }
  if (!ends_only) figure.mean = (cpu_seconds() - begin) / static_cast<double>(steps);
  // The mean, not the median: work that comes every so many steps must count.
  double sum = 0;
  for (const double seconds : times) sum += seconds;
  figure.late = sum / static_cast<double>(times.size());
  figure.report = history->report();
  figure.last = out;
  return figure;
}

struct Case {
  const char* name;
  Expr kernel;
  std::vector<HistoryRoute> routes;
};

std::vector<Case> cases() {
  const Expr l = Expr::variable(slot::lag), t = Expr::variable(slot::t);
  const auto call = [](Op op, std::vector<Expr> args) { return Expr::make(op, std::move(args)); };
  using enum HistoryRoute;
  return {
      {"exp(-lag)", exp(-l), {recursion}},
      {"exp(-lag) cos(20 lag)", exp(-l) * call(Op::cos, {Expr(20.0) * l}), {recursion, tree}},
      {"lag^-0.5", pow(l, Expr(-0.5)), {fit, tree}},
      {"Mittag-Leffler 1/2", call(Op::mittag_leffler, {Expr(0.5), Expr(1.0), -sqrt(l)}), {fit}},
      {"1/(1 + t + lag)", Expr(1.0) / (Expr(1.0) + t + l), {tree}},
  };
}

nlohmann::json compare(const Case& c, HistoryRoute route, std::int64_t steps,
                       const Figure& direct) {
  const Figure f = run(c.kernel, route, steps);
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    difference = std::max(difference, std::abs(f.last[i] - direct.last[i]));
    size = std::max(size, std::abs(direct.last[i]));
  }
  const double mean_ratio = direct.mean / f.mean; // 0: the direct sum was not asked at every step
  fmt::print("{:<22} {:>6} {:<9} {:>6} fields {:>9.3f} ms/step at the end ({:>6.1f} x), mean "
             "{:>9.3f} ms{}, memory {:>7.1f} x less, set-up {:.3f} s, difference {:.1e}\n",
             c.name, steps, f.report.route, f.report.fields, 1e3 * f.late, direct.late / f.late,
             1e3 * f.mean, mean_ratio > 0 ? fmt::format(" ({:.1f} x)", mean_ratio) : "",
             direct.report.bytes / f.report.bytes, f.setup, difference / size);
  return {{"kernel", c.name},
          {"steps", steps},
          {"route", f.report.route},
          {"fields", f.report.fields},
          {"bytes", f.report.bytes},
          {"seconds_per_step_end", f.late},
          {"seconds_per_step_mean", f.mean},
          {"speedup_end", direct.late / f.late},
          {"speedup_mean", mean_ratio},
          {"memory_ratio", direct.report.bytes / f.report.bytes},
          {"setup_seconds", f.setup},
          {"relative_difference", difference / size}};
}

} // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
  nlohmann::json rows = nlohmann::json::array();
  for (const std::int64_t steps : {std::int64_t{1000}, std::int64_t{10000}}) {
    if (quick && steps > 1000) break;
    for (const Case& c : cases()) {
      const Figure direct = run(c.kernel, HistoryRoute::direct, steps);
      fmt::print("{:<22} {:>6} direct    {:>6} fields {:>9.3f} ms/step at the end {:>9.3f} ms "
                 "mean\n",
                 c.name, steps, direct.report.fields, 1e3 * direct.late, 1e3 * direct.mean);
      for (const HistoryRoute route : c.routes) rows.push_back(compare(c, route, steps, direct));
    }
  }
  std::ofstream("bench-history.json") << rows.dump(2) << '\n';
}
