// Nodes of expressions: building, sharing, hashing, comparing. The rules that simplify are in
// simplify*.cpp.
#include "solver/kernel/expr.hpp"

#include "solver/kernel/node.hpp"
#include "solver/kernel/table.hpp"

#include <algorithm>
#include <bit>
#include <iterator>

namespace hvi::solver {

namespace {

/// The finaliser of SplitMix64, by which every output bit depends on every input bit (G. L. Steele,
/// D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014).
std::size_t mix(std::size_t h) {
  h ^= h >> 30;
  h *= 0xbf58476d1ce4e5b9ULL;
  h ^= h >> 27;
  h *= 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

std::size_t combine(std::size_t seed, std::size_t h) {
  return mix(seed + 0x9e3779b97f4a7c15ULL + mix(h));
}

std::size_t hash_of(const Expr::Node& node) {
  std::size_t h = mix(static_cast<std::size_t>(node.op) + 1);
  if (node.op == Op::constant) h = combine(h, std::bit_cast<std::uint64_t>(node.value));
  if (node.op == Op::slot) h = combine(h, static_cast<std::size_t>(slot::order_key(node.slot)));
  // By name, not by address: the order of operands follows the hash and must not change from run
  // to run.
  if (node.table) h = combine(h, std::hash<std::string>{}(node.table->name()));
  for (const Expr& arg : node.args) h = combine(h, arg.hash());
  return h;
}

using SlotSet = std::shared_ptr<const std::vector<Slot>>;

/// Union of two sets; one of the two itself whenever it holds the other, so that the sets of a
/// large graph are few.
SlotSet unite(const SlotSet& a, const SlotSet& b) {
  if (a == b || !b) return a;
  if (!a) return b;
  if (std::ranges::includes(*a, *b)) return a;
  if (std::ranges::includes(*b, *a)) return b;
  auto both = std::make_shared<std::vector<Slot>>();
  std::ranges::set_union(*a, *b, std::back_inserter(*both));
  return both;
}

/// Equality of the two nodes without their arguments.
bool same_head(const Expr& a, const Expr& b) {
  if (a.hash() != b.hash() || a.op() != b.op() || a.args().size() != b.args().size()) return false;
  if (a.op() == Op::constant)
    return std::bit_cast<std::uint64_t>(a.value()) == std::bit_cast<std::uint64_t>(b.value());
  if (a.op() == Op::slot) return a.slot() == b.slot();
  return a.table() == b.table();
}

} // namespace

/// Destroys a deep graph in a loop, and without an allocation: there may be no memory left. A node
/// that nothing else holds loses its arguments before it is destroyed, so that its destructor does
/// not recurse; on the way down the place of the visited argument stores the pointer to go back.
Expr::Node::~Node() {
  std::shared_ptr<const Node> here, above; // null: this node, and what is above it
  const auto list_of = [this](const std::shared_ptr<const Node>& node) -> std::vector<Expr>& {
    return node ? const_cast<Node&>(*node).args : args; // about to die, and nobody else sees it
  };
  for (;;) {
    std::vector<Expr>& list = list_of(here);
    if (list.empty()) {
      if (!here) return;
      here = std::move(above);
      above = std::move(ExprAccess::node(list_of(here).back()));
      list_of(here).pop_back();
    } else if (auto child = std::move(ExprAccess::node(list.back()));
               child.use_count() == 1 && !child->args.empty()) {
      ExprAccess::node(list.back()) = std::move(above);
      above = std::move(here);
      here = std::move(child);
    } else {
      list.pop_back();
    }
  }
}

Expr ExprAccess::raw(Op op, std::vector<Expr> args) { return raw(op, std::move(args), nullptr); }

Expr ExprAccess::raw(Op op, std::vector<Expr> args, std::shared_ptr<const Table> table) {
  auto node = std::make_shared<Expr::Node>();
  node->op = op;
  node->args = std::move(args);
  node->table = std::move(table);
  for (const Expr& arg : node->args) {
    node->slots = unite(node->slots, slot_set(arg));
    node->height = std::max(node->height, height(arg) + 1);
  }
  node->hash = hash_of(*node);
  return Expr(std::move(node));
}

namespace {

std::shared_ptr<const Expr::Node> number(double value) {
  auto node = std::make_shared<Expr::Node>();
  node->value = value == 0.0 ? 0.0 : value; // one zero, so that equal constants are equal bits
  node->hash = hash_of(*node);
  return node;
}

/// Most numbers that derivatives and products make are 0 and 1: these have one node each.
std::shared_ptr<const Expr::Node> shared_number(double value) {
  static const auto zero = number(0.0), one = number(1.0);
  return value == 0.0 ? zero : value == 1.0 ? one : number(value);
}

} // namespace

Expr::Expr(double value) : node_(shared_number(value)) {}

Expr Expr::variable(Slot slot) {
  auto node = std::make_shared<Node>();
  node->op = Op::slot;
  node->slot = slot;
  node->slots = std::make_shared<std::vector<Slot>>(1, slot);
  node->hash = hash_of(*node);
  return Expr(std::move(node));
}

Op Expr::op() const { return node_->op; }
double Expr::value() const { return node_->value; }
Slot Expr::slot() const { return node_->slot; }
std::span<const Expr> Expr::args() const { return node_->args; }
const std::shared_ptr<const Table>& Expr::table() const { return node_->table; }
std::size_t Expr::hash() const { return node_->hash; }

std::span<const Slot> Expr::slots() const {
  return node_->slots ? std::span<const Slot>(*node_->slots) : std::span<const Slot>();
}

bool Expr::depends_on(Slot slot) const { return std::ranges::binary_search(slots(), slot); }

bool Expr::depends_on_any(Slot first, Slot past) const {
  const auto at = std::ranges::lower_bound(slots(), first);
  return at != slots().end() && *at < past;
}

bool operator==(const Expr& a, const Expr& b) {
  if (a.id() == b.id()) return true;
  if (!same_head(a, b)) return false;
  if (a.args().empty()) return true;
  std::vector<std::pair<const Expr*, const Expr*>> stack{{&a, &b}};
  std::unordered_map<const void*, const void*> compared; // pairs already on their way
  while (!stack.empty()) {
    const auto [p, q] = stack.back();
    stack.pop_back();
    for (std::size_t i = 0; i < p->args().size(); ++i) {
      const Expr &l = p->args()[i], &r = q->args()[i];
      if (l.id() == r.id()) continue;
      if (!same_head(l, r)) return false;
      if (l.args().empty()) continue;
      const auto [at, fresh] = compared.try_emplace(l.id(), r.id());
      if (fresh || at->second != r.id()) stack.emplace_back(&l, &r);
    }
  }
  return true;
}

std::vector<Slot> slots_of(const Expr& expr) { return {expr.slots().begin(), expr.slots().end()}; }

} // namespace hvi::solver
