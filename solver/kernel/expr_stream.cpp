// See expr_stream.hpp.
#include "solver/kernel/expr_stream.hpp"

#include "solver/kernel/node.hpp"
#include "solver/kernel/table.hpp"

#include <memory>
#include <utility>

namespace hvi::solver {
namespace {

using Number = std::uint32_t; ///< of a node, in the order of writing

void put_table(StateWriter& w, const Table& table) {
  put_text(w, table.name());
  w.put(table.interpolation());
  w.put(table.abscissae());
  w.put(table.ordinates());
}

std::shared_ptr<const Table> get_table(StateReader& r) {
  std::string name = get_text(r);
  const auto kind = r.get<Table::Interpolation>();
  auto x = r.get_vector<double>(), y = r.get_vector<double>();
  return std::make_shared<const Table>(std::move(name), std::move(x), std::move(y), kind);
}

void put_node(StateWriter& w, const Expr& e, const NodeMap<Number>& numbers,
              NodeMap<Number>& tables) {
  w.put(e.op());
  if (e.op() == Op::constant) return w.put(e.value());
  if (e.op() == Op::slot) return w.put(e.slot());
  std::vector<Number> args;
  for (const Expr& arg : e.args()) args.push_back(numbers.at(arg.id()));
  w.put(args);
  if (e.op() != Op::table && e.op() != Op::table_slope) return;
  const auto [at, fresh] = tables.emplace(e.table().get(), static_cast<Number>(tables.size()));
  w.put(at->second);
  if (fresh) put_table(w, *e.table());
}

Expr get_node(StateReader& r, const std::vector<Expr>& nodes,
              std::vector<std::shared_ptr<const Table>>& tables) {
  const Op op = r.get_between(Op::constant, Op::polygamma);
  if (op == Op::constant) return {r.get<double>()};
  if (op == Op::slot) return Expr::variable(r.get<Slot>());
  std::vector<Expr> args;
  for (const Number arg : r.get_vector<Number>()) {
    if (arg >= nodes.size()) r.fail("is inconsistent");
    args.push_back(nodes[arg]);
  }
  if (op != Op::table && op != Op::table_slope) return ExprAccess::raw(op, std::move(args));
  const auto table = r.get_between<Number>(0, static_cast<Number>(tables.size()));
  if (table == tables.size()) tables.push_back(get_table(r));
  return ExprAccess::raw(op, std::move(args), tables[table]);
}

} // namespace

void put_expressions(StateWriter& w, std::span<const Expr> expressions) {
  NodeMap<Number> numbers, tables;
  std::vector<Expr> nodes;
  for (const Expr& expression : expressions)
    postorder(
        expression, [&](const Expr& e) { return !numbers.contains(e.id()); },
        [&](const Expr& e) {
          if (numbers.emplace(e.id(), static_cast<Number>(nodes.size())).second) nodes.push_back(e);
        });
  w.put(static_cast<Number>(nodes.size()));
  for (const Expr& node : nodes) put_node(w, node, numbers, tables);
  w.put(static_cast<Number>(expressions.size()));
  for (const Expr& expression : expressions) w.put(numbers.at(expression.id()));
}

std::vector<Expr> get_expressions(StateReader& r) {
  std::vector<Expr> nodes, out;
  std::vector<std::shared_ptr<const Table>> tables;
  for (auto left = r.get<Number>(); left > 0; --left) nodes.push_back(get_node(r, nodes, tables));
  for (auto left = r.get<Number>(); left > 0; --left) {
    const auto number = r.get<Number>();
    if (number >= nodes.size()) r.fail("is inconsistent");
    out.push_back(nodes[number]);
  }
  return out;
}

} // namespace hvi::solver
