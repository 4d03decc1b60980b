// Walks that rebuild or evaluate an expression: transform, substitute, evaluate.
#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/table.hpp"

#include <algorithm>

namespace hvi::solver {

namespace {

/// The arguments of e after their rewriting.
std::vector<Expr> rewritten_args(const Expr& e, const NodeMap<Expr>& done) {
  std::vector<Expr> args;
  args.reserve(e.args().size());
  for (const Expr& arg : e.args()) {
    const auto at = done.find(arg.id());
    args.push_back(at == done.end() ? arg : at->second);
  }
  return args;
}

using ValueOf = std::function<double(Slot)>;

/// The value of e, whose arguments have the values `of_arg(arg)`.
template <class OfArg>
double value_of_node(const Expr& e, const OfArg& of_arg, const ValueOf& value_of) {
  if (e.is_constant()) return e.value();
  if (e.op() == Op::slot) return value_of(e.slot());
  double v[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < e.args().size(); ++i) v[i] = of_arg(e.args()[i]);
  if (e.op() == Op::table) return e.table()->value(v[0]);
  if (e.op() == Op::table_slope) return e.table()->slope(v[0]);
  return apply(e.op(), v[0], v[1], v[2]);
}

/// The same by recursion, shared nodes again each time; `visits` below zero: given up.
double walk(const Expr& e, const ValueOf& value_of, int& visits) {
  if (--visits < 0) return 0.0;
  return value_of_node(
      e, [&](const Expr& arg) { return walk(arg, value_of, visits); }, value_of);
}

} // namespace

Expr transform(const Expr& expr, const std::function<Expr(const Expr&)>& f) {
  NodeMap<Expr> done;
  postorder(expr, [&](const Expr& e) {
    done.emplace(e.id(), f(e.args().empty() ? e : with_args(e, rewritten_args(e, done))));
  });
  return done.at(expr.id());
}

Expr substitute(const Expr& expr, std::span<const std::pair<Slot, Expr>> replacements) {
  const auto touched = [&](const Expr& e) {
    return std::ranges::any_of(replacements, [&](const auto& r) { return e.depends_on(r.first); });
  };
  if (!touched(expr)) return expr;
  NodeMap<Expr> done;
  postorder(expr, touched, [&](const Expr& e) {
    if (e.op() != Op::slot) {
      done.emplace(e.id(), with_args(e, rewritten_args(e, done)));
      return;
    }
    const auto at = std::ranges::find(replacements, e.slot(), &std::pair<Slot, Expr>::first);
    done.emplace(e.id(), at->second);
  });
  return done.at(expr.id());
}

double evaluate(const Expr& expr, const std::function<double(Slot)>& value_of) {
  int visits = 64; // most expressions are this small: no table of nodes for them
  if (const double value = walk(expr, value_of, visits); visits >= 0) return value;
  NodeMap<double> done;
  const auto of_arg = [&](const Expr& arg) { return done.at(arg.id()); };
  postorder(expr, [&](const Expr& e) { done.emplace(e.id(), value_of_node(e, of_arg, value_of)); });
  return done.at(expr.id());
}

} // namespace hvi::solver
