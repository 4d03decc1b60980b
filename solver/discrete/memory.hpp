// The history fields w_m(t) = int_0^t q_m(t, s) u(s) ds of a run, one History each.
//
//   w_m(t_n) = h_m + w0_m u_n,    h_m known before the step, w0_m the weight of the current
//   interval.
#pragma once

#include "solver/discrete/state.hpp"
#include "solver/history/history.hpp"
#include "solver/plan/plan.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace hvi::solver {

/// An audit found a memory outside its tolerance: a run starts again with the `next` route.
struct MemoryMistrust {
  int history; ///< of Problem::histories
  Origin origin;
  std::string said; ///< what the audit found, and what is done about it
  HistoryRoute next;
};

/// Why a step cannot begin.
using MemoryStop = std::variant<MemoryMistrust, HorizonEnd>;

/// What the routes were chosen for. A run that is continued beyond its end keeps them: each history
/// verifies itself beyond that horizon, or refuses.
struct MemoryExtent {
  double horizon = 0, shortest_step = 0;
  std::int64_t steps = 0;
  bool operator==(const MemoryExtent&) const = default;
};
MemoryExtent memory_extent(const Problem& problem);

/// Why the memories of a run made for `earlier` cannot be continued to the plan's end; empty: they
/// can, as far as their kernels go.
std::string extension_obstacle(const Problem& problem, const MemoryExtent& earlier);

/// The routes of a plan without running it: what `plan` prints. Fields: 0 when only a run knows.
std::vector<HistoryReport> planned_memory(const Plan& plan);

/// What the memories of a run will hold at its end, beyond what they hold now.
double history_bytes_to_come(const Plan& plan, std::span<const HistoryReport> now, int n_state);

/// Where a route that was asked for does not serve its kernel: a sentence each.
std::vector<std::string> route_notes(const Plan& plan, const std::vector<HistoryReport>& reports);

class Memory {
public:
  /// Histories of states; order 0 for backward Euler, 1 (u affine on a step) for BDF2.
  Memory(const Plan& plan, int n_state) : Memory(plan, n_state, memory_extent(plan.problem)) {}
  Memory(const Plan& plan, int n_state, const MemoryExtent& extent);

  int size() const { return static_cast<int>(histories_.size()); }
  void start(double t0, const Vector& u0);
  /// Finds h_m and w0_m of the step that ends at t, unless they are not right.
  [[nodiscard]] std::optional<MemoryStop> begin_step(double t);
  void commit(double t, const Vector& u);
  /// Of the first history that cannot go on beyond the end it was made for.
  std::optional<HorizonEnd> ended() const;

  double w0(int m) const { return w0_[m]; }
  const Vector& known(int m) const { return known_[m]; } ///< h_m
  std::vector<HistoryReport> reports() const;
  const MemoryExtent& extent() const { return extent_; }
  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  const Plan* plan_;
  MemoryExtent extent_;
  std::vector<std::unique_ptr<History>> histories_;
  std::vector<double> w0_;
  std::vector<Vector> known_;
};

} // namespace hvi::solver
