#include "lang/syntax/print_expression.hpp"

#include <fmt/format.h>

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<std::string_view, 6> operators{"+", "-", "*", "/", ":", "^"};
constexpr std::array<std::string_view, 6> comparisons{"<", "<=", ">", ">=", "==", "!="};

} // namespace

void TreeLines::line(std::string_view text, const Span& span) {
  out_.append(2 * depth_, ' ').append(text);
  if (source_ != nullptr) {
    const Position begin = source_->position(span.begin);
    const Position end = source_->position(span.end);
    out_ += fmt::format("  @{}:{}-{}:{}", begin.line, begin.column, end.line, end.column);
  }
  out_ += '\n';
}

void ExpressionPrinter::print(std::string_view role, const ast::Expr& expr) {
  role_ = role;
  span_ = expr.span;
  std::visit([this](const auto& node) { (*this)(node); }, expr.node);
}

void ExpressionPrinter::print(std::string_view role, const ast::Condition& condition) {
  role_ = role;
  span_ = condition.span;
  std::visit([this](const auto& node) { (*this)(node); }, condition.node);
}

// --- expressions and conditions ----------------------------------------------------------------

void ExpressionPrinter::operator()(const ast::List& node) {
  head("list");
  const TreeLines::Indent indent(lines_);
  for (const ast::Expr& item : node.items) print("", item);
}

void ExpressionPrinter::operator()(const ast::Negate& node) {
  head("negate");
  const TreeLines::Indent indent(lines_);
  print("", *node.operand);
}

void ExpressionPrinter::operator()(const ast::Binary& node) {
  head("binary " + std::string(operators[static_cast<std::size_t>(node.op)]));
  const TreeLines::Indent indent(lines_);
  print("", *node.left);
  print("", *node.right);
}

void ExpressionPrinter::operator()(const ast::Cases& node) {
  head("cases");
  const TreeLines::Indent indent(lines_);
  for (const ast::Case& item : node.cases) {
    lines_.line("case", item.span);
    const TreeLines::Indent deeper(lines_);
    print("if: ", item.condition);
    print("value: ", item.value);
  }
  print("otherwise: ", *node.otherwise);
}

void ExpressionPrinter::operator()(const ast::Member& node) {
  head("member ." + node.member.text);
  const TreeLines::Indent indent(lines_);
  print("", *node.object);
}

void ExpressionPrinter::operator()(const ast::Quantity& node) {
  head("unit " + node.unit.text);
  const TreeLines::Indent indent(lines_);
  print("", *node.value);
}

void ExpressionPrinter::operator()(const ast::Prime& node) {
  head("prime");
  const TreeLines::Indent indent(lines_);
  print("", *node.operand);
}

void ExpressionPrinter::operator()(const ast::Call& node) {
  head("call");
  const TreeLines::Indent indent(lines_);
  print("callee: ", *node.callee);
  for (const ast::Argument& argument : node.arguments)
    print(argument.name ? argument.name->text + " = " : "", argument.value);
}

void ExpressionPrinter::operator()(const ast::Clarke& node) {
  head("clarke");
  const TreeLines::Indent indent(lines_);
  print("law: ", *node.law);
  print("at: ", *node.at);
  print("direction: ", *node.direction);
}

void ExpressionPrinter::operator()(const ast::Compare& node) {
  head("compare " + std::string(comparisons[static_cast<std::size_t>(node.op)]));
  const TreeLines::Indent indent(lines_);
  print("", node.left);
  print("", node.right);
}

void ExpressionPrinter::operator()(const ast::Not& node) {
  head("not");
  const TreeLines::Indent indent(lines_);
  print("", *node.operand);
}

void ExpressionPrinter::operands(std::string_view word,
                                 const std::vector<ast::Condition>& operands) {
  head(word);
  const TreeLines::Indent indent(lines_);
  for (const ast::Condition& operand : operands) print("", operand);
}

void ExpressionPrinter::operator()(const ast::Number& node) {
  head(fmt::format("number {}", node.value));
}

void ExpressionPrinter::operator()(const ast::String& node) {
  head("string \"" + node.text + "\"");
}

void ExpressionPrinter::operator()(const ast::Reference& node) { head("name " + node.name); }

void ExpressionPrinter::operator()(const ast::Inside& node) { head("inside " + node.part.text); }

void ExpressionPrinter::operator()(const ast::And& node) { operands("and", node.operands); }

void ExpressionPrinter::operator()(const ast::Or& node) { operands("or", node.operands); }

void ExpressionPrinter::print(std::string_view role, const ast::Region& region) {
  lines_.line(std::string(role) + "region", region.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::RegionTerm& term : region.terms) {
    const std::string sign = term.minus ? "- " : "+ ";
    if (const auto* path = std::get_if<ast::Expr>(&term.term))
      print(sign, *path);
    else
      print(sign, *std::get<Box<ast::Region>>(term.term));
  }
  if (region.where) print("where: ", *region.where);
}

} // namespace hvi::lang
