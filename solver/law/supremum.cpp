// The largest value of a function of a law's argument (supremum.hpp).
#include "solver/law/supremum.hpp"

#include "solver/kernel/tail.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double reach_in_scales = 1e9;
constexpr Slot r_slot = slot::argument(0);

std::vector<Slot> with_argument(const std::vector<Slot>& others) {
  std::vector<Slot> out{r_slot};
  out.insert(out.end(), others.begin(), others.end());
  return out;
}

} // namespace

Supremum::Supremum(const Expr& f, const std::vector<Slot>& others)
    : search_(f, with_argument(others)) {}

/// f for sign r >= reach: its bound there, infinite by proof where f tends to infinity.
Bracket Supremum::beyond(const SupremumRange& range, double reach, double sign) const {
  const Ray ray{r_slot, sign, reach};
  const auto& variables = search_.variables();
  const auto box = [&](Slot s) {
    const auto at = std::find(variables.begin(), variables.end(), s) - variables.begin();
    if (at == static_cast<std::ptrdiff_t>(variables.size())) return range.others.fixed(s);
    Bounds all = range.others.boxes.front()[static_cast<std::size_t>(at)];
    for (const SearchBox& b : range.others.boxes) {
      const Bounds& part = b[static_cast<std::size_t>(at)];
      all.low = std::min(all.low, part.low), all.high = std::max(all.high, part.high);
    }
    return all;
  };
  const Tail tail = tail_of(search_.function(), ray, box);
  if (!tail.coefficient.known) return {-infinity, infinity};
  if (tail.grows() && tail.coefficient.low > 0.0) return Bracket::exactly(infinity);
  const Bounds all = range_of(tail, ray);
  return {-infinity, all.known ? all.high : infinity};
}

LargestValue Supremum::operator()(const SupremumRange& range, const SearchEffort& effort) const {
  const double reach = reach_in_scales * range.scale;
  const double low = std::max(range.low, -reach), high = std::min(range.high, reach);
  SearchSpace space = range.others;
  space.over_decades = true;
  if (space.boxes.empty()) space.boxes.emplace_back();
  const std::vector<SearchBox> others = std::exchange(space.boxes, {});
  for (SearchBox box : others) {
    const auto add = [&](double a, double b) {
      if (a < b) box[0] = {a, b}, space.boxes.push_back(box);
    };
    add(low, std::min(high, 0.0));
    add(std::max(low, 0.0), high);
  }
  LargestValue out = search_(space, effort);
  SupremumRange whole = range;
  whole.others.boxes = others;
  for (const double sign : {-1.0, 1.0}) {
    if (std::isfinite(sign < 0.0 ? range.low : range.high)) continue;
    const Bracket far = beyond(whole, reach, sign);
    if (far.low > out.value.low) out.value.low = far.low, out.at[0] = sign * infinity;
    out.value.high = std::max(out.value.high, far.high);
  }
  return out;
}

std::function<Bounds(Slot)> fixed_at(const Point& x, const LawTime& t) {
  return [x, t](Slot s) {
    const double v = s == slot::t ? t.t : s == slot::coupled ? t.coupled : x[s];
    return Bounds{v, v};
  };
}

} // namespace hvi::solver
