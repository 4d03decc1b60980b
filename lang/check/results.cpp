#include "lang/check/results.hpp"

#include "solver/plan/result_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace hvi::lang {

bool may_have_column(const Model& model, const std::string& name) {
  return model.lacks_columns || std::ranges::any_of(model.lost_columns, [&](const auto& lost) {
           return name == lost || name.starts_with(lost + "_");
         });
}

Scope report_scope() {
  Scope scope;
  scope.what = "a report";
  scope.position = scope.time = scope.unknown = scope.report = scope.states = true;
  return scope;
}

std::optional<double> Results::report_time(const ast::Expr& e) {
  auto t = evaluator_.constant(e, "a time");
  if (!t) return std::nullopt;
  if (!model_.has_time) {
    mistakes_.error("E0412", e.span, "a static problem has no times");
    return std::nullopt;
  }
  const auto& grid = model_.time.grid;
  if (grid.empty()) return std::nullopt;
  if (*t < grid.front() || *t > grid.back()) {
    mistakes_.error("E0422", e.span,
                    fmt::format("t = {} is outside [{}, {}]", *t, grid.front(), grid.back()));
    return std::nullopt;
  }
  return t;
}

std::optional<std::string> Results::output_name(const std::optional<ast::Text>& to) {
  if (!to) return std::string();
  const std::filesystem::path path(to->text);
  const bool plain = !to->text.empty() && path == path.filename() && to->text[0] != '.';
  if (plain) {
    names_given_.push_back(to->span);
    return to->text;
  }
  mistakes_.error("E0604", to->span, fmt::format("`{}` is not a plain file name", to->text),
                  "results go into " + options_.words.output_folder);
  return std::nullopt;
}

/// The name that a result is given; the result itself where it has a name of its own.
Span Results::name_within(const Span& item) const {
  const auto given = std::ranges::find_if(names_given_, [&](const Span& name) {
    return item.begin <= name.begin && name.end <= item.end;
  });
  return given == names_given_.end() ? item : *given;
}

void Results::check_files() {
  auto results = solver::result_files(model_.report, options_.title);
  const auto place = [&](const solver::ResultFiles& result) {
    return model_.origins[static_cast<std::size_t>(result.origin.id)];
  };
  // What is asked for beside the script stands nowhere in it.
  std::erase_if(results, [&](const auto& result) { return !place(result).valid(); });
  std::ranges::sort(results, {}, [&](const auto& result) { return place(result).begin; });
  for (std::size_t i = 0; i < results.size(); ++i)
    for (std::size_t before = 0; before < i; ++before) {
      const std::string file = solver::shared_file(results[before], results[i]);
      if (file.empty()) continue;
      mistakes_.add(diagnose("E0302", name_within(place(results[i])),
                             fmt::format("two results go to `{}`", file))
                        .with_secondary(name_within(place(results[before])), "the first one")
                        .with_help("give each a name of its own: `to \"NAME\"`"));
      break;
    }
}

std::optional<std::string> Results::name_ending(const std::optional<ast::Text>& to,
                                                std::initializer_list<std::string_view> endings,
                                                const char* what, const char* help) {
  auto out = output_name(to);
  if (!out) return out;
  const std::string ending = std::filesystem::path(*out).extension().string();
  if (ending.empty() || std::ranges::find(endings, ending) != endings.end()) return out;
  mistakes_.error("E0604", to->span, fmt::format("{} written as `{}`", what, ending), help);
  return std::nullopt;
}

std::optional<std::string> Results::picture_name(const std::optional<ast::Text>& to,
                                                 const char* ending) {
  auto out = name_ending(to, {".png", ".svg", ".apng"}, "no picture is",
                         "pictures are `.png`, `.svg` or, where they move, `.apng`");
  if (out && !out->empty() && !std::filesystem::path(*out).has_extension()) *out += ending;
  return out;
}

std::optional<std::string> Results::columns_name(const std::optional<ast::Text>& to) {
  return name_ending(to, {".csv"}, "columns are not",
                     "tables and lines are `.csv`; `picture` and `plot` draw");
}

std::optional<std::string> Results::fields_name(const std::optional<ast::Text>& to) {
  return name_ending(to, {".vtu", ".pvd"}, "fields are not",
                     "fields are `.vtu`, with a `.pvd` of all times; `picture` draws");
}

bool Results::from_start(const Span& words) {
  if (!words.valid()) return false;
  if (!model_.has_time)
    mistakes_.error("E0412", words, "a static problem does not start",
                    "add `for t in [0, T] by N steps from u = 0` to the find statement");
  return model_.has_time;
}

bool Results::place(const ast::Expr& e, solver::Point& out) {
  const auto at = evaluator_.constant_list(e, "a point");
  if (!at) return false;
  if (static_cast<int>(at->size()) != model_.dim) {
    mistakes_.error("E0307", e.span,
                    fmt::format("a point in {0}D has {0} coordinates", model_.dim));
    return false;
  }
  std::ranges::copy(*at, out.begin());
  return true;
}

} // namespace hvi::lang
