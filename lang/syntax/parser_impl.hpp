// The parser: the loop over the statements of a script, and those who read them, one for each group
// of productions of the grammar.
#pragma once

#include "lang/syntax/declaration_parser.hpp"
#include "lang/syntax/find_parser.hpp"
#include "lang/syntax/region_parser.hpp"
#include "lang/syntax/report_parser.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace hvi::lang {

class Parser {
public:
  Parser(const SourceFile& source, TokenStream stream, Diagnostics& diagnostics)
      : source_(source), cursor_(source, std::move(stream), diagnostics) {}

  ast::Program program();

private:
  std::optional<ast::Statement> statement();
  void end_of_statement();
  void fail_late_word(std::string_view written);
  [[noreturn]] void fail_no_statement();

  const SourceFile& source_;
  Cursor cursor_;
  NameParser names_{cursor_};
  ExpressionParser expressions_{cursor_, names_};
  RegionParser regions_{cursor_, names_, expressions_};
  DeclarationParser declarations_{cursor_, names_, expressions_};
  FindParser find_{cursor_, names_, expressions_, declarations_};
  ReportParser report_{cursor_, names_, expressions_};
  bool names_lost_ = false; // what the statement would have declared is not known
};

} // namespace hvi::lang
