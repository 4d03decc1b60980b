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

double value_of_node(const Expr& e, const NodeMap<double>& done,
                     const std::function<double(Slot)>& value_of) {
  if (e.is_constant()) return e.value();
  if (e.op() == Op::slot) return value_of(e.slot());
  double v[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < e.args().size(); ++i) v[i] = done.at(e.args()[i].id());
  if (e.op() == Op::table) return e.table()->value(v[0]);
  if (e.op() == Op::table_slope) return e.table()->slope(v[0]);
  return apply(e.op(), v[0], v[1], v[2]);
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
  NodeMap<double> done;
  postorder(expr, [&](const Expr& e) { done.emplace(e.id(), value_of_node(e, done, value_of)); });
  return done.at(expr.id());
}

} // namespace hvi::solver
