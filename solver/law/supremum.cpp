// The largest value of a function of a law's argument (supremum.hpp).
#include "solver/law/supremum.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/overflow.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {

namespace {

constexpr double reach_in_scales = 1e9;
constexpr int most_halvings = 400;

std::vector<Slot> with_argument(const std::vector<Slot>& others) {
  std::vector<Slot> out{slot::r};
  out.insert(out.end(), others.begin(), others.end());
  return out;
}

} // namespace

Supremum::Supremum(const Expr& f, const std::vector<Slot>& others)
    : search_(without_overflow(f), with_argument(others)) {}

/// f on a ray, the other variables in a box: its bound, infinite by proof where f tends to
/// infinity.
Bracket Supremum::beyond(const SearchSpace& others, const SearchBox& box, const Ray& ray) const {
  const auto& variables = search_.variables();
  const auto range = [&](Slot s) {
    const auto at = std::find(variables.begin(), variables.end(), s) - variables.begin();
    return at == static_cast<std::ptrdiff_t>(variables.size()) ? others.fixed(s)
                                                               : box[static_cast<std::size_t>(at)];
  };
  const Tail tail = tail_of(search_.function(), ray, range);
  if (!tail.coefficient.known) return {-infinity, infinity};
  if (tail.grows() && tail.coefficient.low > 0.0) return Bracket::exactly(infinity);
  const Bounds all = range_of(tail, ray);
  return {-infinity, all.known ? all.high : infinity};
}

/// Takes the bound on a ray into `out`; the box of the other variables is halved where it is the
/// larger one, `left` times at most.
void Supremum::take_tail(const SearchSpace& others, SearchBox box, const Ray& ray, int& left,
                         LargestValue& out) const {
  if (others.meets && !others.meets(box)) return;
  const Bracket far = beyond(others, box, ray);
  if (far.low > out.value.low) out.value.low = far.low, out.at[0] = ray.sign * infinity;
  std::size_t widest = 0;
  for (std::size_t i = 1; i < search_.variables().size(); ++i)
    if (widest == 0 || box[i].high - box[i].low > box[widest].high - box[widest].low) widest = i;
  const double middle =
      widest == 0 ? 0.0 : box[widest].low + (box[widest].high - box[widest].low) / 2.0;
  if (far.high <= out.value.high || widest == 0 || --left < 0 || !(box[widest].low < middle)) {
    out.value.high = std::max(out.value.high, far.high);
    return;
  }
  const double high = std::exchange(box[widest].high, middle);
  take_tail(others, box, ray, left, out);
  box[widest] = {middle, high};
  take_tail(others, box, ray, left, out);
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
  if (!search_.function().depends_on(slot::r)) return out;
  int left = most_halvings;
  for (const double sign : {-1.0, 1.0}) {
    if (std::isfinite(sign < 0.0 ? range.low : range.high)) continue;
    const Ray ray{slot::r, sign, reach};
    for (const SearchBox& box : others) take_tail(range.others, box, ray, left, out);
  }
  return out;
}

std::function<Bounds(Slot)> fixed_at(const Point& x, const LawTime& t) {
  return [x, t](Slot s) {
    const double v = t.value(s, x);
    return Bounds{v, v};
  };
}

} // namespace hvi::solver
