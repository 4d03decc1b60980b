// Expressions and conditions.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"
#include "lang/syntax/name_parser.hpp"

#include <vector>

namespace hvi::lang {

class ExpressionParser {
public:
  ExpressionParser(Cursor& cursor, NameParser& names) : cursor_(cursor), names_(names) {}

  ast::Expr expr();
  ast::Expr sum();
  ast::Expr power();
  ast::UnitText unit();
  ast::UnitText unit_in_brackets();
  ast::Expr list();
  ast::Expr call_tail(ast::Expr callee);
  ast::Expr make(ast::Expr::Node node, const Span& span);
  ast::Condition condition();
  void find_grouped_conditions();

  bool in_integral = false; ///< within the integrand of a form
  std::vector<ast::UnitText> take_units() { return std::move(units_); }

private:
  ast::Expr cases();
  ast::Case single_case();
  void check_colon_as_arrow(const ast::Condition& condition);
  ast::Expr contraction();
  ast::Expr product();
  ast::Expr unary();
  ast::Expr postfix();
  ast::Expr primary();
  ast::Expr number();
  void unit_power();
  void unit_exponent();
  ast::Expr with_unit(ast::Expr value);
  ast::Expr reference();
  std::vector<ast::Argument> arguments(const Token& open, const ast::Expr& callee);
  ast::Argument argument();
  ast::Expr clarke_tail(ast::Expr law);
  ast::Expr binary(ast::BinaryOp op, const Span& op_span, ast::Expr left, ast::Expr right);
  void check_callee(const ast::Expr& callee);
  template <class Parse>
  auto grouped(Parse inner);
  ast::Condition and_condition();
  ast::Condition not_condition();
  ast::Condition comparison();
  ast::Condition inside();
  ast::CompareOp comparison_sign();
  ast::Condition make_condition(ast::Condition::Node node, const Span& span);

  Cursor& cursor_;
  NameParser& names_;
  std::vector<ast::UnitText> units_;   // of the file so far
  std::vector<bool> groups_condition_; // by token: a "(" around a condition
};

/// "(" inner ")": an expression or a condition, which counts its parentheses.
template <class Parse>
auto ExpressionParser::grouped(Parse inner) {
  const Cursor::Level level(cursor_);
  const Token open = cursor_.take();
  cursor_.opened(open);
  auto result = inner();
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  result.span = cursor_.span_from(open.span);
  ++result.parens;
  return result;
}

} // namespace hvi::lang
