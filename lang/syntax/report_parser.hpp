// What is asked of the solution: report, expect, study.
#pragma once

#include "lang/syntax/ast.hpp"
#include "lang/syntax/cursor.hpp"
#include "lang/syntax/expression_parser.hpp"
#include "lang/syntax/name_parser.hpp"

#include <array>
#include <optional>
#include <string_view>

namespace hvi::lang {

inline constexpr std::array<std::string_view, 5> report_item_words{"table", "fields", "picture",
                                                                   "line", "plot"};

class ReportParser {
public:
  ReportParser(Cursor& cursor, NameParser& names, ExpressionParser& expressions)
      : cursor_(cursor), names_(names), expressions_(expressions) {}

  ast::Report report_statement();
  ast::Expect expect_statement();
  ast::Study study();

private:
  void recover_in_report();
  ast::ReportItem report_item();
  [[nodiscard]] bool at_report_item() const;
  [[nodiscard]] bool at_misspelt_item() const;
  Span from_start();
  template <class Item>
  void rows_and_file(Item& item);
  ast::TableItem table_item();
  ast::FieldsItem fields_item();
  ast::PictureItem picture_item();
  ast::LineItem line_item();
  ast::PlotItem plot_item();
  ast::Binding binding();
  std::optional<ast::Expr> every_steps();
  std::optional<ast::Text> to_file();
  ast::Expr time_value();
  [[nodiscard]] bool at_time() const;
  std::optional<ast::Expr> optional_time();
  ast::Ladder ladder();

  Cursor& cursor_;
  NameParser& names_;
  ExpressionParser& expressions_;
};

} // namespace hvi::lang
