// Parts and the regions they name. See parser_impl.hpp.
#include "lang/syntax/parser_impl.hpp"

namespace hvi::lang {

// part = "part" name "=" region ;
ast::Part Parser::part() {
  ast::Part result;
  result.keyword = take().span;
  result.name = declared_name("the name of the part");
  expect(TokenKind::equal);
  result.region = region();
  result.span = span_from(result.keyword);
  return result;
}

// region = region-term { ( "+" | "-" ) region-term } [ "where" condition ] ;
ast::Region Parser::region() {
  ast::Region result;
  const Span first = peek().span;
  result.terms.push_back(region_term());
  while (at(TokenKind::plus) || at(TokenKind::minus)) {
    const Token sign = take();
    ast::RegionTerm term = region_term();
    term.minus = sign.kind == TokenKind::minus;
    term.op = sign.span;
    result.terms.push_back(std::move(term));
  }
  if (accept_word("where")) result.where = condition();
  result.span = span_from(first);
  return result;
}

// region-term = name { "." name | call-tail } | "(" region ")" ;
ast::RegionTerm Parser::region_term() {
  ast::RegionTerm result;
  if (!at(TokenKind::open_paren)) {
    result.term = region_path();
    result.span = std::get<ast::Expr>(result.term).span;
    return result;
  }
  const Level level(*this);
  const Token open = take();
  open_.push_back(open);
  result.term = Box<ast::Region>(region());
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  result.span = span_from(open.span);
  return result;
}

ast::Expr Parser::region_path() {
  ast::Name base = name("a region such as `slab.top`");
  ast::Expr result = make(ast::Reference{std::move(base.text)}, base.span);
  while (at(TokenKind::dot) || at(TokenKind::open_paren)) {
    const Span first = result.span;
    if (at(TokenKind::open_paren)) {
      result = call_tail(std::move(result));
      continue;
    }
    take();
    ast::Name member = member_name();
    result = make(ast::Member{std::move(result), std::move(member)}, span_from(first));
  }
  return result;
}

} // namespace hvi::lang
