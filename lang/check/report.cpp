#include "lang/check/report.hpp"

namespace hvi::lang {

void Report::read(const ast::Program& script) {
  const auto each = [&](const auto& read) {
    for (const ast::Statement& statement : script.statements)
      if (const auto* report = std::get_if<ast::Report>(&statement))
        for (const ast::ReportItem& item : report->items) read(item);
  };
  each([&](const ast::ReportItem& item) { read_item(item); });
  // After all tables: plots show their columns.
  each([&](const ast::ReportItem& item) {
    if (const auto* plot = std::get_if<ast::PlotItem>(&item)) curves_.plot(*plot);
  });
  results_.check_files();
}

void Report::read_item(const ast::ReportItem& item) {
  if (const auto* table = std::get_if<ast::TableItem>(&item)) tables_.read(*table);
  if (const auto* fields = std::get_if<ast::FieldsItem>(&item)) fields_.read(*fields);
  if (const auto* picture = std::get_if<ast::PictureItem>(&item)) pictures_.read(*picture);
  if (const auto* line = std::get_if<ast::LineItem>(&item)) curves_.line(*line);
}

} // namespace hvi::lang
