// Declarations: all statements but find, report, expect and study.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"
#include "lang/syntax/expression_parser.hpp"
#include "lang/syntax/name_parser.hpp"

#include <vector>

namespace hvi::lang {

class DeclarationParser {
public:
  DeclarationParser(Cursor& cursor, NameParser& names, ExpressionParser& expressions)
      : cursor_(cursor), names_(names), expressions_(expressions) {}

  ast::Import import_statement();
  ast::Units units();
  ast::Param param();
  ast::Mesh mesh();
  ast::Tensor tensor();
  ast::Kernel kernel();
  ast::Superpotential superpotential();
  ast::State state();
  ast::Fn fn();
  ast::Space space();
  ast::InitialValue initial_value(const Span& first);

private:
  std::vector<ast::LawParameter> law_parameters();
  ast::ZeroCondition zero_condition();
  ast::PeriodicCondition periodic_condition();

  Cursor& cursor_;
  NameParser& names_;
  ExpressionParser& expressions_;
};

} // namespace hvi::lang
