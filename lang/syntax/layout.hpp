// Where the formatter breaks lines, what it aligns and where it leaves no blank: read off the
// syntax tree, keyed by the byte offset of the token in the source. See format.cpp.
#pragma once

#include "lang/syntax/ast.hpp"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

namespace hvi::lang {

struct Layout {
  /// Tokens that begin a line, with its indentation.
  std::unordered_map<std::uint32_t, std::size_t> breaks;
  /// Tokens that begin a line when the statement does not fit into one, with its indentation.
  std::unordered_map<std::uint32_t, std::size_t> soft_breaks;
  /// Tokens that stand in one column with the others of their group.
  std::unordered_map<std::uint32_t, int> groups;
  /// Tokens without a blank before them: "(" of calls.
  std::unordered_set<std::uint32_t> glued_left;
  /// Tokens without a blank behind them: signs of negation, names of functions.
  std::unordered_set<std::uint32_t> glued_right;
  /// Tokens with two blanks before them: the doc string of a parameter.
  std::unordered_set<std::uint32_t> set_apart;
  int n_groups = 0;
};

/// The layout of a program without errors.
[[nodiscard]] Layout lay_out(const ast::Program& program);

} // namespace hvi::lang
