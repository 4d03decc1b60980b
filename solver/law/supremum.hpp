// The largest value of a function of a law's argument over a range that may be infinite.
#pragma once

#include "solver/kernel/largest.hpp"
#include "solver/kernel/tail.hpp"
#include "solver/law/law.hpp"

namespace hvi::solver {

/// Where a function is searched. `others` is a space of the variables after the argument.
struct SupremumRange {
  double low = 0.0, high = 0.0; ///< of the argument; either may be infinite
  double scale = 1.0;           ///< a size of the arguments at which the law changes
  SearchSpace others{};         ///< boxes of the other variables, the argument's place left open
};

/// sup f: by branch and bound up to 1e9 scales, by the rules of growth (tail.hpp) beyond.
class Supremum {
public:
  Supremum() = default;
  /// `others`: the slots besides the argument that vary in a search.
  explicit Supremum(const Expr& f, const std::vector<Slot>& others = {});
  LargestValue operator()(const SupremumRange& range, const SearchEffort& effort) const;

private:
  Bracket beyond(const SearchSpace& others, const SearchBox& box, const Ray& ray) const;
  void take_tail(const SearchSpace& others, SearchBox box, const Ray& ray, int& left,
                 LargestValue& out) const;
  LargestSearch search_;
};

/// Everything but the argument fixed at a point of space and time.
std::function<Bounds(Slot)> fixed_at(const Point& x, const LawTime& t);

} // namespace hvi::solver
