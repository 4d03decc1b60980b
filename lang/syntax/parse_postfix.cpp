// Expressions: names, numbers, lists, calls, members and the derivative of Clarke. See
// expression_parser.hpp.
#include "lang/syntax/expression_parser.hpp"

#include <charconv>
#include <limits>

namespace hvi::lang {

// postfix = primary { "." name | "'" | call-tail | clarke-tail } ;
ast::Expr ExpressionParser::postfix() {
  ast::Expr result = primary();
  for (;;) {
    const Span first = result.span;
    if (cursor_.accept(TokenKind::dot)) {
      ast::Name member = names_.member_name();
      result = make(ast::Member{std::move(result), std::move(member)}, cursor_.span_from(first));
    } else if (cursor_.at(TokenKind::prime)) {
      // 4 'cells': a text in the wrong quotes, not the derivative of a number.
      if (cursor_.previous().kind == TokenKind::number &&
          !cursor_.glued(cursor_.previous(), cursor_.peek()))
        cursor_.fail_on_known_slip();
      const Span op = cursor_.take().span;
      result = make(ast::Prime{op, std::move(result)}, cursor_.span_from(first));
    } else if (cursor_.at(TokenKind::open_paren)) {
      result = call_tail(std::move(result));
    } else if (cursor_.at(TokenKind::clarke)) {
      result = clarke_tail(std::move(result));
    } else {
      return result;
    }
  }
}

// primary = number [ unit-tail ] | string | name | list | "(" expr ")" [ unit-tail ] ;
ast::Expr ExpressionParser::primary() {
  switch (cursor_.peek().kind) {
  case TokenKind::number:
    return with_unit(number());
  case TokenKind::string: {
    ast::Text text = names_.string();
    return make(ast::String{std::move(text.text)}, text.span);
  }
  case TokenKind::name:
    if (cursor_.at_clause_word()) cursor_.fail_expected("an expression");
    return reference();
  case TokenKind::open_bracket:
    return list();
  case TokenKind::open_paren:
    return with_unit(grouped([this] { return expr(); }));
  default:
    break;
  }
  // A statement word within a line is meant as a name: say so once and go on.
  if (is_statement_word(cursor_.peek().kind) && !cursor_.peek().first_on_line) return reference();
  if (cursor_.at(TokenKind::bar) && cursor_.peek().first_on_line)
    cursor_.fail_at_line_end("an expression");
  if (cursor_.at(TokenKind::plus))
    cursor_.fail(diagnose("E0201", cursor_.peek().span, "expected an expression, found `+`")
                     .with_label("expected an expression")
                     .with_help("leave it out"));
  cursor_.fail_expected("an expression");
}

ast::Expr ExpressionParser::number() {
  const Token token = cursor_.take();
  const std::string_view digits = cursor_.text(token);
  double value = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  // What the lexer has called no number is none for the checker either.
  if (read.ec != std::errc{} || read.ptr != digits.data() + digits.size())
    value = std::numeric_limits<double>::quiet_NaN();
  return make(ast::Number{value}, token.span);
}

// unit = unit-power { ( "*" | "/" ) unit-power } ;
ast::UnitText ExpressionParser::unit() {
  const std::size_t first = cursor_.place();
  do unit_power();
  while (cursor_.accept(TokenKind::star) || cursor_.accept(TokenKind::slash));
  std::string compact; // as breaks of lines and comments may stand in it
  for (std::size_t i = first; i < cursor_.place(); ++i)
    compact += cursor_.text(cursor_.tokens()[i]);
  return {std::move(compact), cursor_.span_from(cursor_.tokens()[first].span)};
}

// unit-power = ( name | number | "(" unit ")" ) [ "^" ( unit-exponent | "(" unit-exponent ")" ) ] ;
void ExpressionParser::unit_power() {
  if (cursor_.at(TokenKind::open_paren)) {
    const Cursor::Level level(cursor_);
    const Token open = cursor_.take();
    unit();
    if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
    cursor_.take();
  } else if (cursor_.at(TokenKind::name) || cursor_.at(TokenKind::number)) {
    cursor_.take();
  } else {
    cursor_.fail(
        diagnose("E0230", cursor_.peek().span, "expected a unit, " + cursor_.found(cursor_.peek()))
            .with_help("units are written like `[MPa]`, `[kg/m^3]`, `[1/s]`"));
  }
  if (!cursor_.accept(TokenKind::caret)) return;
  const bool in_parentheses = cursor_.accept(TokenKind::open_paren);
  unit_exponent();
  if (in_parentheses) cursor_.expect(TokenKind::close_paren);
}

// unit-exponent = [ "-" ] number [ "/" number ] ;
void ExpressionParser::unit_exponent() {
  cursor_.accept(TokenKind::minus);
  cursor_.expect(TokenKind::number, "the power of a unit");
  const bool inside =
      cursor_.peek(1).kind == TokenKind::number && cursor_.peek(2).kind == TokenKind::close_paren;
  if (cursor_.at(TokenKind::slash) && inside) {
    cursor_.take();
    cursor_.take();
  }
}

// unit-tail = "[" unit "]" ;
ast::UnitText ExpressionParser::unit_in_brackets() {
  const Token open = cursor_.take();
  cursor_.opened(open);
  ast::UnitText result = unit();
  if (cursor_.at(TokenKind::name))
    cursor_.fail(diagnose("E0230", cursor_.peek().span, "units are joined by `*` or `/`")
                     .with_help("write `[N*m]` for the product, `[N/m]` for the quotient"));
  if (!cursor_.at(TokenKind::close_bracket)) cursor_.fail_unclosed(open, TokenKind::close_bracket);
  cursor_.take();
  cursor_.closed();
  result.span = cursor_.span_from(open.span);
  units_.push_back(result);
  return result;
}

ast::Expr ExpressionParser::with_unit(ast::Expr value) {
  if (!cursor_.at(TokenKind::open_bracket)) return value;
  const Span first = value.span;
  ast::UnitText unit = unit_in_brackets();
  return make(ast::Quantity{std::move(value), std::move(unit)}, cursor_.span_from(first));
}

namespace {

/// [0, 10] [s]: each entry with the unit.
void give_unit(ast::List& list, const ast::UnitText& unit) {
  for (ast::Expr& item : list.items) {
    if (auto* inner = std::get_if<ast::List>(&item.node)) {
      give_unit(*inner, unit);
      continue;
    }
    ast::Expr given;
    given.span = item.span;
    given.depth = item.depth + 1;
    given.node = ast::Quantity{std::move(item), unit};
    item = std::move(given);
  }
}

} // namespace

ast::Expr ExpressionParser::reference() {
  ast::Name read = names_.name("a name");
  return make(ast::Reference{std::move(read.text)}, read.span);
}

// list = "[" expr { "," expr } "]" [ unit-tail ] ;
ast::Expr ExpressionParser::list() {
  const Cursor::Level level(cursor_);
  const Token open = cursor_.expect(TokenKind::open_bracket, "a list `[...]`");
  cursor_.opened(open);
  ast::List result;
  do result.items.push_back(expr());
  while (cursor_.accept(TokenKind::comma));
  if (!cursor_.at(TokenKind::close_bracket)) cursor_.fail_unclosed(open, TokenKind::close_bracket);
  cursor_.take();
  cursor_.closed();
  if (cursor_.at(TokenKind::open_bracket)) give_unit(result, unit_in_brackets());
  return make(std::move(result), cursor_.span_from(open.span));
}

// call = name { "." name } call-tail ;
void ExpressionParser::check_callee(const ast::Expr& callee) {
  const ast::Expr* base = &callee;
  while (const auto* member = std::get_if<ast::Member>(&base->node)) {
    if (base->parens > 0) break;
    base = &*member->object;
  }
  if (base->parens == 0 && std::holds_alternative<ast::Reference>(base->node)) return;
  cursor_.fail(diagnose("E0220", cursor_.peek().span, "only a name can be called")
                   .with_secondary(callee.span, "this is not a name")
                   .with_help("a product is written with `*`"));
}

// call-tail = "(" [ argument { "," argument } ] ")" ;
ast::Expr ExpressionParser::call_tail(ast::Expr callee) {
  check_callee(callee);
  const Cursor::Level level(cursor_);
  const Span first = callee.span;
  const Token open = cursor_.take();
  cursor_.opened(open);
  ast::Call result;
  result.open = open.span;
  result.arguments = arguments(open, callee);
  result.close = cursor_.take().span;
  cursor_.closed();
  result.callee = std::move(callee);
  return make(std::move(result), cursor_.span_from(first));
}

std::vector<ast::Argument> ExpressionParser::arguments(const Token& open, const ast::Expr& callee) {
  std::vector<ast::Argument> result;
  if (cursor_.at(TokenKind::close_paren)) return result;
  do {
    // isotropic(lambda = 1,5, ...): a number glued to a named one is no positional argument.
    const bool number_behind_named =
        !result.empty() && result.back().name && cursor_.glued(cursor_.previous(), cursor_.peek());
    if (number_behind_named && cursor_.at(TokenKind::number)) cursor_.check_decimal_comma_before();
    result.push_back(argument());
  } while (cursor_.accept(TokenKind::comma));
  if (cursor_.at(TokenKind::semicolon)) {
    const std::string law(cursor_.text(callee.span));
    cursor_.fail(
        diagnose("E0214", cursor_.peek().span, "`;` in a call")
            .with_label("arguments are separated by `,`")
            .with_secondary(open.span, "expected `^0(` for the derivative of a law")
            .with_help("the generalised directional derivative is written `" + law + "^0(u; v)`"));
  }
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  return result;
}

// argument = [ name "=" ] expr ;
ast::Argument ExpressionParser::argument() {
  ast::Argument result;
  const Span first = cursor_.peek().span;
  const bool named = cursor_.at(TokenKind::name) || is_statement_word(cursor_.peek().kind);
  if (named && cursor_.peek(1).kind == TokenKind::equal) {
    result.name = names_.member_name();
    cursor_.take();
  }
  result.value = expr();
  result.span = cursor_.span_from(first);
  return result;
}

// clarke-tail = "^0(" expr ";" expr ")" ;
ast::Expr ExpressionParser::clarke_tail(ast::Expr law) {
  const Cursor::Level level(cursor_);
  const Span first = law.span;
  const Token open = cursor_.take();
  cursor_.opened(open);
  ast::Clarke result;
  result.op = open.span;
  result.at = expr();
  if (cursor_.at(TokenKind::comma))
    cursor_.fail(diagnose("E0228", cursor_.peek().span, "point and direction are separated by `;`")
                     .with_label("write `;`")
                     .with_help("`j^0(u; v)` is the derivative of j at u in the direction v"));
  if (cursor_.at(TokenKind::close_paren))
    cursor_.fail(diagnose("E0228", cursor_.peek().span, "the direction is missing")
                     .with_label("expected `; direction`")
                     .with_help("`j^0(u; v)` is the derivative of j at u in the direction v"));
  if (!cursor_.at(TokenKind::semicolon)) cursor_.fail_unclosed(open, TokenKind::semicolon);
  cursor_.take();
  result.direction = expr();
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  result.law = std::move(law);
  return make(std::move(result), cursor_.span_from(first));
}

} // namespace hvi::lang
