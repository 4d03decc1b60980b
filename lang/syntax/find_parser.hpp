// The find statement.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"
#include "lang/syntax/declaration_parser.hpp"
#include "lang/syntax/expression_parser.hpp"
#include "lang/syntax/name_parser.hpp"

namespace hvi::lang {

class FindParser {
public:
  FindParser(Cursor& cursor, NameParser& names, ExpressionParser& expressions,
             DeclarationParser& declarations)
      : cursor_(cursor), names_(names), expressions_(expressions), declarations_(declarations) {}

  ast::Find find();

private:
  void find_clauses(ast::Find& find);
  void find_clause(ast::Find& find, int clause);
  void such_that(ast::Find& find);
  void imposed_values(ast::Find& find);
  ast::ImposedValue imposed_value();
  ast::TimeClause time_clause();
  void test_functions(ast::Find& find);
  void settings(ast::Find& find);
  void relation(ast::Find& find);
  ast::Form form();
  void recover_in_form();
  ast::FormTerm form_term();
  ast::Integral integral();
  void check_after_integral();
  ast::Expr factor();
  [[noreturn]] void fail_no_integral(const Span& term);
  [[noreturn]] void fail_no_integrand();

  Cursor& cursor_;
  NameParser& names_;
  ExpressionParser& expressions_;
  DeclarationParser& declarations_;
};

} // namespace hvi::lang
