// The functions of time in a plan; see time_functions.hpp.
#include "solver/study/time_functions.hpp"

#include "solver/fem/region.hpp"
#include "solver/history/history.hpp"
#include "solver/kernel/algebra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace hvi::solver {
namespace {

constexpr int points_along = 5; ///< where functions of x are looked at, in each direction

using Values = std::array<double, 8>; ///< x, t, lag, normal, as slots are numbered

bool is_time(Slot slot) { return slot == slot::t; }
bool is_place(Slot slot) { return (slot >= 0 && slot < 3) || (slot >= 5 && slot < 8); }

/// Points of the body's bounding box, not on lines that symmetry makes special.
std::vector<Values> places_of(const MeshSpec& mesh) {
  std::array<double, 3> low = mesh.low, high = mesh.high;
  int dim = mesh.kind == MeshSpec::Kind::interval ? 1 : mesh.kind == MeshSpec::Kind::box ? 3 : 2;
  if (mesh.kind == MeshSpec::Kind::file || mesh.kind == MeshSpec::Kind::geometry ||
      mesh.kind == MeshSpec::Kind::pieces) {
    const Mesh made = make_mesh(mesh);
    dim = made.dim;
    low.fill(HUGE_VAL), high.fill(-HUGE_VAL);
    for (const Point& p : made.nodes)
      for (int a = 0; a < dim; ++a)
        low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  }
  for (int a = 0; a < dim; ++a)
    if (!mesh.grading[a].empty())
      low[a] = mesh.grading[a].front(), high[a] = mesh.grading[a].back();
  std::vector<Values> out;
  int count = 1;
  for (int a = 0; a < dim; ++a) count *= points_along;
  for (int k = 0; k < count; ++k) {
    Values at{};
    for (int a = 0, rest = k; a < dim; ++a, rest /= points_along) {
      const double part = (rest % points_along + 0.4729 + 0.0316 * a) / points_along;
      at[slot::x(a)] = low[a] + part * (high[a] - low[a]);
    }
    for (int a = 0; a < 3; ++a) at[slot::normal(a)] = 1.0 / std::sqrt(static_cast<double>(dim));
    out.push_back(at);
  }
  return out;
}

/// Gathers functions of time. Points are made only where something varies in space.
class Gathering {
public:
  explicit Gathering(const Problem& problem) : problem_(problem) {}

  /// f(x, t): a sum of products, or at points.
  void add(const Expr& f, TimeFunction::Kind kind) {
    if (!f.depends_on(slot::t)) return;
    if (const auto products = split_separable(f, is_time)) {
      for (const auto& [space, time] : *products)
        if (!time.is_constant()) keep({time, largest(space), kind, 0});
      return;
    }
    ++groups_;
    for (const Values& at : places()) keep({seen_from(f, at), 1.0, kind, groups_});
  }

  /// The largest parts of f that depend on time and place only.
  void add_parts(const Expr& f, TimeFunction::Kind kind) {
    if (!f.depends_on(slot::t)) return;
    const auto slots = f.slots();
    if (std::all_of(slots.begin(), slots.end(), [](Slot s) { return is_time(s) || is_place(s); })) {
      if (f.op() != Op::slot) add(f, kind);
      return;
    }
    for (const Expr& part : f.args()) add_parts(part, kind);
  }

  std::vector<TimeFunction> take() { return std::move(out_); }

private:
  const std::vector<Values>& places() {
    if (places_.empty()) places_ = places_of(problem_.mesh);
    return places_;
  }

  static Expr seen_from(const Expr& f, const Values& at) {
    std::vector<std::pair<Slot, Expr>> here;
    for (const Slot s : f.slots())
      if (is_place(s)) here.emplace_back(s, Expr(at[static_cast<std::size_t>(s)]));
    return substitute(f, here);
  }

  double largest(const Expr& space) {
    if (space.is_constant()) return std::abs(space.value());
    double out = 0.0;
    for (const Values& at : places()) {
      const double v = std::abs(evaluate(seen_from(space, at), [](Slot) { return 0.0; }));
      if (!std::isfinite(v)) return 1.0;
      out = std::max(out, v);
    }
    return out > 0.0 ? out : 1.0; // on a part no point lies in
  }

  void keep(const TimeFunction& found) {
    if (!found.f.depends_on(slot::t)) return;
    for (auto& known : out_)
      if (known.kind == found.kind && known.group == found.group && known.f == found.f) {
        known.weight = std::max(known.weight, found.weight);
        return;
      }
    out_.push_back(found);
  }

  const Problem& problem_;
  std::vector<Values> places_;
  int groups_ = 0;
  std::vector<TimeFunction> out_;
};

} // namespace

std::vector<TimeFunction> time_functions(const Problem& problem) {
  using K = TimeFunction::Kind;
  Gathering all(problem);
  for (const LoadTerm* const load : all_loads(problem))
    for (const auto& entry : load->entries) all.add(entry.value, K::load);
  for (const auto& side : problem.space.dirichlet)
    for (const Expr& value : side.value) all.add(value, K::imposed);
  for (const auto& term : problem.law_terms)
    for (const auto& row : term.rows) all.add(row.offset, K::law);
  for (const auto& law : problem.laws) all.add_parts(law.expression, K::law);
  for (const auto& history : problem.histories) all.add_parts(history.kernel.expression, K::kernel);
  return all.take();
}

std::vector<double> kernel_breaks(const Problem& problem) {
  std::vector<double> out;
  if (problem.time.grid.size() < 2) return out;
  const double horizon = problem.time.grid.back() - problem.time.grid.front();
  for (const auto& history : problem.histories) {
    const auto traits = kernel_traits(history.kernel, horizon);
    out.insert(out.end(), traits.breaks.begin(), traits.breaks.end());
    if (traits.max_lag > 0.0) out.push_back(traits.max_lag);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

} // namespace hvi::solver
