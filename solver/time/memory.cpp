// The history fields of a run; see memory.hpp.
#include "solver/time/memory.hpp"

#include <algorithm>
#include <istream>
#include <ostream>

namespace hvi::solver {
namespace {

std::span<const double> view(const Vector& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

HistoryOptions history_options(const Plan& plan) {
  const auto& grid = plan.time.grid;
  HistoryOptions out;
  out.route = plan.options.route;
  out.order = plan.time.scheme == Scheme::bdf2 ? 1 : 0;
  out.tolerance = plan.options.memory_tolerance;
  out.steps = static_cast<std::int64_t>(grid.size()) - 1;
  out.horizon = grid.back() - grid.front();
  out.shortest_step = out.horizon;
  for (std::size_t n = 1; n < grid.size(); ++n)
    out.shortest_step = std::min(out.shortest_step, grid[n] - grid[n - 1]);
  return out;
}

} // namespace

Memory::Memory(const Plan& plan, int n_state) {
  if (plan.time.is_static) return;
  for (const auto& term : plan.histories) {
    histories_.push_back(
        make_history(term.kernel, static_cast<std::size_t>(n_state), history_options(plan)));
    known_.push_back(Vector::Zero(n_state));
    w0_.push_back(0.0);
  }
}

void Memory::start(double t0, const Vector& u0) {
  for (auto& history : histories_) history->start(t0, view(u0));
}

void Memory::begin_step(double t) {
  for (int m = 0; m < size(); ++m) {
    histories_[m]->rhs(t, {known_[m].data(), static_cast<std::size_t>(known_[m].size())});
    w0_[m] = histories_[m]->w0(t);
  }
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
  for (const auto& history : histories_) history->save(out);
}

void Memory::restore(std::istream& in) {
  for (auto& history : histories_) history->restore(in);
}

} // namespace hvi::solver
