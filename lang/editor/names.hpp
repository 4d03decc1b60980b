// The names of a script for an editor: where each is declared and where it stands. Between the
// syntax trees and what an editor asks: definition, references, rename, hover, colours.
#pragma once

#include "lang/script.hpp"
#include "lang/syntax/token.hpp"

#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

enum class NameKind {
  parameter,
  mesh,
  part,
  tensor,
  kernel,
  superpotential,
  state,
  function,
  space,
  unknown,
  test_function,
  column,  ///< of a table
  argument ///< of a kernel, superpotential or function
};

/// "parameter", "superpotential": a word for people.
[[nodiscard]] std::string_view word(NameKind kind);

struct Definition {
  std::string name;
  NameKind kind = NameKind::parameter;
  Span span;         ///< of the name
  Span statement;    ///< all of it
  Span scope;        ///< where the name is visible; invalid: everywhere
  std::string owner; ///< of an argument: what is called with it
};

/// A name where it stands, the place of its declaration included. In `force_x`, a component of the
/// column `force`, it is the part before the `_`.
struct NameUse {
  Span span;
  std::size_t definition = 0; ///< index into NameIndex::definitions
};

struct NameIndex {
  std::vector<Definition> definitions;
  std::vector<NameUse> uses;   ///< by file, then place
  std::set<std::string> words; ///< that stand for a value and are not declared: P1, gauss

  /// The use that covers a byte of a file, its end included.
  [[nodiscard]] const NameUse* at(int file, std::uint32_t offset) const;
  /// What is declared under this name and visible at a place of the script.
  [[nodiscard]] const Definition* visible(std::string_view name, const Span& place) const;
};

/// The tokens of each file of a script, by the file's id.
using Tokens = std::vector<TokenStream>;

[[nodiscard]] Tokens tokens_of(const SourceMap& sources);

/// A statement that is being written has mistakes and no tree: its names are read from its tokens.
[[nodiscard]] NameIndex index_names(const Script& script, const Tokens& tokens);

/// The tokens from a statement word to the next one: the statement that holds a byte of a file, or
/// nothing before the first.
[[nodiscard]] std::span<const Token> statement_at(const TokenStream& stream, std::uint32_t offset);

} // namespace hvi::lang
