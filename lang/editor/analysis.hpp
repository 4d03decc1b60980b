// A script as an editor has it open: compiled with all its mistakes, and its names.
#pragma once

#include "lang/editor/names.hpp"
#include "lang/session.hpp"

#include <map>
#include <memory>
#include <string>
#include <utility>

namespace hvi::lang {

struct Analysis {
  Analysis(const std::string& path, CompileSettings settings, std::string text);

  [[nodiscard]] const Script& script() const { return session.script; }
  [[nodiscard]] const SourceFile& source() const { return script().sources.file(0); }
  [[nodiscard]] std::string text(const Span& span) const {
    return std::string(script().sources.text(span));
  }
  /// What the checker found a name to be; null where a mistake hides it.
  [[nodiscard]] const NameFacts* facts_of(const Definition& definition) const;

  std::map<std::pair<int, std::uint32_t>, NameFacts> facts; ///< by the place of the name
  Session session;
  Tokens tokens; ///< of the script and its imports
  NameIndex names;
};

/// The comment that stands directly above a statement, or behind the name on its line as a text:
/// what its author says of it. Lines of a comment are kept.
[[nodiscard]] std::string comment_of(const Analysis& analysis, const Definition& definition);

/// The call that a byte of the script lies in.
struct OpenCall {
  std::string callee;
  std::size_t open = 0;             ///< index of its bracket among the tokens
  int argument = 0;                 ///< commas before the byte
  std::optional<std::string> named; ///< `name =` of this argument
};

[[nodiscard]] std::optional<OpenCall> call_at(const Analysis& analysis, std::uint32_t offset);

/// The index of the first token of the script that ends behind a byte, or of the last one.
[[nodiscard]] std::size_t token_at(const Analysis& analysis, std::uint32_t offset);

} // namespace hvi::lang
