// Growth beside the end of a piece, as growth on a ray (towards.hpp).
#include "solver/law/towards.hpp"

#include "solver/kernel/algebra.hpp"
#include "solver/kernel/overflow.hpp"
#include "solver/law/supremum.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace hvi::solver {

namespace {

constexpr double far_out = 1e60; ///< R from here on; powers of it stay finite
constexpr double rounding_of_a_sum = 8.0 * 0x1p-52;

/// Puts at + side / R for the argument. What is affine in it is put together, so that r - at is
/// side / R and no difference: a sum that is 0 at `at` but for rounding is 0 there.
class Substitution {
public:
  explicit Substitution(const Beside& end) : end_(end) {}

  Expr operator()(const Expr& e) {
    if (!e.depends_on(slot::r)) return e;
    if (const auto known = done_.find(e.id()); known != done_.end()) return known->second;
    Expr result = put(e);
    done_.emplace(e.id(), result);
    return result;
  }

private:
  Expr put(const Expr& e) {
    if (const auto affine = affine_in(e, slot::r)) {
      const double b = value(affine->second), a = value(affine->first), there = b * end_.at;
      const double sum = a + there;
      const bool zero = std::abs(sum) <= rounding_of_a_sum * (std::abs(a) + std::abs(there));
      if (std::isfinite(sum))
        return Expr(zero ? 0.0 : sum) + Expr(b * end_.side) / Expr::variable(slot::r);
    }
    std::vector<Expr> args;
    for (const Expr& arg : e.args()) args.push_back((*this)(arg));
    if (e.op() == Op::slot) return Expr(end_.at) + Expr(end_.side) / e;
    if (e.table()) return Expr::tabulated(e.table(), args[0], e.op() == Op::table_slope);
    return Expr::make(e.op(), std::move(args));
  }

  double value(const Expr& e) const {
    return evaluate(e, [&](Slot s) { return end_.t.value(s, end_.x); });
  }

  const Beside& end_;
  std::unordered_map<const void*, Expr> done_;
};

bool vanishes(const Expr& f, const Beside& end) {
  const Tail tail = tail_towards(f, end);
  const bool dies = tail.power < 0.0 || (tail.power == 0.0 && tail.log_power < 0.0);
  return dies && tail.coefficient.known && std::isfinite(tail.coefficient.low) &&
         std::isfinite(tail.coefficient.high);
}

} // namespace

Tail tail_towards(const Expr& f, const Beside& end) {
  const Expr outwards = without_overflow(Substitution(end)(f));
  return tail_of(outwards, {slot::r, 1.0, far_out}, fixed_at(end.x, end.t));
}

bool grows_towards(const Expr& f, const Beside& end) {
  const Tail tail = tail_towards(f, end);
  return tail.grows() && tail.coefficient.known && tail.coefficient.low > 0.0;
}

bool has_logarithm(const Expr& e) {
  return e.op() == Op::log || std::ranges::any_of(e.args(), has_logarithm);
}

/// As written first: (r - a) log(r - a) vanishes at a, and no part of r log(r - a) - a log(r - a).
Expr without_vanishing(const Expr& f, const Beside& end) {
  std::vector<Expr> kept;
  bool changed = false;
  const auto drops = [&](const Expr& term) {
    const bool dropped = vanishes(term, end);
    changed = changed || dropped;
    return dropped;
  };
  for (const Expr& term : addends(f)) {
    if (drops(term)) continue;
    for (const Expr& part : addends(expand(term)))
      if (!drops(part)) kept.push_back(part);
  }
  return changed ? sum_of(kept) : f;
}

} // namespace hvi::solver
