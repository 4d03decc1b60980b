// Conditions of `where`, `when` and cases. See parser_impl.hpp.
#include "lang/syntax/parser_impl.hpp"

#include <algorithm>

namespace hvi::lang {
namespace {

struct ConditionHeight {
  int operator()(const ast::Compare& node) const {
    return std::max(node.left.depth, node.right.depth);
  }
  int operator()(const ast::Inside&) const { return 0; }
  int operator()(const ast::Not& node) const { return node.operand->depth; }
  int operator()(const ast::And& node) const { return highest(node.operands); }
  int operator()(const ast::Or& node) const { return highest(node.operands); }
  static int highest(const std::vector<ast::Condition>& operands) {
    int result = 0;
    for (const ast::Condition& operand : operands) result = std::max(result, operand.depth);
    return result;
  }
};

bool ends_operand(TokenKind kind) {
  return kind == TokenKind::name || kind == TokenKind::close_paren ||
         kind == TokenKind::close_bracket || kind == TokenKind::prime || kind == TokenKind::number;
}

} // namespace

ast::Condition Parser::make_condition(ast::Condition::Node node, const Span& span) {
  ast::Condition result;
  result.span = span;
  result.depth = 1 + std::visit(ConditionHeight{}, node);
  result.node = std::move(node);
  return result;
}

// Whether "(" opens a sum or a condition is open until its contents are read. Instead of trying
// both (exponential in the nesting), one pass over the tokens marks each "(" that directly contains
// a comparison, `and`, `or`, `not` or `inside(`, or a "(" so marked.
void Parser::find_grouped_conditions() {
  groups_condition_.assign(tokens_.size(), false);
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> open; // index of "(" that may group a condition, or none
  for (std::size_t i = 0; i < tokens_.size(); ++i) {
    const TokenKind kind = tokens_[i].kind;
    const bool group = !open.empty() && open.back() != none;
    if (begins_statement(i) && tokens_[i].first_on_line) {
      open.clear();
    } else if (kind == TokenKind::open_paren) {
      const bool call = i > 0 && ends_operand(tokens_[i - 1].kind) &&
                        text(tokens_[i - 1]) != "where" && text(tokens_[i - 1]) != "when";
      const bool cases = i + 1 < tokens_.size() && tokens_[i + 1].kind == TokenKind::bar;
      const bool inside = call && text(tokens_[i - 1]) == "inside";
      if (group && inside) groups_condition_[open.back()] = true;
      open.push_back(call || cases ? none : i);
    } else if (kind == TokenKind::open_bracket || kind == TokenKind::clarke) {
      open.push_back(none);
    } else if (kind == TokenKind::close_paren || kind == TokenKind::close_bracket) {
      if (open.empty()) continue;
      const bool marked = group && groups_condition_[open.back()];
      open.pop_back();
      if (marked && !open.empty() && open.back() != none) groups_condition_[open.back()] = true;
    } else if (group &&
               (is_comparison(kind) || kind == TokenKind::equal || kind == TokenKind::and_ ||
                kind == TokenKind::or_ || kind == TokenKind::not_)) {
      groups_condition_[open.back()] = true;
    }
  }
}

// condition = and-cond { "or" and-cond } ;
ast::Condition Parser::condition() {
  const Span first = peek().span;
  ast::Condition left = and_condition();
  if (!at(TokenKind::or_)) return left;
  ast::Or result;
  result.operands.push_back(std::move(left));
  while (accept(TokenKind::or_)) result.operands.push_back(and_condition());
  return make_condition(std::move(result), span_from(first));
}

// and-cond = not-cond { "and" not-cond } ;
ast::Condition Parser::and_condition() {
  const Span first = peek().span;
  ast::Condition left = not_condition();
  if (!at(TokenKind::and_)) return left;
  ast::And result;
  result.operands.push_back(std::move(left));
  while (accept(TokenKind::and_)) result.operands.push_back(not_condition());
  return make_condition(std::move(result), span_from(first));
}

// not-cond = [ "not" ] ( sum ( "<" | "<=" | ">" | ">=" | "==" | "!=" ) sum | "inside" "(" name ")"
// | "(" condition ")" ) ;
ast::Condition Parser::not_condition() {
  if (at(TokenKind::not_)) {
    const Span op = take().span;
    const bool twice = at(TokenKind::not_);
    if (twice) fail_expected("a condition");
    ast::Condition operand = not_condition();
    const Span span = join(op, operand.span);
    return make_condition(ast::Not{op, std::move(operand)}, span);
  }
  if (at_word("inside") && peek(1).kind == TokenKind::open_paren) return inside();
  if (at(TokenKind::open_paren) && groups_condition_[at_]) return grouped_condition();
  return comparison();
}

ast::Condition Parser::grouped_condition() {
  const Level level(*this);
  const Token open = take();
  open_.push_back(open);
  ast::Condition result = condition();
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  result.span = span_from(open.span);
  ++result.parens;
  return result;
}

ast::Condition Parser::inside() {
  const Span first = take().span;
  const Token open = take();
  ast::Name part = name("the name of a part");
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  return make_condition(ast::Inside{first, std::move(part)}, span_from(first));
}

ast::Condition Parser::comparison() {
  ast::Compare result;
  result.left = sum();
  result.op_span = peek().span;
  result.op = comparison_sign();
  result.right = sum();
  if (is_comparison(peek().kind))
    fail(diagnose("E0207", peek().span, "comparisons cannot be chained")
             .with_secondary(result.op_span, "the first comparison")
             .with_help("write `a < b and b < c`"));
  const Span span = join(result.left.span, result.right.span);
  return make_condition(std::move(result), span);
}

ast::CompareOp Parser::comparison_sign() {
  switch (peek().kind) {
  case TokenKind::less:
    take();
    return ast::CompareOp::less;
  case TokenKind::less_equal:
    take();
    return ast::CompareOp::less_equal;
  case TokenKind::greater:
    take();
    return ast::CompareOp::greater;
  case TokenKind::greater_equal:
    take();
    return ast::CompareOp::greater_equal;
  case TokenKind::equal_equal:
    take();
    return ast::CompareOp::equal;
  case TokenKind::not_equal:
    take();
    return ast::CompareOp::not_equal;
  case TokenKind::equal:
    break;
  default:
    fail_expected("a comparison (`<`, `<=`, `>`, `>=`, `==`, `!=`)");
  }
  const Token sign = take();
  if (at(TokenKind::greater) && glued(sign, peek())) {
    take();
    report(diagnose("E0212", join(sign.span, previous().span),
                    "greater or equal is written `>=`, not `=>`")
               .with_label("write `>=`"));
    return ast::CompareOp::greater_equal;
  }
  report(diagnose("E0206", sign.span, "a comparison is written `==`, not `=`")
             .with_label("write `==`"));
  return ast::CompareOp::equal;
}

} // namespace hvi::lang
