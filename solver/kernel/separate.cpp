// Separation of variables (algebra.hpp).
#include "solver/kernel/algebra.hpp"
#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/simplify.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr std::size_t most_separated = 400; ///< a separation with more terms is of no use
constexpr double largest_power = 12;

using Result = std::optional<Separated>;

/// The two sides of a sum in which every term has only one of them: a(first) + b(second).
struct Sides {
  Expr first = 0.0, second = 0.0;
};

Separated negative(Separated terms) {
  for (auto& term : terms) term.first = -term.first;
  return terms;
}

Result product_of(const Separated& a, const Separated& b) {
  if (a.size() * b.size() > most_separated) return {};
  Separated terms;
  for (const auto& [f, g] : a)
    for (const auto& [p, q] : b) terms.emplace_back(f * p, g * q);
  return terms;
}

Separated joined(Separated a, const Separated& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// c and e with c e the expression; c / g counts as c times 1 / g.
std::pair<double, Expr> without_coefficient(const Expr& expression) {
  const auto [c, base] = rules::split_coefficient(expression);
  if (!base) return {c, 1.0};
  if (base->op() != Op::div || !base->args()[0].is_constant()) return {c, *base};
  return {c * base->args()[0].value(), 1.0 / base->args()[1]};
}

/// Moves the sign of a constant first part to the second, so that roots see positive constants.
std::pair<Expr, Expr> sign_moved(const std::pair<Expr, Expr>& term) {
  const auto [c, base] = rules::split_coefficient(term.first);
  if (c >= 0.0) return term;
  return {-term.first, -term.second};
}

class Separator {
public:
  explicit Separator(const std::function<bool(Slot)>& in_second) : in_second_(in_second) {}

  Result separate(const Expr& e) {
    const auto known = [this](const Expr& node) { return !done_.contains(node.id()); };
    postorder(e, known, [this](const Expr& node) { done_.emplace(node.id(), of_node(node)); });
    return done_.at(e.id());
  }

private:
  bool only_first(const Expr& e) const { return std::ranges::none_of(e.slots(), in_second_); }
  bool only_second(const Expr& e) const { return std::ranges::all_of(e.slots(), in_second_); }

  Result of_node(const Expr& e) {
    if (e.is(0.0)) return Separated();
    if (only_first(e)) return {{{e, 1.0}}};
    if (only_second(e)) return {{{1.0, e}}};
    if (e.op() == Op::select) return of_select(e);
    std::vector<Separated> args;
    for (const Expr& arg : e.args()) {
      const Result& part = done_.at(arg.id());
      if (!part) return {};
      args.push_back(*part);
    }
    switch (e.op()) {
    case Op::add:
      return joined(args[0], args[1]);
    case Op::neg:
      return negative(args[0]);
    case Op::mul:
      return product_of(args[0], args[1]);
    case Op::div: {
      const Result reciprocal = each_part(args[1], [](const Expr& p) { return 1.0 / p; });
      return reciprocal ? product_of(args[0], *reciprocal) : Result();
    }
    case Op::pow:
      return of_power(e, args[0], args[1]);
    case Op::sqrt:
      return rooted(args[0], [](const Expr& p) { return sqrt(p); });
    case Op::abs:
      return each_part(args[0], [](const Expr& p) { return abs(p); });
    case Op::sign:
      return each_part(args[0], [](const Expr& p) { return Expr::make(Op::sign, {p}); });
    case Op::exp:
      if (const auto s = sides(args[0])) return {{{exp(s->first), exp(s->second)}}};
      return {};
    case Op::log:
      return of_log(args[0]);
    case Op::sin:
    case Op::cos:
      return of_angle(e.op(), args[0]);
    default:
      return {};
    }
  }

  /// For a function with h(f g) = h(f) h(g), of a single term.
  template <class F>
  static Result each_part(const Separated& terms, F h) {
    if (terms.size() != 1) return {};
    return {{{h(terms[0].first), h(terms[0].second)}}};
  }

  /// The same for roots, which need a factor that cannot be negative.
  template <class F>
  static Result rooted(const Separated& terms, F h) {
    if (terms.size() != 1) return {};
    const auto term = sign_moved(terms[0]);
    if (!is_nonnegative(term.first) && !is_nonnegative(term.second)) return {};
    return each_part(Separated{term}, h);
  }

  static Result of_log(const Separated& terms) {
    if (terms.size() != 1) return {};
    const auto [f, g] = sign_moved(terms[0]);
    if (!is_nonnegative(f) && !is_nonnegative(g)) return {};
    return {{{log(f), 1.0}, {1.0, log(g)}}};
  }

  static std::optional<Sides> sides(const Separated& terms) {
    Sides found;
    for (const auto& [f, g] : terms) {
      if (g.is_constant())
        found.first = found.first + f * g;
      else if (f.is_constant())
        found.second = found.second + f * g;
      else
        return {};
    }
    return found;
  }

  static Result of_power(const Expr& e, const Separated& base, const Separated& exponent) {
    const Expr& n = e.args()[1];
    if (!n.is_constant()) { // c^(a + b) with a positive number c
      const auto s = sides(exponent);
      const Expr& c = e.args()[0];
      if (!s || !c.is_constant() || c.value() <= 0.0) return {};
      return {{{pow(c, s->first), pow(c, s->second)}}};
    }
    const auto raise = [&n](const Expr& p) { return pow(p, n); };
    if (!is_multiplied_power(n.value())) return rooted(base, raise);
    if (base.size() == 1) return each_part(base, raise);
    if (n.value() < 0.0 || n.value() > largest_power) return {};
    Result result = base;
    for (int k = 1; k < static_cast<int>(n.value()) && result; ++k) {
      result = product_of(*result, base);
      if (result) result = merged(*result);
    }
    return result;
  }

  /// sin(a + b), cos(a + b) by the addition theorems.
  static Result of_angle(Op op, const Separated& angle) {
    const auto s = sides(angle);
    if (!s) return {};
    const Expr &a = s->first, &b = s->second;
    if (op == Op::sin) return {{{sin(a), cos(b)}, {cos(a), sin(b)}}};
    return {{{cos(a), cos(b)}, {-sin(a), sin(b)}}};
  }

  Result of_select(const Expr& e) {
    const Result &then = done_.at(e.args()[1].id()), &otherwise = done_.at(e.args()[2].id());
    if (!then || !otherwise) return {};
    return cases(e.args()[0], *then, *otherwise);
  }

  /// `condition` decides between two separated sums. A condition on one group masks that group's
  /// part of every term; what is masked is not multiplied, so it may be NaN.
  Result cases(const Expr& condition, const Separated& then, const Separated& otherwise) const {
    if (only_first(condition) || only_second(condition)) {
      Separated terms;
      for (const bool yes : {true, false})
        for (auto [f, g] : yes ? then : otherwise) {
          Expr& masked = only_second(condition) ? g : f;
          masked = yes ? select(condition, masked, 0.0) : select(condition, 0.0, masked);
          terms.emplace_back(f, g);
        }
      return merged(terms);
    }
    const auto& parts = condition.args();
    Result inner;
    if (condition.op() == Op::logic_and) {
      inner = cases(parts[1], then, otherwise);
      return inner ? cases(parts[0], *inner, otherwise) : Result();
    }
    if (condition.op() == Op::logic_or) {
      inner = cases(parts[1], then, otherwise);
      return inner ? cases(parts[0], then, *inner) : Result();
    }
    if (condition.op() == Op::logic_not) return cases(parts[0], otherwise, then);
    return {};
  }

public:
  /// Merges terms with equal second parts, then terms with equal first parts.
  static Separated merged(const Separated& terms) {
    return merged_by(merged_by(terms, true), false);
  }

private:
  /// by_second: terms with the same `second` up to a constant become one; else the other way round.
  static Separated merged_by(const Separated& terms, bool by_second) {
    Separated result;
    std::unordered_multimap<std::size_t, std::size_t> place;
    for (const auto& [f, g] : terms) {
      const auto split = without_coefficient(by_second ? g : f);
      const Expr& key = split.second;
      const Expr other = split.first * (by_second ? f : g);
      const auto [first, last] = place.equal_range(key.hash());
      const auto same = std::find_if(first, last, [&](const auto& entry) {
        return key == (by_second ? result[entry.second].second : result[entry.second].first);
      });
      if (same != last) {
        Expr& sum = by_second ? result[same->second].first : result[same->second].second;
        sum = sum + other;
        continue;
      }
      place.emplace(key.hash(), result.size());
      result.push_back(by_second ? std::pair(other, key) : std::pair(key, other));
    }
    std::erase_if(result,
                  [](const auto& term) { return term.first.is(0.0) || term.second.is(0.0); });
    return result;
  }

  const std::function<bool(Slot)>& in_second_;
  NodeMap<Result> done_;
};

/// Constant factors to the first part.
Separated normalised(Separated terms) {
  for (auto& [f, g] : terms) {
    const auto [c, second] = without_coefficient(g);
    f = c * f;
    g = second;
  }
  return terms;
}

} // namespace

std::optional<Separated> split_separable(const Expr& e,
                                         const std::function<bool(Slot)>& in_second) {
  Separator separator(in_second);
  Result found = separator.separate(e);
  const Expr expanded = found ? e : expand(e);
  if (!found && !(expanded == e)) found = separator.separate(expanded);
  if (!found) return {};
  return normalised(Separator::merged(*found));
}

} // namespace hvi::solver
