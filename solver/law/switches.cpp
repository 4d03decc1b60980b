// Finding and resolving the switches of a law (switches.hpp).
#include "solver/law/switches.hpp"

#include "solver/kernel/table.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace hvi::solver {

namespace {

struct ExprHash {
  std::size_t operator()(const Expr& e) const { return e.hash(); }
};
using Memo = std::unordered_map<Expr, Expr, ExprHash>;

bool is_natural(const Expr& e) {
  return e.is_constant() && e.value() >= 0.0 && e.value() == std::floor(e.value());
}

/// The switch a node makes, if any.
bool switch_of(const Expr& e, Switch& out) {
  const auto args = e.args();
  const Slot r = slot::argument(0);
  switch (e.op()) {
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::min:
  case Op::max:
    out = {e, args[0] - args[1], Switch::Kind::two_sided};
    break;
  case Op::abs:
  case Op::sign:
    out = {e, args[0], Switch::Kind::two_sided};
    break;
  case Op::table:
  case Op::table_slope:
    out = {e, args[0], Switch::Kind::table};
    break;
  case Op::sqrt:
  case Op::log:
    out = {e, args[0], Switch::Kind::singular};
    break;
  case Op::div:
    out = {e, args[1], Switch::Kind::singular};
    break;
  case Op::tan:
    out = {e, Expr::make(Op::cos, {args[0]}), Switch::Kind::singular};
    break;
  case Op::asin:
  case Op::acos:
    out = {e, Expr(1.0) - args[0] * args[0], Switch::Kind::singular};
    break;
  case Op::pow:
    if (is_natural(args[1])) return false;
    out = {e, args[0], Switch::Kind::singular};
    break;
  default:
    return false;
  }
  return out.function.depends_on(r);
}

class Finder {
public:
  std::vector<Switch> switches;

  /// Post-order, so that a switch comes after those its function contains.
  void visit(const Expr& e) {
    if (!e.depends_on(slot::argument(0))) return;
    if (!seen_.emplace(e, e).second) return;
    const auto before = switches.size();
    for (const Expr& a : e.args()) visit(a);
    Switch s;
    if (!switch_of(e, s)) return;
    s.nested = contains_choice(s.function);
    const bool known =
        std::any_of(switches.begin(), switches.begin() + static_cast<std::ptrdiff_t>(before),
                    [&](const Switch& o) {
                      return s.kind == Switch::Kind::singular && o.function == s.function;
                    });
    if (!known) switches.push_back(s);
  }

private:
  static bool contains_choice(const Expr& e) {
    Switch s;
    if (switch_of(e, s) && s.kind != Switch::Kind::singular) return true;
    return std::any_of(e.args().begin(), e.args().end(), contains_choice);
  }
  Memo seen_;
};

/// A table on one of its intervals: the affine or cubic Hermite function there, else the table.
Expr resolve_table(const Expr& node, const Expr& x, int interval) {
  const bool slope = node.op() == Op::table_slope;
  const Table& table = *node.table();
  const auto& xs = table.abscissae();
  if (interval < 1 || interval >= static_cast<int>(xs.size()))
    return Expr::tabulated(node.table(), x, slope);
  const double a = xs[interval - 1], b = xs[interval], h = b - a;
  const double ya = table.value(a), yb = table.value(b), d = (yb - ya) / h;
  const Expr s = x - Expr(a);
  if (table.interpolation() == Table::Interpolation::linear)
    return slope ? Expr(d) : Expr(ya) + Expr(d) * s;
  const double ma = table.slope(a), mb = table.slope(b);
  const double c2 = (3.0 * d - 2.0 * ma - mb) / h, c3 = (ma + mb - 2.0 * d) / (h * h);
  if (slope) return Expr(ma) + s * (Expr(2.0 * c2) + s * Expr(3.0 * c3));
  return Expr(ya) + s * (Expr(ma) + s * (Expr(c2) + s * Expr(c3)));
}

Expr resolve_switch(const Switch& s, int outcome, const std::vector<Expr>& args) {
  switch (s.node.op()) {
  case Op::less:
    return Expr(outcome < 0 ? 1.0 : 0.0);
  case Op::less_equal:
    return Expr(outcome <= 0 ? 1.0 : 0.0);
  case Op::equal:
    return Expr(outcome == 0 ? 1.0 : 0.0);
  case Op::min:
    return outcome <= 0 ? args[0] : args[1];
  case Op::max:
    return outcome >= 0 ? args[0] : args[1];
  case Op::abs:
    return outcome >= 0 ? args[0] : -args[0];
  case Op::sign:
    return Expr(static_cast<double>(outcome));
  default:
    return resolve_table(s.node, args[0], outcome);
  }
}

Expr rebuild(const Expr& e, std::vector<Expr> args) {
  if (args.empty()) return e;
  if (e.op() == Op::table || e.op() == Op::table_slope)
    return Expr::tabulated(e.table(), args[0], e.op() == Op::table_slope);
  return Expr::make(e.op(), std::move(args));
}

class Specialiser {
public:
  Specialiser(const std::vector<Switch>& switches, const Signature& signature)
      : switches_(switches), signature_(signature) {
    for (std::size_t i = 0; i < signature.size(); ++i)
      if (switches[i].kind != Switch::Kind::singular && signature[i] != open_outcome)
        index_.emplace(switches[i].node, static_cast<int>(i));
  }

  Expr operator()(const Expr& e) {
    if (e.args().empty() || !e.depends_on(slot::argument(0))) return e;
    if (const auto found = memo_.find(e); found != memo_.end()) return found->second;
    Expr result = build(e);
    memo_.emplace(e, result);
    return result;
  }

private:
  Expr build(const Expr& e) {
    std::vector<Expr> args;
    if (e.op() == Op::select) { // the branch not taken must not be built: it may be undefined
      const Expr condition = (*this)(e.args()[0]);
      if (condition.is_constant()) return (*this)(e.args()[condition.value() != 0.0 ? 1 : 2]);
    }
    for (const Expr& a : e.args()) args.push_back((*this)(a));
    const auto found = index_.find(e);
    if (found == index_.end()) return rebuild(e, std::move(args));
    return resolve_switch(switches_[found->second], signature_[found->second], args);
  }

  const std::vector<Switch>& switches_;
  const Signature& signature_;
  std::unordered_map<Expr, int, ExprHash> index_;
  Memo memo_;
};

} // namespace

std::vector<Switch> find_switches(std::span<const Expr> expressions) {
  Finder finder;
  for (const Expr& e : expressions) finder.visit(e);
  return std::move(finder.switches);
}

int outcome_of(const Switch& s, double value) {
  switch (s.kind) {
  case Switch::Kind::singular:
    return 0;
  case Switch::Kind::two_sided:
    return value < 0.0 ? -1 : (value > 0.0 ? 1 : 0);
  case Switch::Kind::table: {
    const auto& xs = s.node.table()->abscissae();
    return static_cast<int>(std::upper_bound(xs.begin(), xs.end(), value) - xs.begin());
  }
  }
  return 0;
}

bool contains(const Expr& expr, const Expr& part) {
  bool found = false;
  transform(expr, [&](const Expr& e) {
    found = found || e == part;
    return e;
  });
  return found;
}

Expr specialise(const Expr& expr, const std::vector<Switch>& switches, const Signature& signature) {
  return Specialiser(switches, signature)(expr);
}

Expr expose_kinks(const Expr& expr) {
  const auto even = [](const Expr& e) {
    return e.op() == Op::pow && e.args()[1].is_constant() &&
           std::fmod(e.args()[1].value(), 2.0) == 0.0;
  };
  const auto square = [](const Expr& e) { return e.op() == Op::mul && e.args()[0] == e.args()[1]; };
  return transform(expr, [&](const Expr& e) {
    if (e.op() != Op::sqrt && e.op() != Op::pow) return e;
    const Expr inner = e.args()[0];
    const Expr exponent = e.op() == Op::sqrt ? Expr(0.5) : e.args()[1];
    if (is_natural(exponent)) return e;
    if (square(inner)) return pow(abs(inner.args()[0]), exponent * Expr(2.0));
    if (even(inner)) return pow(abs(inner.args()[0]), exponent * inner.args()[1]);
    return e;
  });
}

} // namespace hvi::solver
