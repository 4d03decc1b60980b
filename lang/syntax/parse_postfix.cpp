// Expressions: names, numbers, lists, calls, members and the derivative of Clarke. See
// parser_impl.hpp.
#include "lang/syntax/parser_impl.hpp"

#include <charconv>
#include <limits>

namespace hvi::lang {

// postfix = primary { "." name | "'" | call-tail | clarke-tail } ;
ast::Expr Parser::postfix() {
  ast::Expr result = primary();
  for (;;) {
    const Span first = result.span;
    if (accept(TokenKind::dot)) {
      ast::Name member = member_name();
      result = make(ast::Member{std::move(result), std::move(member)}, span_from(first));
    } else if (at(TokenKind::prime)) {
      // 4 'cells': a text in the wrong quotes, not the derivative of a number.
      if (previous().kind == TokenKind::number && !glued(previous(), peek())) fail_on_known_slip();
      const Span op = take().span;
      result = make(ast::Prime{op, std::move(result)}, span_from(first));
    } else if (at(TokenKind::open_paren)) {
      result = call_tail(std::move(result));
    } else if (at(TokenKind::clarke)) {
      result = clarke_tail(std::move(result));
    } else {
      return result;
    }
  }
}

// primary = number [ unit-tail ] | string | name | list | "(" expr ")" [ unit-tail ] ;
ast::Expr Parser::primary() {
  switch (peek().kind) {
  case TokenKind::number:
    return with_unit(number());
  case TokenKind::string: {
    ast::Text text = string();
    return make(ast::String{std::move(text.text)}, text.span);
  }
  case TokenKind::name:
    if (at_clause_word()) fail_expected("an expression");
    return reference();
  case TokenKind::open_bracket:
    return list();
  case TokenKind::open_paren:
    return with_unit(parenthesised());
  default:
    break;
  }
  // A statement word within a line is meant as a name: say so once and go on.
  if (is_statement_word(peek().kind) && !peek().first_on_line) return reference();
  if (at(TokenKind::bar) && peek().first_on_line) fail_at_line_end("an expression");
  fail_expected("an expression");
}

ast::Expr Parser::number() {
  const Token token = take();
  const std::string_view digits = text(token);
  double value = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  // What the lexer has called no number is none for the checker either.
  if (read.ec != std::errc{} || read.ptr != digits.data() + digits.size())
    value = std::numeric_limits<double>::quiet_NaN();
  return make(ast::Number{value}, token.span);
}

// unit = unit-power { ( "*" | "/" ) unit-power } ;
ast::UnitText Parser::unit() {
  const std::size_t first = at_;
  do unit_power();
  while (accept(TokenKind::star) || accept(TokenKind::slash));
  std::string compact; // as breaks of lines and comments may stand in it
  for (std::size_t i = first; i < at_; ++i) compact += text(tokens_[i]);
  return {std::move(compact), span_from(tokens_[first].span)};
}

// unit-power = ( name | number | "(" unit ")" ) [ "^" ( unit-exponent | "(" unit-exponent ")" ) ] ;
void Parser::unit_power() {
  if (at(TokenKind::open_paren)) {
    const Level level(*this);
    const Token open = take();
    unit();
    if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
    take();
  } else if (at(TokenKind::name) || at(TokenKind::number)) {
    take();
  } else {
    fail(diagnose("E0230", peek().span, "expected a unit, " + found(peek()))
             .with_help("units are written like `[MPa]`, `[kg/m^3]`, `[1/s]`"));
  }
  if (!accept(TokenKind::caret)) return;
  const bool in_parentheses = accept(TokenKind::open_paren);
  unit_exponent();
  if (in_parentheses) expect(TokenKind::close_paren);
}

// unit-exponent = [ "-" ] number [ "/" number ] ;
void Parser::unit_exponent() {
  accept(TokenKind::minus);
  expect(TokenKind::number, "the power of a unit");
  const bool inside = peek(1).kind == TokenKind::number && peek(2).kind == TokenKind::close_paren;
  if (at(TokenKind::slash) && inside) {
    take();
    take();
  }
}

// unit-tail = "[" unit "]" ;
ast::UnitText Parser::unit_in_brackets() {
  const Token open = take();
  open_.push_back(open);
  ast::UnitText result = unit();
  if (at(TokenKind::name))
    fail(diagnose("E0230", peek().span, "units are joined by `*` or `/`")
             .with_help("write `[N*m]` for the product, `[N/m]` for the quotient"));
  if (!at(TokenKind::close_bracket)) fail_unclosed(open, TokenKind::close_bracket);
  take();
  open_.pop_back();
  result.span = span_from(open.span);
  units_.push_back(result);
  return result;
}

ast::Expr Parser::with_unit(ast::Expr value) {
  if (!at(TokenKind::open_bracket)) return value;
  const Span first = value.span;
  ast::UnitText unit = unit_in_brackets();
  return make(ast::Quantity{std::move(value), std::move(unit)}, span_from(first));
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

ast::Expr Parser::reference() {
  ast::Name read = name("a name");
  return make(ast::Reference{std::move(read.text)}, read.span);
}

ast::Expr Parser::parenthesised() {
  const Level level(*this);
  const Token open = take();
  open_.push_back(open);
  ast::Expr result = expr();
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  result.span = span_from(open.span);
  ++result.parens;
  return result;
}

// list = "[" expr { "," expr } "]" [ unit-tail ] ;
ast::Expr Parser::list() {
  const Level level(*this);
  const Token open = expect(TokenKind::open_bracket, "a list `[...]`");
  open_.push_back(open);
  ast::List result;
  do result.items.push_back(expr());
  while (accept(TokenKind::comma));
  if (!at(TokenKind::close_bracket)) fail_unclosed(open, TokenKind::close_bracket);
  take();
  open_.pop_back();
  if (at(TokenKind::open_bracket)) give_unit(result, unit_in_brackets());
  return make(std::move(result), span_from(open.span));
}

// call = name { "." name } call-tail ;
void Parser::check_callee(const ast::Expr& callee) {
  const ast::Expr* base = &callee;
  while (const auto* member = std::get_if<ast::Member>(&base->node)) {
    if (base->parens > 0) break;
    base = &*member->object;
  }
  if (base->parens == 0 && std::holds_alternative<ast::Reference>(base->node)) return;
  fail(diagnose("E0220", peek().span, "only a name can be called")
           .with_secondary(callee.span, "this is not a name")
           .with_help("a product is written with `*`"));
}

// call-tail = "(" [ argument { "," argument } ] ")" ;
ast::Expr Parser::call_tail(ast::Expr callee) {
  check_callee(callee);
  const Level level(*this);
  const Span first = callee.span;
  const Token open = take();
  open_.push_back(open);
  ast::Call result;
  result.open = open.span;
  result.arguments = arguments(open, callee);
  result.close = take().span;
  open_.pop_back();
  result.callee = std::move(callee);
  return make(std::move(result), span_from(first));
}

std::vector<ast::Argument> Parser::arguments(const Token& open, const ast::Expr& callee) {
  std::vector<ast::Argument> result;
  if (at(TokenKind::close_paren)) return result;
  do {
    // isotropic(lambda = 1,5, ...): a number glued to a named one is no positional argument.
    const bool number_behind_named =
        !result.empty() && result.back().name && glued(previous(), peek());
    if (number_behind_named && at(TokenKind::number)) {
      --at_;
      if (at_decimal_comma()) fail_decimal_comma();
      ++at_;
    }
    result.push_back(argument());
  } while (accept(TokenKind::comma));
  if (at(TokenKind::semicolon)) {
    const std::string law(source_.text(callee.span));
    fail(diagnose("E0214", peek().span, "`;` in a call")
             .with_label("arguments are separated by `,`")
             .with_secondary(open.span, "expected `^0(` for the derivative of a law")
             .with_help("the generalised directional derivative is written `" + law + "^0(u; v)`"));
  }
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  return result;
}

// argument = [ name "=" ] expr ;
ast::Argument Parser::argument() {
  ast::Argument result;
  const Span first = peek().span;
  const bool named = at(TokenKind::name) || is_statement_word(peek().kind);
  if (named && peek(1).kind == TokenKind::equal) {
    result.name = member_name();
    take();
  }
  result.value = expr();
  result.span = span_from(first);
  return result;
}

// clarke-tail = "^0(" expr ";" expr ")" ;
ast::Expr Parser::clarke_tail(ast::Expr law) {
  const Level level(*this);
  const Span first = law.span;
  const Token open = take();
  open_.push_back(open);
  ast::Clarke result;
  result.op = open.span;
  result.at = expr();
  if (at(TokenKind::comma))
    fail(diagnose("E0228", peek().span, "point and direction are separated by `;`")
             .with_label("write `;`")
             .with_help("`j^0(u; v)` is the derivative of j at u in the direction v"));
  if (at(TokenKind::close_paren))
    fail(diagnose("E0228", peek().span, "the direction is missing")
             .with_label("expected `; direction`")
             .with_help("`j^0(u; v)` is the derivative of j at u in the direction v"));
  if (!at(TokenKind::semicolon)) fail_unclosed(open, TokenKind::semicolon);
  take();
  result.direction = expr();
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  result.law = std::move(law);
  return make(std::move(result), span_from(first));
}

} // namespace hvi::lang
