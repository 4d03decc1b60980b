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

// primary = number | string | name | list | "(" expr ")" ;
ast::Expr Parser::primary() {
  switch (peek().kind) {
  case TokenKind::number:
    return number();
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
    return parenthesised();
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

// list = "[" expr { "," expr } "]" ;
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
