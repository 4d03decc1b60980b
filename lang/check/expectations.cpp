#include "lang/check/expectations.hpp"

#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace hvi::lang {

using solver::Probe;

void Expectations::require_column(const std::string& name, const Span& place) {
  std::vector<std::string> names;
  for (const Probe& p : model_.report.probes)
    if (!p.name.empty()) names.push_back(p.name);
  if (std::ranges::find(names, name) != names.end() || may_have_column(model_, name)) return;
  const bool vector = std::ranges::find(names, name + "_x") != names.end();
  mistakes_.error("E0319", place, fmt::format("no table has a column `{}`", name),
                  vector ? fmt::format("it is a vector: its first column is `{}_x`", name)
                         : did_you_mean(name, names));
}

/// As the run's tables have them: every column has a value in the rows of all of them.
bool Expectations::has_row(double t) const {
  const auto& grid = model_.time.grid;
  int every = 0;
  bool from_start = false;
  for (const solver::TableSpec& table : model_.report.tables) {
    every = std::gcd(every, std::max(table.every, 1));
    from_start = from_start || table.from_start;
  }
  for (std::size_t n = from_start ? 0 : 1; n < grid.size(); ++n) {
    const bool due = n + 1 == grid.size() || (every > 0 && n % static_cast<unsigned>(every) == 0);
    if (due && is_at(grid[n], t)) return true;
  }
  return false;
}

/// With other parameters than its own a script may have other times: `test` judges there.
void Expectations::require_row(const Expectation& e, const Span& time) {
  const bool known = !may_have_column(model_, e.probe) && !model_.time.grid.empty();
  if (!known || !options_.defines.empty() || has_row(*e.time)) return;
  mistakes_.add(
      diagnose("W0110", time, fmt::format("no table has a row at t = {}", *e.time))
          .with_help("a row is that of a step: let the grid have this time, or let a column be the "
                     "value at this time"));
}

void Expectations::read_accuracy(const ast::Find& find) {
  for (const ast::Setting& setting : find.settings)
    if (setting.name.text == "accuracy_of" && !model_.accuracy_of.empty())
      require_column(model_.accuracy_of, setting.value.span);
}

void Expectations::read(const ast::Program& script) {
  for (const ast::Statement& statement : script.statements) {
    const auto* e = std::get_if<ast::Expect>(&statement);
    if (!e) continue;
    Expectation out;
    out.span = e->span;
    out.probe = e->probe.text;
    require_column(out.probe, e->probe.span);
    if (e->time) out.time = results_.report_time(*e->time);
    auto value = evaluator_.constant(e->value, "an expected value");
    auto tolerance = evaluator_.constant(e->tolerance, "a tolerance");
    if (tolerance && *tolerance < 0.0)
      mistakes_.error("E0408", e->tolerance.span, "a tolerance is not negative");
    out.relative = e->relative;
    if (e->when) {
      Scope scope;
      scope.what = "the condition of an expectation";
      auto when = evaluator_.condition(*e->when, scope);
      out.active = when && when->value() != 0.0; // the scope has no name that varies
    }
    if (e->source) out.source = e->source->text;
    if (e->time && out.time && out.active) require_row(out, e->time->span);
    if (!value || !tolerance) continue;
    out.value = *value;
    out.tolerance = *tolerance;
    model_.expectations.push_back(std::move(out));
  }
}

} // namespace hvi::lang
