// Inside the kernel: the node behind an Expr, and a walk that visits every shared node once without
// recursion, so that neither long sums nor heavily shared graphs can exhaust stack or time.
#pragma once

#include "solver/kernel/expr.hpp"

#include <cstdint>
#include <unordered_map>
#include <unordered_set>

namespace hvi::solver {

struct Expr::Node {
  Op op = Op::constant;
  double value = 0.0;
  Slot slot = -1;
  std::vector<Expr> args;
  std::shared_ptr<const Table> table;
  std::size_t hash = 0;
  std::uint32_t height = 0;                       ///< longest way to a leaf, orders operands
  std::shared_ptr<const std::vector<Slot>> slots; ///< null: none; shared with an argument if equal

  Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  ~Node();
};

/// Builds nodes as they are told to, without simplification.
struct ExprAccess {
  static Expr raw(Op op, std::vector<Expr> args);
  static Expr raw(Op op, std::vector<Expr> args, std::shared_ptr<const Table> table);
  static std::uint32_t height(const Expr& e) { return e.node_->height; }
  static std::shared_ptr<const Expr::Node>& node(Expr& e) { return e.node_; }
  static const std::shared_ptr<const std::vector<Slot>>& slot_set(const Expr& e) {
    return e.node_->slots;
  }
};

/// Number of arguments of an operation; -1 for leaves.
int arity(Op op);
bool is_boolean(const Expr& e); ///< its value is 0, 1 or NaN
/// `e` with other arguments, simplified; `e` itself when they are the same nodes.
Expr with_args(const Expr& e, std::vector<Expr> args);

/// Visits each distinct node below `root` once, arguments before their users. `descend(e)` false
/// skips e and what hangs below it.
template <class Descend, class Visit>
void postorder(const Expr& root, Descend descend, Visit visit) {
  if (!descend(root)) return;
  std::unordered_set<const void*> seen{root.id()};
  std::vector<std::pair<const Expr*, std::size_t>> stack{{&root, 0}};
  while (!stack.empty()) {
    auto& [e, next] = stack.back();
    if (next == e->args().size()) {
      const Expr* done = e;
      stack.pop_back();
      visit(*done);
      continue;
    }
    const Expr* child = &e->args()[next++];
    if (descend(*child) && seen.insert(child->id()).second) stack.emplace_back(child, 0);
  }
}

template <class Visit>
void postorder(const Expr& root, Visit visit) {
  postorder(
      root, [](const Expr&) { return true; }, visit);
}

/// Results of a walk by node.
template <class T>
using NodeMap = std::unordered_map<const void*, T>;

} // namespace hvi::solver
