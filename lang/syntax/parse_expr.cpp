// Expressions, from the loosest binding to powers. See expression_parser.hpp; the rest of the chain
// is in parse_postfix.cpp.
#include "lang/syntax/expression_parser.hpp"

#include <algorithm>

namespace hvi::lang {

namespace {

/// Height of one tree, which long chains (a + b + c + ...) add to. Later phases recurse over it.
constexpr int max_height = 1200;

} // namespace
namespace {

int height(const std::vector<ast::Expr>& items) {
  int result = 0;
  for (const ast::Expr& item : items) result = std::max(result, item.depth);
  return result;
}

struct Height {
  int operator()(const ast::Number&) const { return 0; }
  int operator()(const ast::Quantity& node) const { return node.value->depth; }
  int operator()(const ast::String&) const { return 0; }
  int operator()(const ast::Reference&) const { return 0; }
  int operator()(const ast::List& node) const { return height(node.items); }
  int operator()(const ast::Negate& node) const { return node.operand->depth; }
  int operator()(const ast::Binary& node) const {
    return std::max(node.left->depth, node.right->depth);
  }
  int operator()(const ast::Cases& node) const {
    int result = node.otherwise->depth;
    for (const ast::Case& c : node.cases)
      result = std::max({result, c.condition.depth, c.value.depth});
    return result;
  }
  int operator()(const ast::Member& node) const { return node.object->depth; }
  int operator()(const ast::Prime& node) const { return node.operand->depth; }
  int operator()(const ast::Call& node) const {
    int result = node.callee->depth;
    for (const ast::Argument& a : node.arguments) result = std::max(result, a.value.depth);
    return result;
  }
  int operator()(const ast::Clarke& node) const {
    return std::max({node.law->depth, node.at->depth, node.direction->depth});
  }
};

} // namespace

ast::Expr ExpressionParser::make(ast::Expr::Node node, const Span& span) {
  ast::Expr result;
  result.span = span;
  result.depth = 1 + std::visit(Height{}, node);
  result.node = std::move(node);
  if (result.depth > max_height)
    cursor_.fail(
        diagnose("E0216", cursor_.peek().span, "this expression is too long")
            .with_note("at most " + std::to_string(max_height) + " operations build on each other")
            .with_help("give parts of it a name with `fn` or `tensor`"));
  return result;
}

ast::Expr ExpressionParser::binary(ast::BinaryOp op, const Span& op_span, ast::Expr left,
                                   ast::Expr right) {
  const Span span = join(left.span, right.span);
  return make(ast::Binary{op, op_span, std::move(left), std::move(right)}, span);
}

// expr = cases | sum ;
ast::Expr ExpressionParser::expr() { return cursor_.at(TokenKind::bar) ? cases() : sum(); }

// cases = "|" condition "->" sum { "|" condition "->" sum } "|" "otherwise" "->" sum ;
ast::Expr ExpressionParser::cases() {
  const Span first = cursor_.peek().span;
  ast::Cases result;
  while (cursor_.at(TokenKind::bar) && cursor_.peek(1).kind != TokenKind::otherwise)
    result.cases.push_back(single_case());
  const bool same_line = !cursor_.peek().first_on_line;
  if (same_line && (cursor_.at(TokenKind::name) || cursor_.at(TokenKind::number) ||
                    cursor_.at(TokenKind::open_paren)))
    cursor_.fail_operator_missing("the next case");
  if (cursor_.at(TokenKind::otherwise))
    cursor_.fail(diagnose("E0208", cursor_.peek().span, "a `|` is missing before `otherwise`")
                     .with_label("write `| otherwise`"));
  if (!cursor_.at(TokenKind::bar))
    cursor_.fail(
        diagnose("E0208", after(cursor_.previous().span), "the cases end without `otherwise`")
            .with_label("expected `| otherwise -> ...`")
            .with_secondary(first, "the cases begin here")
            .with_help("the last case says what holds everywhere else"));
  if (result.cases.empty())
    cursor_.fail(diagnose("E0229", cursor_.peek(1).span, "`otherwise` stands alone")
                     .with_help("without a condition before it, write the value itself"));
  result.otherwise_bar = cursor_.take().span;
  result.otherwise_word = cursor_.take().span;
  result.otherwise_arrow = cursor_.expect(TokenKind::arrow).span;
  result.otherwise = sum();
  if (cursor_.at(TokenKind::bar))
    cursor_.fail(diagnose("E0229", cursor_.peek().span, "a case behind `otherwise`")
                     .with_secondary(result.otherwise_word, "this takes everything that is left")
                     .with_help("move the `otherwise` line to the end"));
  return make(std::move(result), cursor_.span_from(first));
}

ast::Case ExpressionParser::single_case() {
  ast::Case result;
  const Span first = cursor_.take().span;
  if ((cursor_.at_word("else") || cursor_.at_word("default")) &&
      cursor_.peek(1).kind == TokenKind::arrow)
    cursor_.fail(diagnose("E0208", cursor_.peek().span,
                          "the last case begins with `otherwise`, not with `" +
                              std::string(cursor_.text(cursor_.peek())) + "`")
                     .with_label("write `otherwise`"));
  result.condition = condition();
  if (cursor_.at(TokenKind::equal) || cursor_.at(TokenKind::colon)) {
    const bool thick = cursor_.at(TokenKind::equal) && cursor_.peek(1).kind == TokenKind::greater;
    cursor_.fail(
        diagnose("E0209",
                 thick ? join(cursor_.peek().span, cursor_.peek(1).span) : cursor_.peek().span,
                 "a condition and its value are joined by `->`")
            .with_label("write `->`"));
  }
  if (cursor_.at(TokenKind::bar)) check_colon_as_arrow(result.condition);
  result.arrow = cursor_.expect(TokenKind::arrow).span;
  result.value = sum();
  result.span = cursor_.span_from(first);
  return result;
}

// `| x < 0 : 1 |` reads as a contraction `0 : 1`, and then the arrow is missing.
void ExpressionParser::check_colon_as_arrow(const ast::Condition& condition) {
  const auto* compare = std::get_if<ast::Compare>(&condition.node);
  if (compare == nullptr || compare->right.parens > 0) return;
  const auto* binary = std::get_if<ast::Binary>(&compare->right.node);
  if (binary == nullptr || binary->op != ast::BinaryOp::contract) return;
  cursor_.fail(diagnose("E0209", binary->op_span, "a condition and its value are joined by `->`")
                   .with_label("write `->`"));
}

// sum = contraction { ( "+" | "-" ) contraction } ;
ast::Expr ExpressionParser::sum() {
  ast::Expr result = contraction();
  while (cursor_.at(TokenKind::plus) || cursor_.at(TokenKind::minus)) {
    // The next term of the form: the bracket of this one was not closed.
    if (in_integral && cursor_.at_word("integral", 1) &&
        cursor_.peek(2).kind == TokenKind::open_paren)
      cursor_.fail_not_closed(cursor_.innermost(), TokenKind::close_paren);
    const Token op = cursor_.take();
    const auto kind = op.kind == TokenKind::plus ? ast::BinaryOp::add : ast::BinaryOp::subtract;
    result = binary(kind, op.span, std::move(result), contraction());
  }
  return result;
}

// contraction = product { ":" product } ;
ast::Expr ExpressionParser::contraction() {
  ast::Expr result = product();
  while (cursor_.at(TokenKind::colon)) {
    const Span op = cursor_.take().span;
    result = binary(ast::BinaryOp::contract, op, std::move(result), product());
  }
  return result;
}

// product = unary { ( "*" | "/" ) unary } ;
ast::Expr ExpressionParser::product() {
  ast::Expr result = unary();
  while (cursor_.at(TokenKind::star) || cursor_.at(TokenKind::slash)) {
    const Token op = cursor_.take();
    const auto kind = op.kind == TokenKind::star ? ast::BinaryOp::multiply : ast::BinaryOp::divide;
    result = binary(kind, op.span, std::move(result), unary());
  }
  return result;
}

// unary = [ "-" ] power ;
ast::Expr ExpressionParser::unary() {
  if (!cursor_.at(TokenKind::minus)) return power();
  const Span op = cursor_.take().span;
  ast::Expr operand = power();
  const Span span = join(op, operand.span);
  return make(ast::Negate{op, std::move(operand)}, span);
}

// power = postfix [ "^" unary ] ;
ast::Expr ExpressionParser::power() {
  ast::Expr base = postfix();
  if (!cursor_.at(TokenKind::caret)) return base;
  const Span op = cursor_.take().span;
  const Cursor::Level level(cursor_);
  return binary(ast::BinaryOp::power, op, std::move(base), unary());
}

} // namespace hvi::lang
