// Which cases of a law are ever taken (reach.hpp).
#include "solver/law/reach.hpp"

#include "solver/law/law.hpp"

#include <algorithm>
#include <set>

namespace hvi::solver {

namespace {

bool on_the_argument(const Expr& condition) {
  const auto slots = condition.slots();
  return slots.size() == 1 && slots[0] == slot::argument(0);
}

/// The number of the case that holds at r, as a function of r.
Expr number_of_case(const std::vector<Expr>& conditions) {
  Expr out(static_cast<double>(conditions.size()));
  for (std::size_t i = conditions.size(); i-- > 0;)
    out = select(conditions[i], Expr(static_cast<double>(i)), out);
  return out;
}

} // namespace

std::vector<int> unreached_cases(const std::vector<Expr>& conditions, bool radial) {
  if (!std::all_of(conditions.begin(), conditions.end(), on_the_argument)) return {};
  const Expr number = number_of_case(conditions);
  std::set<int> seen;
  try {
    const Law law(LawSpec{"cases", {}, radial, true, number});
    const LawGraph graph = law.graph({}, 0.0); // constant pieces: the numbers of the cases
    for (const auto& piece : graph.smooth) seen.insert(static_cast<int>(piece.a[0]));
    for (const double r : graph.breaks)
      seen.insert(static_cast<int>(evaluate(number, [r](Slot) { return r; })));
  } catch (const Failure&) {
    return {};
  }
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(conditions.size()); ++i)
    if (seen.count(i) == 0) out.push_back(i);
  return out;
}

} // namespace hvi::solver
