// Walks a statement or an expression and tells of each name that stands for something declared.
#pragma once

#include "lang/syntax/ast.hpp"

#include <functional>
#include <string>

namespace hvi::lang {

/// What a walk meets. Spans of references may include parentheses around them.
struct NameVisitor {
  std::function<void(const std::string& name, const Span& span)> use;
  /// A column of a table, which is another thing than what is declared under its name.
  std::function<void(const std::string& name, const Span& span)> column;
  /// `name =` in a call of `callee`.
  std::function<void(const std::string& callee, const ast::Name& argument)> argument;
};

void visit_names(const ast::Statement& statement, const NameVisitor& visitor);
/// What `visitor` has for columns and arguments may be left out.
void visit_names(const ast::Expr& expression, const NameVisitor& visitor);

} // namespace hvi::lang
