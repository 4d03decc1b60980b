// The matrices of all steps as points, and the search for the worst; see step_weights.hpp.
#include "solver/formulation/step_weights.hpp"

#include "solver/discrete/time_scheme.hpp"
#include "solver/history/traits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <queue>

namespace hvi::solver {
namespace {

using Eigen::VectorXd;

constexpr double room = 1e-3;  ///< to which the worst ratio is found where it matters little
constexpr double point = 1e-7; ///< boxes with relative sides below it are one point

/// w0 of every step, and nothing else, of one kernel: histories that remember no field.
class LastWeights {
public:
  LastWeights(const Problem& problem, const TimeGrid& grid, bool absolute) : grid_(grid) {
    HistoryOptions options;
    options.route = HistoryRoute::direct;
    options.order = affine_on_steps(problem.time.scheme) && !absolute ? 1 : 0;
    options.steps = grid.steps();
    options.horizon = problem.time.grid.back() - problem.time.grid.front();
    options.times = problem.time.grid;
    for (const auto& term : problem.histories) {
      KernelSpec kernel = term.kernel;
      if (absolute) kernel.expression = abs(kernel.expression), kernel.series.reset();
      const auto traits = kernel_traits(kernel, options.horizon, problem.time.grid.front());
      kernels_.push_back({make_history(kernel, 0, options), traits.convolution, {}});
      kernels_.back().history->start(problem.time.grid.front(), {});
    }
  }
  /// Of the next step.
  void next(int n, VectorXd& out) {
    for (std::size_t m = 0; m < kernels_.size(); ++m) {
      auto& kernel = kernels_[m];
      const auto known = kernel.by_length.find(grid_.length(n));
      double w0 = 0;
      if (kernel.convolution && known != kernel.by_length.end()) {
        w0 = known->second;
      } else {
        w0 = kernel.history->w0(grid_.t(n));
        if (kernel.convolution) kernel.by_length[grid_.length(n)] = w0;
      }
      out[field_of_memory(static_cast<int>(m))] = w0;
      kernel.history->commit(grid_.t(n), {});
    }
  }

private:
  struct Kernel {
    std::unique_ptr<History> history;
    bool convolution;
    std::map<double, double> by_length; ///< of a convolution
  };
  const TimeGrid& grid_;
  std::vector<Kernel> kernels_;
};

Eigen::Index fields(const Problem& problem) { return count_fields(problem); }

} // namespace

bool surely_one_matrix(const Problem& problem) {
  if (problem.time.is_static) return true;
  for (const auto& term : problem.histories)
    if (term.kernel.expression.depends_on(slot::t)) return false;
  const auto scheme = make_scheme(problem);
  const TimeGrid& grid = scheme->grid();
  for (int n = 2; n <= grid.steps(); ++n)
    if (scheme->factor(n, 1) != scheme->factor(1, 1) || grid.length(n) != grid.length(1))
      return false;
  return true;
}

StepWeights step_weights(const Problem& problem) {
  VectorXd c = VectorXd::Zero(fields(problem));
  c[field_of_u(0)] = 1.0;
  if (problem.time.is_static) return {{1}, {c}};
  const auto scheme = make_scheme(problem);
  const TimeGrid& grid = scheme->grid();
  LastWeights memory(problem, grid, false);
  StepWeights out;
  const auto less = [](const VectorXd& a, const VectorXd& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::map<VectorXd, int, decltype(less)> seen(less);
  for (int n = 1; n <= grid.steps(); ++n) {
    for (int j = 1; j <= highest_derivative; ++j) c[field_of_u(j)] = scheme->factor(n, j);
    memory.next(n, c);
    if (!seen.emplace(c, n).second) continue;
    out.steps.push_back(n);
    out.c.push_back(c);
  }
  return out;
}

std::vector<VectorXd> absolute_weights(const Problem& problem, const StepWeights& weights) {
  const TimeGrid grid(problem.time);
  std::vector<VectorXd> out(weights.steps.size(), VectorXd::Zero(fields(problem)));
  LastWeights memory(problem, grid, true);
  VectorXd c = VectorXd::Zero(fields(problem));
  std::size_t next = 0;
  for (int n = 1; n <= grid.steps() && next < weights.steps.size(); ++n) {
    memory.next(n, c);
    if (n == weights.steps[next]) out[next++] = c;
  }
  return out;
}

namespace {

/// Some of the columns, the box around them, and the worst of its corners.
struct WeightBox {
  std::vector<int> members;
  VectorXd low, high;
  double bound = 0.0;
  bool operator<(const WeightBox& other) const { return bound < other.bound; }
};

class Search {
public:
  Search(const StepWeights& weights, const std::function<double(const VectorXd&)>& ratio, int most)
      : w_(weights), ratio_(ratio), most_(most), known_(less) {}

  WorstStep run() {
    WeightBox all;
    for (int i = 0; i < static_cast<int>(w_.steps.size()); ++i) all.members.push_back(i);
    out_.ratio = -std::numeric_limits<double>::infinity();
    look_at(all.members.front()); // as a rule the first step and the last are the extreme ones
    look_at(all.members.back());
    push(std::move(all));
    while (!settled()) split();
    out_.bound = std::max(out_.ratio, open_.empty() ? out_.ratio : open_.top().bound);
    return out_;
  }

private:
  static bool less(const VectorXd& a, const VectorXd& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  }
  double at(const VectorXd& c) {
    const auto found = known_.find(c);
    if (found != known_.end()) return found->second;
    const double r = ratio_(c);
    known_[c] = r;
    return r;
  }
  void look_at(int member) {
    const double r = at(w_.c[member]);
    if (r > out_.ratio) out_.ratio = r, out_.step = w_.steps[member];
  }
  /// The relative side of the box along coordinate k.
  static double side(const WeightBox& g, Eigen::Index k) {
    const double size = std::max(std::abs(g.low[k]), std::abs(g.high[k]));
    return size > 0.0 ? (g.high[k] - g.low[k]) / size : 0.0;
  }
  void push(WeightBox g) {
    g.low = g.high = w_.c[g.members.front()];
    for (const int i : g.members)
      g.low = g.low.cwiseMin(w_.c[i]), g.high = g.high.cwiseMax(w_.c[i]);
    std::vector<Eigen::Index> open;
    for (Eigen::Index k = 0; k < g.low.size(); ++k)
      if (g.low[k] < g.high[k]) open.push_back(k);
    g.bound = -std::numeric_limits<double>::infinity();
    if (g.members.size() <= 1U << open.size()) { // each of them costs no more than its box
      for (const int i : g.members) look_at(i);
      return;
    }
    for (unsigned corner = 0; corner < 1U << open.size(); ++corner) {
      VectorXd c = g.low;
      for (std::size_t k = 0; k < open.size(); ++k)
        if ((corner >> k & 1U) != 0) c[open[k]] = g.high[open[k]];
      g.bound = std::max(g.bound, at(c));
      if (g.bound == std::numeric_limits<double>::infinity()) break;
    }
    open_.push(std::move(g));
  }
  bool settled() {
    if (open_.empty() || std::isinf(out_.ratio)) return true;
    const WeightBox& worst = open_.top();
    const double enough = out_.ratio * (1.0 + room);
    if (worst.bound <= out_.ratio ||
        (worst.bound <= enough && (worst.bound < 1.0 || enough >= 1.0)))
      return true;
    Eigen::Index k = 0;
    if (worst.members.size() == 1 || widest(worst, k) <= point) return true;
    out_.within_budget = static_cast<int>(known_.size()) < most_;
    return !out_.within_budget;
  }
  static double widest(const WeightBox& g, Eigen::Index& k) {
    double most = -1.0;
    for (Eigen::Index i = 0; i < g.low.size(); ++i)
      if (side(g, i) > most) most = side(g, i), k = i;
    return most;
  }
  void split() {
    WeightBox g = open_.top();
    open_.pop();
    Eigen::Index k = 0;
    widest(g, k);
    std::sort(g.members.begin(), g.members.end(),
              [&](int a, int b) { return w_.c[a][k] < w_.c[b][k]; });
    const auto middle = static_cast<std::ptrdiff_t>(g.members.size() / 2);
    WeightBox lower, upper;
    lower.members.assign(g.members.begin(), g.members.begin() + middle);
    upper.members.assign(g.members.begin() + middle, g.members.end());
    look_at(lower.members.back());
    look_at(upper.members.front());
    push(std::move(lower));
    push(std::move(upper));
  }

  const StepWeights& w_;
  const std::function<double(const VectorXd&)>& ratio_;
  int most_;
  std::map<VectorXd, double, bool (*)(const VectorXd&, const VectorXd&)> known_;
  std::priority_queue<WeightBox> open_;
  WorstStep out_;
};

} // namespace

WorstStep worst_step(const StepWeights& weights,
                     const std::function<double(const VectorXd&)>& ratio, int most) {
  return Search(weights, ratio, most).run();
}

} // namespace hvi::solver
