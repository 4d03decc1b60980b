// The history fields of a run; see memory.hpp.
#include "solver/discrete/memory.hpp"

#include "solver/discrete/time_grid.hpp"
#include "solver/history/traits.hpp"
#include "solver/linear/vector_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

std::span<const double> view(const Vector& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

HistoryOptions history_options(const Plan& plan, const MemoryExtent& extent) {
  HistoryOptions out;
  out.route = plan.options.route;
  out.order = affine_on_steps(plan.problem.time.scheme) ? 1 : 0;
  out.tolerance = plan.options.memory_tolerance;
  out.steps = extent.steps;
  out.horizon = extent.horizon;
  out.shortest_step = extent.shortest_step;
  out.times = plan.problem.time.grid;
  return out;
}

HistoryOptions with_route(HistoryOptions options, const HistoryTerm& term) {
  if (term.route) options.route = *term.route;
  return options;
}

const char* name_of(HistoryRoute route) {
  switch (route) {
  case HistoryRoute::automatic:
    return "automatic";
  case HistoryRoute::recursion:
    return "recursion";
  case HistoryRoute::fit:
    return "fit";
  case HistoryRoute::tree:
    return "tree";
  case HistoryRoute::direct:
    return "direct";
  }
  return "";
}

MemoryMistrust mistrust(const HistoryTerm& term, const HistoryReport& report, double tolerance,
                        int index) {
  const HistoryRoute next = report.route == "fit" ? HistoryRoute::tree : HistoryRoute::direct;
  return {index, term.origin,
          fmt::format("the memory `{}` ({}) is {:.1e} of its norm off the direct sum; its "
                      "tolerance is {:.1e}: started again with the route `{}`",
                      term.kernel.name, report.route, report.audit, tolerance, name_of(next)),
          next};
}

} // namespace

MemoryExtent memory_extent(const Problem& problem) {
  MemoryExtent out;
  if (problem.time.is_static) return out;
  const auto& grid = problem.time.grid;
  out.steps = static_cast<std::int64_t>(grid.size()) - 1;
  out.horizon = grid.back() - grid.front();
  // Of a uniform grid the exact step: histories tell equal steps from others by it.
  const TimeGrid times(problem.time);
  const double mean = out.horizon / static_cast<double>(out.steps);
  out.shortest_step = times.shortest();
  bool uniform = true;
  for (int n = 1; n <= times.steps() && uniform; ++n)
    uniform = std::abs(times.length(n) - mean) <= times.rounding(n) * mean;
  if (uniform) out.shortest_step = mean;
  return out;
}

/// A kernel is studied up to the end of the run; beyond it another route may be needed.
std::string extension_obstacle(const Problem& problem, const MemoryExtent& earlier) {
  const double longer = memory_extent(problem).horizon, t0 = problem.time.grid.front();
  for (const auto& term : problem.histories) {
    const auto then = kernel_traits(term.kernel, earlier.horizon, t0);
    const auto now = kernel_traits(term.kernel, longer, t0);
    if (!now.finite)
      return fmt::format("the kernel `{}` is not finite at every lag up to the new end time",
                         term.kernel.name);
    if (now.breaks.size() != then.breaks.size() || now.max_lag != then.max_lag)
      return fmt::format("the kernel `{}` has kinks between lag {:.6g}, the length of the run "
                         "so far, and lag {:.6g}",
                         term.kernel.name, earlier.horizon, longer);
  }
  return {};
}

namespace {

/// Fields of a direct sum at the end of a run.
std::int64_t direct_fields(const HistoryTerm& term, const Problem& problem,
                           const HistoryOptions& options) {
  const double reach =
      kernel_traits(term.kernel, options.horizon, problem.time.grid.front()).max_lag;
  if (!(reach > 0)) return options.steps;
  return std::min<std::int64_t>(options.steps, 1 + std::llround(reach / options.shortest_step));
}

/// Of a moment tree, roughly: raw steps in its open node, and moments in two nodes a level. A
/// kernel that varies much keeps more of its past raw.
double tree_fields(std::int64_t steps) {
  return std::min(static_cast<double>(steps),
                  60.0 + 24.0 * std::log2(1.0 + static_cast<double>(steps) / 32.0));
}

} // namespace

double history_bytes_to_come(const Plan& plan, std::span<const HistoryReport> now, int n_state) {
  double fields = 0.0;
  for (std::size_t m = 0; m < now.size(); ++m) {
    const bool direct = now[m].route == "direct";
    if (!direct && now[m].route != "tree") continue; // the others have their fields from the start
    const HistoryOptions options = history_options(plan, memory_extent(plan.problem));
    const double end =
        direct
            ? static_cast<double>(direct_fields(plan.problem.histories[m], plan.problem, options))
            : tree_fields(options.steps);
    fields += std::max(0.0, end - static_cast<double>(now[m].fields));
  }
  return fields * n_state * sizeof(double);
}

std::vector<HistoryReport> planned_memory(const Plan& plan) {
  std::vector<HistoryReport> out;
  if (plan.problem.time.is_static || plan.problem.histories.empty()) return out;
  const HistoryOptions options = history_options(plan, memory_extent(plan.problem));
  for (const auto& term : plan.problem.histories) {
    const auto history = make_history(term.kernel, 1, with_route(options, term));
    const double initial = 0;
    history->start(plan.problem.time.grid.front(), {&initial, 1});
    auto report = history->report();
    if (report.route == "direct") report.fields = direct_fields(term, plan.problem, options);
    if (report.route == "tree") report.fields = 0;
    out.push_back(std::move(report));
  }
  return out;
}

std::vector<std::string> route_notes(const Plan& plan, const std::vector<HistoryReport>& reports) {
  std::vector<std::string> out;
  for (std::size_t m = 0; m < reports.size(); ++m) {
    const HistoryRoute wanted = plan.problem.histories[m].route.value_or(plan.options.route);
    if (wanted == HistoryRoute::automatic || reports[m].route == name_of(wanted)) continue;
    out.push_back(fmt::format("the route `{}` does not serve the memory `{}`, `{}` is used: {}",
                              name_of(wanted), plan.problem.histories[m].kernel.name,
                              reports[m].route, reports[m].why));
  }
  return out;
}

Memory::Memory(const Plan& plan, int n_state, const MemoryExtent& extent)
    : plan_(&plan), extent_(extent) {
  if (plan.problem.time.is_static || plan.problem.histories.empty()) return;
  const HistoryOptions options = history_options(plan, extent);
  const auto n = static_cast<std::size_t>(n_state);
  for (const auto& term : plan.problem.histories) {
    histories_.push_back(plan.options.audit
                             ? make_audited_history(term.kernel, n, with_route(options, term))
                             : make_history(term.kernel, n, with_route(options, term)));
    known_.push_back(Vector::Zero(n_state));
    w0_.push_back(0.0);
  }
}

void Memory::start(double t0, const Vector& u0) {
  for (auto& history : histories_) history->start(t0, view(u0));
}

std::optional<MemoryStop> Memory::begin_step(double t) {
  for (int m = 0; m < size(); ++m) {
    histories_[m]->rhs(t, {known_[m].data(), static_cast<std::size_t>(known_[m].size())});
    w0_[m] = histories_[m]->w0(t); // audited, too
    const double tolerance = plan_->options.memory_tolerance;
    if (histories_[m]->audited() > tolerance)
      return mistrust(plan_->problem.histories[m], histories_[m]->report(), tolerance, m);
  }
  if (auto end = ended()) return *std::move(end);
  return std::nullopt;
}

std::optional<HorizonEnd> Memory::ended() const {
  for (const auto& history : histories_)
    if (const HorizonEnd* end = history->ended()) return *end;
  return std::nullopt;
}

void Memory::commit(double t, const Vector& u) {
  for (auto& history : histories_) history->commit(t, view(u));
}

std::vector<HistoryReport> Memory::reports() const {
  std::vector<HistoryReport> out;
  for (const auto& history : histories_) out.push_back(history->report());
  return out;
}

void Memory::save(std::ostream& out) const {
  StateWriter w(out);
  for (const auto& history : histories_) history->save(out);
  w.put(w0_);
  for (const auto& known : known_) put_vector(w, known);
}

void Memory::restore(std::istream& in) {
  StateReader r(in, {});
  for (auto& history : histories_) history->restore(in);
  w0_ = r.get_vector<double>(histories_.size());
  for (auto& known : known_) get_vector(r, known, known.size());
}

} // namespace hvi::solver
