// Parts and the regions they name. See region_parser.hpp.
#include "lang/syntax/region_parser.hpp"

namespace hvi::lang {

// part = "part" name "=" region ;
ast::Part RegionParser::part() {
  ast::Part result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the part");
  cursor_.expect(TokenKind::equal);
  result.region = region();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// region = region-term { ( "+" | "-" ) region-term } [ "where" condition ] ;
ast::Region RegionParser::region() {
  ast::Region result;
  const Span first = cursor_.peek().span;
  result.terms.push_back(region_term());
  while (cursor_.at(TokenKind::plus) || cursor_.at(TokenKind::minus)) {
    const Token sign = cursor_.take();
    ast::RegionTerm term = region_term();
    term.minus = sign.kind == TokenKind::minus;
    term.op = sign.span;
    result.terms.push_back(std::move(term));
  }
  if (cursor_.accept_word("where")) result.where = expressions_.condition();
  result.span = cursor_.span_from(first);
  return result;
}

// region-term = name { "." name | call-tail } | "(" region ")" ;
ast::RegionTerm RegionParser::region_term() {
  ast::RegionTerm result;
  if (!cursor_.at(TokenKind::open_paren)) {
    result.term = region_path();
    result.span = std::get<ast::Expr>(result.term).span;
    return result;
  }
  const Cursor::Level level(cursor_);
  const Token open = cursor_.take();
  cursor_.opened(open);
  result.term = Box<ast::Region>(region());
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  result.span = cursor_.span_from(open.span);
  return result;
}

ast::Expr RegionParser::region_path() {
  ast::Name base = names_.name("a region such as `slab.top`");
  ast::Expr result = expressions_.make(ast::Reference{std::move(base.text)}, base.span);
  while (cursor_.at(TokenKind::dot) || cursor_.at(TokenKind::open_paren)) {
    const Span first = result.span;
    if (cursor_.at(TokenKind::open_paren)) {
      result = expressions_.call_tail(std::move(result));
      continue;
    }
    cursor_.take();
    ast::Name member = names_.member_name();
    result = expressions_.make(ast::Member{std::move(result), std::move(member)},
                               cursor_.span_from(first));
  }
  return result;
}

} // namespace hvi::lang
