// See variation.hpp. Called for the rates of states and for laws that read states or the solution.
#include "solver/hypotheses/variation.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/largest.hpp"
#include "solver/law/jumps.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr std::size_t most_variables = 6;
/// Beyond all that inputs are, in any units. A derivative that is so much larger there than where
/// inputs are a thousandth of that grows without end.
constexpr double far = 1e15, less_far = 1e12, grows = 10.0;
/// Sides of a comparison that are meant to meet.
constexpr double rounding = 1e-12;
constexpr SearchEffort effort{4000, 1e-6, 0.0};

/// sup f >= 0, the variables beyond the first ones at 0.
Bracket search(const Expr& f, const std::function<Bounds(Slot)>& range) {
  std::vector<Slot> variables;
  SearchBox box{};
  for (const Slot s : f.slots())
    if (variables.size() < most_variables) {
      box[variables.size()] = range(s);
      variables.push_back(s);
    }
  if (variables.empty()) return Bracket::exactly(evaluate(f, [](Slot) { return 0.0; }));
  SearchSpace space;
  space.boxes = {box};
  space.over_decades = true;
  space.fixed = [](Slot) { return Bounds{0.0, 0.0}; };
  const Bracket found = LargestSearch(f, variables)(space, effort).value;
  const bool all = f.slots().size() <= most_variables && std::isfinite(found.high);
  return all ? found : Bracket::at_least(std::max(found.low, 0.0));
}

double times(double factor, double value) { return value == 0.0 ? 0.0 : factor * value; }

} // namespace

Variation operator+(const Variation& a, const Variation& b) {
  return {a.everywhere + b.everywhere, a.near + b.near, std::max(a.jumps, b.jumps)};
}

Variation larger(const Variation& a, const Variation& b) {
  return {larger(a.everywhere, b.everywhere), larger(a.near, b.near), std::max(a.jumps, b.jumps)};
}

Variation operator*(double factor, const Variation& a) {
  const auto scaled = [&](const Bracket& v) {
    return Bracket{times(factor, v.low), times(factor, v.high)};
  };
  return {scaled(a.everywhere), scaled(a.near), a.jumps};
}

Variation VariationSearch::of(const Expr& f, const std::vector<Slot>& by) const {
  Expr sum = 0.0;
  for (const Slot s : by) sum = sum + abs(derivative(f, s));
  Variation out{largest(sum, far), largest(sum, 1.0)};
  if (out.everywhere.low > grows * largest(sum, less_far).low)
    out.everywhere = Bracket::exactly(infinity);
  for (const Slot s : by) out.jumps = std::max(out.jumps, jumps(f, s));
  if (out.jumps == Jumps::found) out.everywhere = Bracket::exactly(infinity);
  return out;
}

/// Over the axes as normals.
Bracket VariationSearch::largest(const Expr& f, double reach) const {
  if (!f.depends_on_any(slot::normal(0), slot::normal(2) + 1)) return with_normal(f, reach);
  Bracket out;
  for (int axis = 0; axis < dim_; ++axis) {
    std::vector<std::pair<Slot, Expr>> normal;
    for (int j = 0; j < 3; ++j) normal.emplace_back(slot::normal(j), Expr(j == axis ? 1.0 : 0.0));
    out = larger(out, with_normal(substitute(f, normal), reach));
  }
  return Bracket::at_least(out.low);
}

Bracket VariationSearch::with_normal(const Expr& f, double reach) const {
  return search(f, [&](Slot s) { return ranges_(s, reach); });
}

/// By what f jumps at the zero of a comparison that is affine in `by`, where that is in its range.
Jumps VariationSearch::jumps(const Expr& f, Slot by) const {
  const std::pair<Slot, Expr> swapped[2] = {{by, Expr::variable(slot::r)},
                                            {slot::r, Expr::variable(by)}};
  const auto range = [&](Slot s) {
    return ranges_(s == by ? slot::r : s == slot::r ? by : s, far);
  };
  const Bounds own = range(slot::r);
  const Expr turned = substitute(f, swapped);
  Jumps out = Jumps::none;
  for (const Switch& s : find_switches({&turned, 1})) {
    if (!may_jump(s)) continue;
    const bool affine =
        s.kind == Switch::Kind::two_sided && !derivative(s.function, slot::r).depends_on(slot::r);
    if (!affine) {
      out = Jumps::unknown; // the slope of a table, or a comparison of powers
      continue;
    }
    const std::pair<Slot, Expr> zero{slot::r, Expr(0.0)};
    const Expr root = -substitute(s.function, {&zero, 1}) / derivative(s.function, slot::r);
    const std::pair<Slot, Expr> there{slot::r, root};
    const Expr size = abs(substitute(jump_across(turned, s.node), {&there, 1}));
    const Expr in_range = select(less(Expr(own.low), root),
                                 select(less(root, Expr(own.high)), size, Expr(0.0)), Expr(0.0));
    const Bracket found = search(in_range, range);
    if (found.low > rounding) return Jumps::found;
    if (found.high > rounding) out = Jumps::unknown;
  }
  return out;
}

} // namespace hvi::solver
