// Parts of a mesh.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"
#include "lang/syntax/expression_parser.hpp"
#include "lang/syntax/name_parser.hpp"

namespace hvi::lang {

class RegionParser {
public:
  RegionParser(Cursor& cursor, NameParser& names, ExpressionParser& expressions)
      : cursor_(cursor), names_(names), expressions_(expressions) {}

  ast::Part part();

private:
  ast::Region region();
  ast::RegionTerm region_term();
  ast::Expr region_path();

  Cursor& cursor_;
  NameParser& names_;
  ExpressionParser& expressions_;
};

} // namespace hvi::lang
