// How much an expression changes with some of its variables: Lipschitz constants.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/kernel/interval.hpp"

#include <functional>
#include <vector>

namespace hvi::solver {

/// Whether an expression jumps where a comparison turns.
enum class Jumps { none, unknown, found };

/// sup of the sum of |derivatives|: over all values of the variables (infinite where it grows
/// without end or the expression jumps, sampled where no bound was found), and over values up to 1
/// in size.
struct Variation {
  Bracket everywhere, near;
  Jumps jumps = Jumps::none;
};

/// The sum of both.
Variation operator+(const Variation& a, const Variation& b);
/// Of what has both as entries, by the largest of its entries.
Variation larger(const Variation& a, const Variation& b);
/// `factor` may be infinite.
Variation operator*(double factor, const Variation& a);

/// By branch and bound over at most six variables (largest.hpp); normals are the axes, more
/// variables stay at 0: then the numbers are sampled. Comparisons are looked at one by one: whether
/// the expression jumps where one turns.
class VariationSearch {
public:
  /// The range of a variable of which nothing more is known than that it is up to `reach` in size.
  using Ranges = std::function<Bounds(Slot, double reach)>;

  VariationSearch(Ranges ranges, int dim) : ranges_(std::move(ranges)), dim_(dim) {}
  Variation of(const Expr& f, const std::vector<Slot>& by) const;

private:
  Bracket largest(const Expr& f, double reach) const;
  Bracket with_normal(const Expr& f, double reach) const;
  Jumps jumps(const Expr& f, Slot by) const;

  Ranges ranges_;
  int dim_;
};

} // namespace hvi::solver
