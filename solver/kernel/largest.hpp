// The largest value of an expression over a set, by branch and bound with interval enclosures.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/kernel/interval.hpp"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace hvi::solver {

/// Ranges and values of the variables of a search, in their order.
using SearchBox = std::array<Bounds, 6>;
using SearchPoint = std::array<double, 6>;

/// The set to search: boxes with finite ends, or what of them `meets` and `pull` leave.
struct SearchSpace {
  std::vector<SearchBox> boxes;                  ///< their union is searched
  std::function<Bounds(Slot)> fixed{};           ///< of the slots that are no variables
  bool over_decades = false;                     ///< features of the first one may have any size
  std::function<bool(const SearchBox&)> meets{}; ///< false: nothing of the set is in this box
  std::function<void(SearchPoint&)> pull{};      ///< moves a point into the set
  unsigned constrained = 0;                      ///< bit k: `meets` looks at variable k
};

struct SearchEffort {
  int evaluations = 20000; ///< of the expression's enclosure, at most
  double digits = 1e-10;   ///< relative width of the bracket at which the search ends
  double noise = 0.0;      ///< absolute width that is rounding
  double seen = -std::numeric_limits<double>::infinity(); ///< only larger values are wanted
};

struct LargestValue {
  Bracket value; ///< seen at `at`, and the proved bound; infinite above where none was found
  SearchPoint at{};
  int evaluations = 0;
};

/// sup of f over a set where f is defined. Boxes are halved where the enclosure of f, natural or
/// (where f is continuous) by the mean value theorem, may exceed what was seen; a variable in which
/// f is monotone is fixed at the better end. Method: E. R. Hansen, Global optimization using
/// interval analysis: the one-dimensional case, Journal of Optimization Theory and Applications 29,
/// 1979.
class LargestSearch {
public:
  LargestSearch() = default;
  LargestSearch(const Expr& f, std::vector<Slot> variables);
  const Expr& function() const { return f_; }
  const std::vector<Slot>& variables() const { return variables_; }
  LargestValue operator()(const SearchSpace& space, const SearchEffort& effort) const;

private:
  friend class SearchRun;
  Expr f_;
  std::vector<Slot> variables_;
  IntervalTape tape_;
  bool has_slopes_ = false;
};

} // namespace hvi::solver
