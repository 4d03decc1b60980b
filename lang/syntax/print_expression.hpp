// Lines of the dump of a syntax tree, and the expressions, conditions and regions in it. See
// print.hpp.
#pragma once

#include "lang/diag/source.hpp"
#include "lang/syntax/ast.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::lang {

class TreeLines {
public:
  explicit TreeLines(const SourceFile* source) : source_(source) {}
  void line(std::string_view text, const Span& span);
  std::string take() { return std::move(out_); }

  /// While it lives, lines stand one level deeper.
  class Indent {
  public:
    explicit Indent(TreeLines& lines) : lines_(lines) { ++lines_.depth_; }
    ~Indent() { --lines_.depth_; }
    Indent(const Indent&) = delete;
    Indent& operator=(const Indent&) = delete;

  private:
    TreeLines& lines_;
  };

private:
  const SourceFile* source_;
  std::string out_;
  std::size_t depth_ = 0;
};

/// Every function takes the role of the node in its parent ("value: "). The line of the node itself
/// is `head`, its children are one level deeper.
class ExpressionPrinter {
public:
  explicit ExpressionPrinter(TreeLines& lines) : lines_(lines) {}
  void print(std::string_view role, const ast::Expr& expr);
  void print(std::string_view role, const ast::Condition& condition);
  void print(std::string_view role, const ast::Region& region);

private:
  void operator()(const ast::Number& node);
  void operator()(const ast::Quantity& node);
  void operator()(const ast::String& node);
  void operator()(const ast::Reference& node);
  void operator()(const ast::List& node);
  void operator()(const ast::Negate& node);
  void operator()(const ast::Binary& node);
  void operator()(const ast::Cases& node);
  void operator()(const ast::Member& node);
  void operator()(const ast::Prime& node);
  void operator()(const ast::Call& node);
  void operator()(const ast::Clarke& node);
  void operator()(const ast::Compare& node);
  void operator()(const ast::Inside& node);
  void operator()(const ast::Not& node);
  void operator()(const ast::And& node);
  void operator()(const ast::Or& node);

  void head(std::string_view text) { lines_.line(role_ + std::string(text), span_); }
  void operands(std::string_view word, const std::vector<ast::Condition>& operands);

  TreeLines& lines_;
  std::string role_; ///< of the node being visited
  Span span_;        ///< of the node being visited
};

} // namespace hvi::lang
