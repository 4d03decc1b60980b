// Compiles expressions into a tape. Equal subexpressions get one register even when they are
// different nodes.
#include "solver/kernel/tape.hpp"

#include "solver/kernel/node.hpp"
#include "solver/kernel/table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <tuple>

namespace hvi::solver {

namespace {

class Compiler {
public:
  Tape compile(std::span<const Expr> expressions) {
    for (const Expr& e : expressions) {
      for (Slot s : e.slots()) tape_.inputs.push_back(s);
    }
    std::ranges::sort(tape_.inputs);
    tape_.inputs.erase(std::unique(tape_.inputs.begin(), tape_.inputs.end()), tape_.inputs.end());
    for (const Expr& e : expressions) {
      const auto fresh = [this](const Expr& node) { return !registers_.contains(node.id()); };
      postorder(e, fresh, [this](const Expr& node) { registers_[node.id()] = emit(node); });
      tape_.outputs.push_back(registers_.at(e.id()));
    }
    return std::move(tape_);
  }

private:
  /// What makes two instructions the same: operation, registers and the bits of the constant.
  using Key = std::tuple<Op, std::int32_t, std::int32_t, std::int32_t, std::uint64_t>;

  std::int32_t emit(const Expr& node) {
    Instruction i{.op = node.op()};
    if (node.is_constant()) i.value = node.value();
    if (node.op() == Op::slot) i.a = input_index(node.slot());
    std::array<std::int32_t*, 3> registers{&i.a, &i.b, &i.c};
    for (std::size_t k = 0; k < node.args().size(); ++k)
      *registers[k] = registers_.at(node.args()[k].id());
    if (node.table()) i.c = table_index(node.table());
    const Key key{i.op, i.a, i.b, i.c, std::bit_cast<std::uint64_t>(i.value)};
    const auto [at, fresh] = known_.try_emplace(key, static_cast<std::int32_t>(tape_.code.size()));
    if (fresh) tape_.code.push_back(i);
    return at->second;
  }

  std::int32_t input_index(Slot s) const {
    return static_cast<std::int32_t>(std::ranges::lower_bound(tape_.inputs, s) -
                                     tape_.inputs.begin());
  }

  std::int32_t table_index(const std::shared_ptr<const Table>& table) {
    const auto at = std::ranges::find(tape_.tables, table);
    const auto index = static_cast<std::int32_t>(at - tape_.tables.begin());
    if (at == tape_.tables.end()) tape_.tables.push_back(table);
    return index;
  }

  Tape tape_;
  NodeMap<std::int32_t> registers_;
  std::map<Key, std::int32_t> known_;
};

} // namespace

Tape compile(std::span<const Expr> expressions) { return Compiler().compile(expressions); }

} // namespace hvi::solver
