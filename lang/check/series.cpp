#include "lang/check/series.hpp"

#include "lang/check/allowed_path.hpp"
#include "lang/check/material_use.hpp"
#include "lang/diag/unreadable.hpp"
#include "solver/common/read_file.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/kernel/prony_fit.hpp"
#include "solver/kernel/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// A Prony series of `at`. Of the lag, it reaches the plan as such; a constant factor of it goes to
/// the quantities of place.
Field series_field(const solver::PronySeries& series, const Symbol& at) {
  const Symbol sum = solver::expression(series, at);
  Field out = scalar_field(sum);
  const auto is_lag = [](solver::Slot s) { return s == slot::lag; };
  const auto split = solver::split_separable(sum, is_lag);
  if (!(at == Symbol::variable(slot::lag)) || !split || split->size() != 1) return out;
  const auto& [factor, rest] = split->front();
  SeriesTimes written{series, rest, {factor}, {}};
  written.series.constant /= factor.value();
  for (double& weight : written.series.weights) weight /= factor.value();
  out.series = std::move(written);
  return out;
}

} // namespace

Value Series::table_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "table", {"file", "at", "interpolation"}, 1);
  if (!args) return Poison{};
  const auto* path = std::get_if<ast::String>(&(*args)[0]->node);
  if (!path) {
    mistakes_.error("E0306", (*args)[0]->span,
                    "the file of a table is a text: `table(\"load.csv\")`");
    return Poison{};
  }
  auto kind = solver::Table::Interpolation::linear;
  bool prony = false;
  if ((*args)[2]) {
    auto w = evaluator_.word(*(*args)[2], "interpolation", {"linear", "cubic", "prony"});
    if (!w) return Poison{};
    prony = *w == "prony";
    if (*w == "cubic") kind = solver::Table::Interpolation::monotone_cubic;
  }
  std::optional<Field> at;
  if ((*args)[1]) {
    at = evaluator_.scalar(*(*args)[1], scope);
  } else if (scope.lag || scope.time) {
    at = scalar_field(Symbol::variable(scope.lag ? slot::lag : slot::t));
  } else {
    mistakes_.error("E0305", e.span, "`table` needs its argument `at` here",
                    "`table(\"file.csv\", x)`");
  }
  if (!at) return Poison{};
  Field out;
  if (!operators_.nonlinear_degrees(e.span, "`table`", {&*at}, out, scope)) return Poison{};
  auto full = allowed_path(path->text, (*args)[0]->span, options_, mistakes_);
  if (!full) return Poison{};
  constexpr std::size_t most_bytes = std::size_t{256} << 20;
  const auto text = read_text(*full, most_bytes);
  if (!text) {
    mistakes_.error("E0601", (*args)[0]->span, why_unreadable(*full, path->text),
                    meant_file(options_.folder, path->text));
    return Poison{};
  }
  if (text->size() > most_bytes) {
    mistakes_.error("E0607", (*args)[0]->span,
                    fmt::format("`{}` is larger than 256 MiB", path->text));
    return Poison{};
  }
  model_.files_read.push_back(*full);
  try {
    auto table = std::make_shared<solver::Table>(solver::parse_table(path->text, *text, kind));
    table_uses_.push_back({e.span, path->text, at->scalar(), table->first(), table->last()});
    // A table of the lag is material data: what a Prony sum makes of it is said in any case.
    const auto& where = at->scalar();
    const bool relaxation = scope.lag && where.depends_on(slot::lag) && !where.depends_on(slot::t);
    Field series;
    if (prony || relaxation) series = prony_through(*table, where, e.span, prony);
    out.components = {prony ? series.scalar() : Symbol::tabulated(table, where)};
    if (prony) out.series = series.series;
  } catch (const std::invalid_argument& problem) {
    mistakes_.error("E0605", (*args)[0]->span, said_of_file(path->text, problem.what()),
                    "a table is two columns of numbers, the first increasing");
    return Poison{};
  }
  return operators_.check_finite(e.span, out) ? Value(out) : Value(Poison{});
}

/// The Prony sum through the table's points; its error becomes a note of the plan, which says
/// whether the sum is `taken` or the table itself.
Field Series::prony_through(const solver::Table& table, const Symbol& at, const Span& span,
                            bool taken) {
  const auto fit = solver::fit_prony(table);
  const bool known = std::any_of(model_.notes.begin(), model_.notes.end(),
                                 [&](const ModelNote& n) { return n.span == span; });
  if (!known)
    model_.notes.push_back(
        {fmt::format("Prony sum through `{}`", table.name()), span,
         fmt::format("{} exponentials{}, largest error {:.1e} of the largest "
                     "value, root mean square {:.1e}{}",
                     fit.series.weights.size(), fit.series.constant != 0 ? " and a constant" : "",
                     fit.largest, fit.mean,
                     taken ? ""
                           : " (the table itself is taken, without this error; "
                             "`interpolation = prony` takes the sum)"),
         taken});
  return series_field(fit.series, at);
}

Value Series::prony_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                         const Scope& scope) {
  const bool slope = name == "prony_relaxation";
  auto args = evaluator_.match(e, c, name, {"weights", "times", "at"}, 2);
  if (!args) return Poison{};
  auto weights = evaluator_.field(*(*args)[0], scope), times = evaluator_.field(*(*args)[1], scope);
  if (!weights || !times) return Poison{};
  if (weights->rank != 1 || times->rank != 1 || weights->rows != times->rows) {
    mistakes_.error("E0307", e.span, fmt::format("`{}` takes two lists of the same length", name));
    return Poison{};
  }
  std::optional<Field> at;
  if ((*args)[2])
    at = evaluator_.scalar(*(*args)[2], scope);
  else if (scope.lag)
    at = scalar_field(Symbol::variable(slot::lag));
  else
    mistakes_.error("E0305", e.span,
                    fmt::format("`{}` needs its argument `at` outside a kernel", name));
  if (!at) return Poison{};
  Symbol sum = 0.0;
  solver::PronySeries series;
  for (int i = 0; i < weights->rows; ++i) {
    const Symbol& time = times->components[i];
    if (time.is_constant() && !(time.value() > 0.0)) {
      mistakes_.error("E0407", item_span(*(*args)[1], i), "relaxation times are positive");
      return Poison{};
    }
    const Symbol weight = slope ? -weights->components[i] / time : weights->components[i];
    sum = sum + weight * exp(-at->scalar() / time);
    if (!weight.is_constant() || !time.is_constant()) continue;
    series.weights.push_back(weight.value());
    series.times.push_back(time.value());
  }
  const bool numbers = static_cast<int>(series.weights.size()) == weights->rows;
  return numbers ? series_field(series, at->scalar()) : scalar_field(sum);
}

Value Series::derivative_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "derivative", {"of"}, 1);
  if (!args) return Poison{};
  if (!scope.lag && !scope.time) {
    mistakes_.error("E0309", e.span, fmt::format("`derivative` cannot be used in {}", scope.what),
                    "it is by the lag in kernels, and by t where there is a time");
    return Poison{};
  }
  auto f = evaluator_.field(*(*args)[0], scope);
  if (!f) return Poison{};
  if (f->test != Degree::none || f->trial != Degree::none || !f->laws.empty()) {
    mistakes_.error("E0308", (*args)[0]->span,
                    fmt::format("`derivative` takes a function of {} and of place",
                                scope.lag ? "the lag" : "t"),
                    "the rate of an unknown is written with a prime: `u'`");
    return Poison{};
  }
  const solver::Slot by = scope.lag ? slot::lag : slot::t;
  for (Symbol& component : f->components) component = solver::derivative(component, by);
  for (Symbol& component : f->across) component = solver::derivative(component, by);
  f->materials = derivatives(std::move(f->materials), by, model_.tensors);
  if (f->series) {
    auto& series = f->series->series;
    series.constant = 0.0;
    for (std::size_t i = 0; i < series.weights.size(); ++i) series.weights[i] /= -series.times[i];
    f->series->sum = solver::derivative(f->series->sum, by);
  }
  return operators_.check_finite(e.span, *f) ? Value(*f) : Value(Poison{});
}

void Series::check_tables() {
  for (const TableUse& use : table_uses_) {
    const auto slots = solver::slots_of(use.at);
    if (slots.size() > 1 || (slots.size() == 1 && *slots.begin() != slot::t)) continue;
    std::vector<double> times = model_.time.grid;
    if (slots.empty()) times = {0.0};
    for (double t : times) {
      const double a = solver::evaluate(use.at, [&](solver::Slot) { return t; });
      const double slack = 1e-12 * (use.last - use.first);
      if (a >= use.first - slack && a <= use.last + slack) continue;
      mistakes_.error(
          "E0423", use.span,
          fmt::format("`{}` is asked for its value at {:.6g}{}: it is given on [{:.6g}, {:.6g}]",
                      use.file, a, slots.empty() ? "" : fmt::format(" (t = {:.6g})", t), use.first,
                      use.last),
          "a table is not extrapolated: extend it");
      break;
    }
  }
}

} // namespace hvi::lang
