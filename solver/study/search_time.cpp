// Errors in time: bases that follow the solution, and what a run of four times the steps says of
// the chosen ones; see search.hpp.
#include "solver/assembly/assembly.hpp"
#include "solver/study/reference.hpp"
#include "solver/study/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace hvi::solver {
namespace {

constexpr int many_steps = 96; ///< more than these on the first base: it is worth following errors
constexpr int most_rounds = 24;
constexpr int most_intervals = 2000;
constexpr double bulk = 0.6;       ///< of the increments of the error that is halved in a round
constexpr double between = 2.0;    ///< error between the steps, of the aim, where following stops
constexpr double least_fall = 0.9; ///< distances that fall less do not fall

/// Whether the solution can jump at the beginning: nothing there remembers u_0.
bool may_jump_at_first(const Problem& problem) {
  return std::none_of(problem.forms.begin(), problem.forms.end(),
                      [](const FormTerm& f) { return is_rate(f.field); });
}

/// Where along a base the error of `coarse` arises, between its times, too, where it counts as
/// linear: what is too short for its steps is seen there.
struct Arising {
  std::vector<double> increments; ///< largest norm that the error gains in an interval
  double largest = 0.0;           ///< norm of the error, but for the intervals of jumps
};

/// Of one unknown in its norm.
SparseMatrix gram_of(const Space& space, int unknown, const UnknownNorm& norm) {
  if (norm.slopes) return gram_of_unknown(space, unknown, norm.values);
  return SparseMatrix(gram_of_unknown(space, unknown, true) -
                      gram_of_unknown(space, unknown, false));
}

/// The squared norm of V. Of several unknowns: each by its largest in the steps of the run.
SparseMatrix gram_of_run(const KeptRun& run) {
  const Space& space = run.discretisation->space;
  const auto norms = norms_of(run.plan.problem, *run.discretisation);
  if (!space.is_product()) return gram_of(space, 0, norms.front());
  SparseMatrix out(space.n_dofs(), space.n_dofs());
  for (int b = 0; b < n_unknowns(space); ++b) {
    const SparseMatrix own = gram_of(space, b, norms[static_cast<std::size_t>(b)]);
    double square = 0.0;
    for (const Vector& u : run.states) square = std::max(square, u.dot(own * u));
    if (square > 0.0) out = SparseMatrix(out + own / square);
  }
  return out;
}

/// Both runs are on one mesh; norms in V, relative to the largest of `fine`.
Arising arising_error(const KeptRun& coarse, const KeptRun& fine, const TimeBase& base) {
  const SparseMatrix gram = gram_of_run(fine);
  const auto norm = [&](const Vector& v) { return std::sqrt(std::max(0.0, v.dot(gram * v))); };
  const auto time = [](const KeptRun& run, std::size_t i) {
    return run.plan.problem.time.grid[static_cast<std::size_t>(run.steps[i])];
  };
  Arising out{std::vector<double>(base.grid.size() - 1, 0.0), 0.0};
  const bool skips_first = may_jump_at_first(fine.plan.problem);
  Vector left = coarse.first, begun = Vector::Zero(left.size()), error = begun;
  double left_time = base.grid.front(), size = norm(left);
  std::size_t interval = 0, i = 0;
  for (std::size_t j = 0; j < fine.steps.size() && i < coarse.steps.size(); ++j) {
    const double t = time(fine, j);
    while (i < coarse.steps.size() && time(coarse, i) < t)
      left = coarse.states[i], left_time = time(coarse, i), ++i;
    if (i == coarse.steps.size()) break;
    while (interval + 1 < out.increments.size() && t > base.grid[interval + 1])
      begun = error, ++interval;
    size = std::max(size, norm(fine.states[j]));
    if (skips_first && t < time(coarse, 0)) continue;
    const double part = (t - left_time) / (time(coarse, i) - left_time);
    error = left + part * (coarse.states[i] - left) - fine.states[j];
    if (is_jump(base, interval)) continue;
    out.increments[interval] = std::max(out.increments[interval], norm(error - begun));
    out.largest = std::max(out.largest, norm(error));
  }
  if (fine.discretisation->space.is_product()) return out; // relative already
  if (size > 0.0) {
    for (double& v : out.increments) v /= size;
    out.largest /= size;
  }
  return out;
}

/// How often to halve each interval: those that make up most of the error, twice where they are
/// few. All 0: the error arises everywhere, and more steps are as good.
std::vector<int> halvings(const std::vector<double>& increments, const TimeBase& base) {
  std::vector<std::size_t> order(increments.size());
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](std::size_t i) { return is_jump(base, i); });
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return increments[a] > increments[b]; });
  double sum = 0.0, all = 0.0;
  for (const std::size_t i : order) all += increments[i];
  std::size_t marked = 0;
  while (marked < order.size() && sum < bulk * all) sum += increments[order[marked++]];
  std::vector<int> out(increments.size(), 0);
  if (2 * marked > order.size()) return out;
  for (std::size_t k = 0; k < marked; ++k) out[order[k]] = 8 * marked <= order.size() ? 2 : 1;
  return out;
}

} // namespace

bool Search::worth_adapting(const std::optional<Choice>& choice) const {
  if (family_.is_static()) return false;
  return !choice || choice->seconds > out_.request.most_seconds ||
         choice->setting.steps > std::max(many_steps, 4 * family_.coarsest_steps());
}

/// Halves the intervals in which the error arises, until it is small enough or arises everywhere.
void Search::adapt_time() {
  time_adapted_ = true;
  const Scheme scheme = schemes_.back();
  TimeBase base = family_.base(0);
  base.grid = family_.intervals(0), base.power = 0.0;
  base = refined_base(base, std::vector<int>(base.grid.size() - 1, base.grid.size() < 16 ? 1 : 0));
  int last = 0;
  for (int round = 0; round < most_rounds && base.coarsest <= most_intervals; ++round) {
    const int now = family_.add_base(base);
    const std::string purpose =
        fmt::format("steps where errors in time arise, round {}", round + 1);
    const KeptRun& coarse = cheap(time_setting({scheme, now}, 2 * base.coarsest), purpose);
    const KeptRun& fine = cheap(time_setting({scheme, now}, 4 * base.coarsest), purpose);
    if (!coarse.failure.empty() || !fine.failure.empty()) {
      base = refined_base(base, std::vector<int>(base.grid.size() - 1, 1));
      continue;
    }
    last = now;
    const Arising error = arising_error(coarse, fine, base);
    if (compared(coarse, fine) <= 0.5 * target_ && error.largest <= between * target_) break;
    const auto cut = halvings(error.increments, base);
    if (std::all_of(cut.begin(), cut.end(), [](int k) { return k == 0; })) break;
    base = refined_base(base, cut);
  }
  if (last > 0)
    for (const Scheme each : schemes_) climb_time({each, last}, 3);
  pair_up();
}

/// The error in time of half.steps over the distance `seen` of it to half as many steps, from runs
/// of twice and four times the steps on the mesh of the ladders: they see what a factor two of one
/// grid does not. None where such runs fail, or their distances do not fall.
std::optional<double> Search::remaining_error(const Setting& half, double seen, double& order) {
  const Clock clock = clock_of(half);
  std::array<const KeptRun*, 4> runs{};
  for (std::size_t k = 0; k < runs.size(); ++k) {
    runs[k] = &cheap(time_setting(clock, half.steps / 2 << k), "witness of the steps");
    if (!runs[k]->failure.empty()) return std::nullopt;
  }
  std::array<double, 3> d{};
  for (std::size_t k = 0; k < d.size(); ++k) {
    d[k] = compared(*runs[k], *runs[k + 1]);
    add_rung(time_[clock], {0.5 * half.steps * (1 << k), 2.0, d[k]});
  }
  const double nominal = order_of(half.scheme, !family_.plan().problem.law_terms.empty());
  order = time_law(clock).order;
  if (d[1] <= floor_ && d[2] <= floor_)
    return std::max({seen / (std::pow(2.0, nominal) - 1.0), d[1], d[2]});
  if (d[2] > least_fall * d[1]) return std::nullopt;
  const double far = distance_between(*runs[1], *runs[3]);
  const double error =
      far + finer_error(d[2], 2.0, std::clamp(order, 0.4, nominal), Distance::additive);
  // The chosen mesh may show more of the error than that of the ladders, or less, but not nothing.
  const double more = d[0] > floor_ ? seen / d[0] : 1.0;
  return std::max(error * std::max(more, 0.25), seen / (std::pow(2.0, nominal) - 1.0));
}

/// Error in time of the chosen steps, seen on half the level.
bool Search::look_at_time(AccuracyTry& now, const Setting& half, const KeptRun& companion) {
  if (family_.is_static()) return true;
  Setting fewer = half;
  fewer.steps /= 2;
  const KeptRun& coarse = cheap(fewer, "companion of half the level and half the steps");
  if (!coarse.failure.empty()) return false;
  now.time_distance = compared(coarse, companion);
  const auto error = remaining_error(half, now.time_distance, now.time_order);
  if (!error) return false;
  now.time_error = *error;
  // The runs of the ladder in time were on a coarse mesh: its order is kept, its constant is
  // replaced by what this mesh shows.
  const Clock clock = clock_of(half);
  if (const double promised = time_law(clock).at(half.steps); promised > 0.0)
    for (Rung& r : time_[clock]) r.distance *= std::max(now.time_error, floor_) / promised;
  return true;
}

} // namespace hvi::solver
