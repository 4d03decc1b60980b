// Conditions of `where`, `when` and cases. See expression_parser.hpp.
#include "lang/syntax/expression_parser.hpp"

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

ast::Condition ExpressionParser::make_condition(ast::Condition::Node node, const Span& span) {
  ast::Condition result;
  result.span = span;
  result.depth = 1 + std::visit(ConditionHeight{}, node);
  result.node = std::move(node);
  return result;
}

// Whether "(" opens a sum or a condition is open until its contents are read. Instead of trying
// both (exponential in the nesting), one pass over the tokens marks each "(" that directly contains
// a comparison, `and`, `or`, `not` or `inside(`, or a "(" so marked.
void ExpressionParser::find_grouped_conditions() {
  groups_condition_.assign(cursor_.tokens().size(), false);
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> open; // index of "(" that may group a condition, or none
  for (std::size_t i = 0; i < cursor_.tokens().size(); ++i) {
    const TokenKind kind = cursor_.tokens()[i].kind;
    const bool group = !open.empty() && open.back() != none;
    if (cursor_.begins_statement(i) && cursor_.tokens()[i].first_on_line) {
      open.clear();
    } else if (kind == TokenKind::open_paren) {
      const bool call = i > 0 && ends_operand(cursor_.tokens()[i - 1].kind) &&
                        cursor_.text(cursor_.tokens()[i - 1]) != "where" &&
                        cursor_.text(cursor_.tokens()[i - 1]) != "when";
      const bool cases =
          i + 1 < cursor_.tokens().size() && cursor_.tokens()[i + 1].kind == TokenKind::bar;
      const bool inside = call && cursor_.text(cursor_.tokens()[i - 1]) == "inside";
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
ast::Condition ExpressionParser::condition() {
  const Span first = cursor_.peek().span;
  ast::Condition left = and_condition();
  if (!cursor_.at(TokenKind::or_)) return left;
  ast::Or result;
  result.operands.push_back(std::move(left));
  while (cursor_.accept(TokenKind::or_)) result.operands.push_back(and_condition());
  return make_condition(std::move(result), cursor_.span_from(first));
}

// and-cond = not-cond { "and" not-cond } ;
ast::Condition ExpressionParser::and_condition() {
  const Span first = cursor_.peek().span;
  ast::Condition left = not_condition();
  if (!cursor_.at(TokenKind::and_)) return left;
  ast::And result;
  result.operands.push_back(std::move(left));
  while (cursor_.accept(TokenKind::and_)) result.operands.push_back(not_condition());
  return make_condition(std::move(result), cursor_.span_from(first));
}

// not-cond = [ "not" ] ( sum ( "<" | "<=" | ">" | ">=" | "==" | "!=" ) sum | "inside" "(" name ")"
// | "(" condition ")" ) ;
ast::Condition ExpressionParser::not_condition() {
  if (cursor_.at(TokenKind::not_)) {
    const Span op = cursor_.take().span;
    const bool twice = cursor_.at(TokenKind::not_);
    if (twice) cursor_.fail_expected("a condition");
    ast::Condition operand = not_condition();
    const Span span = join(op, operand.span);
    return make_condition(ast::Not{op, std::move(operand)}, span);
  }
  if (cursor_.at_word("inside") && cursor_.peek(1).kind == TokenKind::open_paren) return inside();
  if (cursor_.at(TokenKind::open_paren) && groups_condition_[cursor_.place()])
    return grouped([this] { return condition(); });
  return comparison();
}

ast::Condition ExpressionParser::inside() {
  const Span first = cursor_.take().span;
  const Token open = cursor_.take();
  ast::Name part = names_.name("the name of a part");
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  return make_condition(ast::Inside{first, std::move(part)}, cursor_.span_from(first));
}

ast::Condition ExpressionParser::comparison() {
  ast::Compare result;
  result.left = sum();
  result.op_span = cursor_.peek().span;
  result.op = comparison_sign();
  result.right = sum();
  if (is_comparison(cursor_.peek().kind))
    cursor_.fail(diagnose("E0207", cursor_.peek().span, "comparisons cannot be chained")
                     .with_secondary(result.op_span, "the first comparison")
                     .with_help("write `a < b and b < c`"));
  const Span span = join(result.left.span, result.right.span);
  return make_condition(std::move(result), span);
}

ast::CompareOp ExpressionParser::comparison_sign() {
  switch (cursor_.peek().kind) {
  case TokenKind::less:
    cursor_.take();
    return ast::CompareOp::less;
  case TokenKind::less_equal:
    cursor_.take();
    return ast::CompareOp::less_equal;
  case TokenKind::greater:
    cursor_.take();
    return ast::CompareOp::greater;
  case TokenKind::greater_equal:
    cursor_.take();
    return ast::CompareOp::greater_equal;
  case TokenKind::equal_equal:
    cursor_.take();
    return ast::CompareOp::equal;
  case TokenKind::not_equal:
    cursor_.take();
    return ast::CompareOp::not_equal;
  case TokenKind::equal:
    break;
  default:
    cursor_.fail_expected("a comparison (`<`, `<=`, `>`, `>=`, `==`, `!=`)");
  }
  const Token sign = cursor_.take();
  if (cursor_.at(TokenKind::greater) && cursor_.glued(sign, cursor_.peek())) {
    cursor_.take();
    cursor_.report(diagnose("E0212", join(sign.span, cursor_.previous().span),
                            "greater or equal is written `>=`, not `=>`")
                       .with_label("write `>=`"));
    return ast::CompareOp::greater_equal;
  }
  cursor_.report(diagnose("E0206", sign.span, "a comparison is written `==`, not `=`")
                     .with_label("write `==`"));
  return ast::CompareOp::equal;
}

} // namespace hvi::lang
