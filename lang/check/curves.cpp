#include "lang/check/curves.hpp"

#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

void Curves::line(const ast::LineItem& item) {
  solver::LineSpec spec;
  spec.origin = model_.origin(item.span);
  auto file = results_.columns_name(item.to);
  bool good = results_.place(item.from, spec.from);
  good = results_.place(item.end, spec.to) && good;
  if (good && spec.from == spec.to) {
    mistakes_.error("E0408", item.end.span, "a line has two ends: these are one point",
                    "a value at a point is a column of a table: `a = u.y at [0, 0]`");
    good = false;
  }
  const auto points = evaluator_.positive_integer(item.points, "the number of points");
  constexpr int most_points = 1000000;
  if (points && (*points < 2 || *points > most_points)) {
    mistakes_.error("E0408", item.points.span,
                    fmt::format("a line has 2 to {} points, not {}", most_points, *points));
    good = false;
  }
  if (item.time) {
    spec.time = results_.report_time(*item.time);
    good = spec.time.has_value() && good;
  }
  for (const ast::Expr& e : item.fields) {
    auto f = fields_.drawn_field(e, "a line");
    if (f && f->name == "distance") {
      mistakes_.error("E0302", e.span, "the first column of a line is the distance along it",
                      "give this field another name");
      f.reset();
    }
    good = good && f && fields_.is_new(*f, spec.fields);
    if (f) spec.fields.push_back(std::move(*f));
  }
  if (!file || !points || !good) return;
  spec.points = *points;
  spec.file = *file;
  model_.report.lines.push_back(std::move(spec));
}

void Curves::plot(const ast::PlotItem& item) {
  solver::PlotSpec spec;
  spec.origin = model_.origin(item.span);
  auto file = results_.picture_name(item.to, ".svg");
  if (item.to && item.to->text.ends_with(".apng")) {
    mistakes_.error("E0412", item.to->span, "a plot does not move",
                    "a picture that stands still is a `.png` or an `.svg`");
    return;
  }
  if (!model_.has_time) {
    mistakes_.error("E0412", item.span, "a static problem has one row: there is no curve to plot");
    return;
  }
  std::vector<std::string> known{"t"};
  for (const solver::TableSpec& table : model_.report.tables)
    for (const int p : table.probes)
      known.push_back(model_.report.probes[static_cast<std::size_t>(p)].name);
  const auto column = [&](const ast::Name& name) {
    if (std::ranges::find(known, name.text) != known.end()) return true;
    if (may_have_column(model_, name.text)) return false;
    const std::string part = name.text + "_x";
    const bool vector = std::ranges::find(known, part) != known.end();
    mistakes_.error("E0319", name.span, fmt::format("no table has a column `{}`", name.text),
                    vector ? fmt::format("it is a vector: plot `{}`", part)
                           : did_you_mean(name.text, known));
    return false;
  };
  bool good = column(item.against);
  for (const ast::Name& name : item.columns) {
    good = column(name) && good;
    if (std::ranges::find(spec.columns, name.text) != spec.columns.end()) {
      mistakes_.error("E0302", name.span, fmt::format("`{}` is drawn twice", name.text));
      good = false;
    }
    spec.columns.push_back(name.text);
  }
  if (!file || !good) return;
  spec.against = item.against.text;
  spec.file = *file;
  model_.report.plots.push_back(std::move(spec));
}

} // namespace hvi::lang
