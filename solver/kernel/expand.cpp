// Expansion to a sum of monomials (algebra.hpp): the normal form in which like terms meet.
#include "solver/kernel/algebra.hpp"
#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::solver {

namespace {

constexpr std::size_t most_terms = 2000; ///< larger products stay factored
constexpr double largest_sum_power = 12; ///< (a + b)^n beyond stays a power

/// base^exponent, the base neither a product nor a whole power.
struct Power {
  Expr base;
  double exponent;
};

/// coefficient * product of powers, sorted by the hash of the base.
struct Monomial {
  double coefficient = 1.0;
  std::vector<Power> powers;
};

using Sum = std::vector<Monomial>;

bool same_powers(const Monomial& a, const Monomial& b) {
  return std::ranges::equal(a.powers, b.powers, [](const Power& p, const Power& q) {
    return p.exponent == q.exponent && p.base == q.base;
  });
}

std::size_t hash_of(const Monomial& m) {
  std::size_t h = 0;
  for (const Power& p : m.powers)
    h = h * 0x9e3779b97f4a7c15ULL + p.base.hash() + std::hash<double>{}(p.exponent);
  return h;
}

Monomial times(const Monomial& a, const Monomial& b) {
  Monomial result{a.coefficient * b.coefficient, a.powers};
  for (const Power& p : b.powers) {
    const auto same =
        std::ranges::find_if(result.powers, [&](const Power& q) { return q.base == p.base; });
    if (same == result.powers.end()) {
      const auto at = std::ranges::upper_bound(result.powers, p.base.hash(), {},
                                               [](const Power& q) { return q.base.hash(); });
      result.powers.insert(at, p);
    } else if (same->exponent += p.exponent; same->exponent == 0.0) {
      result.powers.erase(same);
    }
  }
  return result;
}

/// Like terms added, in the order of their first appearance; zeros dropped.
Sum collected(const Sum& sum) {
  std::unordered_multimap<std::size_t, std::size_t> place;
  Sum result;
  for (const Monomial& m : sum) {
    const std::size_t h = hash_of(m);
    const auto [first, last] = place.equal_range(h);
    const auto like = std::find_if(
        first, last, [&](const auto& entry) { return same_powers(result[entry.second], m); });
    if (like != last) {
      result[like->second].coefficient += m.coefficient;
    } else {
      place.emplace(h, result.size());
      result.push_back(m);
    }
  }
  std::erase_if(result, [](const Monomial& m) { return m.coefficient == 0.0; });
  return result;
}

std::optional<Sum> times(const Sum& a, const Sum& b) {
  if (a.size() * b.size() > most_terms) return {};
  Sum result;
  for (const Monomial& p : a)
    for (const Monomial& q : b) result.push_back(times(p, q));
  return collected(result);
}

Expr rebuilt(const Monomial& m) {
  Expr over = m.coefficient, under = 1.0;
  for (const Power& p : m.powers) {
    // 1/x^2 as a quotient; other negative powers as written.
    const bool below = p.exponent < 0.0 && is_multiplied_power(p.exponent);
    const double n = below ? -p.exponent : p.exponent;
    const Expr factor = n == 0.5 ? sqrt(p.base) : pow(p.base, n);
    (below ? under : over) = (below ? under : over) * factor;
  }
  return over / under;
}

Expr rebuilt(const Sum& sum) {
  Expr total = 0.0;
  for (const Monomial& m : sum) total = total + rebuilt(m);
  return total;
}

Sum atom(const Expr& e, double exponent = 1.0) { return {{1.0, {{e, exponent}}}}; }

/// sum^n; a single monomial may have any sign of n, a longer sum is multiplied out for n > 1.
Sum whole_power(const Sum& sum, double n) {
  if (sum.size() == 1) {
    const double c = scalar_power(sum[0].coefficient, n);
    if (std::isfinite(c)) {
      Monomial m{c, sum[0].powers};
      for (Power& p : m.powers) p.exponent *= n;
      return {m};
    }
  }
  if (sum.size() > 1 && n > 1.0 && n <= largest_sum_power) {
    std::optional<Sum> result = sum;
    for (int k = 1; k < static_cast<int>(n) && result; ++k) result = times(*result, sum);
    if (result) return *result;
  }
  return atom(rebuilt(sum), n);
}

/// The expansion of a node from those of its arguments.
Sum expanded(const Expr& e, const NodeMap<Sum>& done) {
  const auto arg = [&](std::size_t i) -> const Sum& { return done.at(e.args()[i].id()); };
  switch (e.op()) {
  case Op::constant:
    if (e.is(0.0)) return {};
    return {{e.value(), {}}};
  case Op::neg: {
    Sum sum = arg(0);
    for (Monomial& m : sum) m.coefficient = -m.coefficient;
    return sum;
  }
  case Op::add: {
    Sum sum = arg(0);
    sum.insert(sum.end(), arg(1).begin(), arg(1).end());
    return collected(sum);
  }
  case Op::mul:
    if (auto product = times(arg(0), arg(1))) return *product;
    return times(atom(rebuilt(arg(0))), atom(rebuilt(arg(1)))).value();
  case Op::div:
    if (arg(1).empty()) return atom(e); // a division by 0 stays for others to report
    if (arg(1).size() == 1 && arg(1)[0].powers.empty()) { // x/3 is not x * (1/3)
      Sum sum = arg(0);
      for (Monomial& m : sum) m.coefficient /= arg(1)[0].coefficient;
      return sum;
    }
    if (auto quotient = times(arg(0), whole_power(arg(1), -1.0))) return *quotient;
    return atom(e);
  case Op::pow:
    if (!e.args()[1].is_constant()) return atom(e);
    if (is_multiplied_power(e.args()[1].value()) && !arg(0).empty())
      return whole_power(arg(0), e.args()[1].value());
    return atom(e.args()[0], e.args()[1].value());
  case Op::sqrt:
    return atom(e.args()[0], 0.5);
  default:
    return atom(e);
  }
}

/// Expands one addend after the other; what they share is expanded once.
class Expander {
public:
  const Sum& expand(const Expr& e) {
    wanted_.insert(e.id());
    // The arguments of functions are not looked into: they are atoms with all they hold.
    const auto descend = [this](const Expr& node) {
      if (!wanted_.contains(node.id()) || done_.contains(node.id())) return false;
      if (is_algebraic(node))
        for (const Expr& arg : node.args()) wanted_.insert(arg.id());
      return true;
    };
    postorder(e, descend,
              [this](const Expr& node) { done_.emplace(node.id(), expanded(node, done_)); });
    return done_.at(e.id());
  }

private:
  static bool is_algebraic(const Expr& node) {
    return node.op() == Op::add || node.op() == Op::mul || node.op() == Op::div ||
           node.op() == Op::neg || node.op() == Op::pow;
  }

  NodeMap<Sum> done_;
  std::unordered_set<const void*> wanted_;
};

} // namespace

Expr expand(const Expr& e) {
  const std::vector<Expr> terms = addends(e); // a long sum is collected once, not at every plus
  Expander expander;
  Sum sum;
  for (const Expr& term : terms) {
    const Sum& part = expander.expand(term);
    sum.insert(sum.end(), part.begin(), part.end());
  }
  return rebuilt(collected(sum));
}

} // namespace hvi::solver
