// Names and texts.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

class NameParser {
public:
  explicit NameParser(Cursor& cursor) : cursor_(cursor) {}

  ast::Name name(std::string_view what);
  ast::Name declared_name(std::string_view what);
  ast::Name member_name();
  ast::Text string();
  std::optional<ast::Text> optional_string();

  // Of the statement that is read.
  void note_declared(ast::Name name) { declared_.push_back(std::move(name)); }
  [[nodiscard]] const std::vector<ast::Name>& declared() const { return declared_; }
  void forget_declared() { declared_.clear(); }

private:
  Cursor& cursor_;
  std::vector<ast::Name> declared_;      // by the statement being read
  std::set<std::string> reserved_names_; // words that were reported as names
};

} // namespace hvi::lang
