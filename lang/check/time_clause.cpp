#include "lang/check/time_clause.hpp"

#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace hvi::lang {

namespace {

constexpr int most_steps = 20'000'000;

} // namespace

void TimeClause::time_grid(const ast::TimeClause& clause) {
  auto range = evaluator_.constant_list(clause.range, "the time interval");
  if (!range) return;
  if (range->size() != 2 || !((*range)[0] < (*range)[1])) {
    mistakes_.error("E0426", clause.range.span, "the time interval is `[t0, T]` with t0 < T");
    return;
  }
  const double t0 = (*range)[0], t1 = (*range)[1];
  std::vector<double>& grid = model_.time.grid;
  if (clause.by_steps) {
    auto n = evaluator_.positive_integer(clause.steps, "the number of steps");
    if (!n) return;
    if (*n > most_steps) {
      mistakes_.error("E0607", clause.steps.span, fmt::format("more than {} steps", most_steps));
      return;
    }
    grid.resize(*n + 1);
    for (int i = 0; i <= *n; ++i) grid[i] = t0 + (t1 - t0) * i / *n;
    return;
  }
  // Listed times, or `graded(N, power)`: t0 + (T - t0) (i/N)^power.
  const auto* call = std::get_if<ast::Call>(&clause.steps.node);
  const auto* callee = call ? std::get_if<ast::Reference>(&call->callee->node) : nullptr;
  if (callee && callee->name == "graded") {
    auto args = evaluator_.match(clause.steps, *call, "graded", {"steps", "power"}, 2);
    if (!args) return;
    auto n = evaluator_.positive_integer(*(*args)[0], "the number of steps");
    auto power = evaluator_.constant(*(*args)[1], "the grading power");
    if (!n || !power) return;
    if (*power < 1.0 || *n > most_steps) {
      mistakes_.error("E0408", (*args)[1]->span, "the grading power is at least 1");
      return;
    }
    grid.resize(*n + 1);
    for (int i = 0; i <= *n; ++i) grid[i] = t0 + (t1 - t0) * std::pow(double(i) / *n, *power);
    grid.back() = t1;
    return;
  }
  auto times = evaluator_.constant_list(clause.steps, "the times");
  if (!times) return;
  grid = {t0};
  for (std::size_t i = 0; i < times->size(); ++i) {
    const double t = (*times)[i];
    if (i == 0 && t == t0) continue;
    if (!(grid.back() < t) || t > t1) {
      mistakes_.error("E0426", item_span(clause.steps, i),
                      fmt::format("times increase within [{}, {}]; {} does not", t0, t1, t));
      grid.clear();
      return;
    }
    grid.push_back(t);
  }
  if (grid.back() < t1) grid.push_back(t1);
}

void TimeClause::read(const ast::Find& find) {
  model_.has_time = find.time.has_value();
  model_.time.is_static = !find.time;
  if (!find.time) return;
  model_.time.origin = model_.origin(find.time->span);
  time_grid(*find.time);
  initial_state(find);
  check_static_start(find);
}

/// `u = static`, where nothing of the script has that name.
bool TimeClause::is_static_start(const ast::InitialValue& initial) const {
  const auto* name = std::get_if<ast::Reference>(&initial.value.node);
  return name && name->name == "static" && !initial.rate && names_.find("static") < 0;
}

/// `u = statik` (reported), where nothing of the script has that name.
bool TimeClause::misspells_static(const ast::InitialValue& initial) {
  const auto* name = std::get_if<ast::Reference>(&initial.value.node);
  if (!name || initial.rate || names_.find(name->name) >= 0) return false;
  const std::string near = did_you_mean(name->name, std::array<std::string_view, 1>{"static"});
  if (near.empty()) return false;
  mistakes_.error("E0301", initial.value.span, fmt::format("unknown name `{}`", name->name), near);
  return true;
}

/// All unknowns together are in equilibrium.
void TimeClause::check_static_start(const ast::Find& find) {
  if (!model_.starts_at_rest) return;
  for (const ast::Unknown& u : find.unknowns) {
    const auto given = std::ranges::find_if(find.time->initial, [&](const auto& initial) {
      return initial.unknown.text == u.unknown.text && !initial.rate;
    });
    if (given != find.time->initial.end() && is_static_start(*given)) continue;
    mistakes_.error(
        "E0449", given == find.time->initial.end() ? find.time->initial.front().span : given->span,
        fmt::format("`{}` does not start in equilibrium, and another unknown does", u.unknown.text),
        fmt::format("write `{} = static`, or give all of them values", u.unknown.text));
    return;
  }
}

/// u(t0) and u'(t0) by component of all unknowns; what is not given is 0.
void TimeClause::initial_state(const ast::Find& find) {
  if (!unknowns_.known) return;
  std::vector<Symbol> none;
  for (std::size_t b = 0; b < find.unknowns.size(); ++b)
    none.insert(none.end(), unknowns_.components_of(static_cast<int>(b)), Symbol(0.0));
  std::map<std::pair<int, bool>, const ast::InitialValue*> given;
  for (const ast::InitialValue& initial : find.time->initial) {
    const int unknown = unknowns_.named(initial.unknown.text);
    if (unknown < 0) {
      mistakes_.error("E0301", initial.unknown.span,
                      fmt::format("the initial {} is of the unknown {}, not of `{}`",
                                  initial.rate ? "velocity" : "state", unknowns_.names(),
                                  initial.unknown.text));
      continue;
    }
    if (!given.try_emplace({unknown, initial.rate}, &initial).second) {
      mistakes_.error("E0302", initial.span,
                      fmt::format("the initial {} of `{}` is given twice",
                                  initial.rate ? "velocity" : "state", initial.unknown.text));
      continue;
    }
    if (is_static_start(initial)) {
      model_.starts_at_rest = true;
      continue;
    }
    if (misspells_static(initial)) continue;
    const auto value = initial_value(initial, unknown);
    if (!value) continue;
    (initial.rate ? model_.time.velocity_origin : model_.time.origin) = model_.origin(initial.span);
    if (initial.rate && !model_.time.velocity) model_.time.velocity = none;
    if (value->empty()) continue;
    auto& all = initial.rate ? *model_.time.velocity : model_.time.initial;
    if (all.empty()) all = none;
    int first = 0;
    for (int b = 0; b < unknown; ++b) first += unknowns_.components_of(b);
    std::ranges::copy(*value, all.begin() + first);
  }
}

/// By component; empty: 0. Nothing where it is wrong (reported).
std::optional<std::vector<Symbol>> TimeClause::initial_value(const ast::InitialValue& initial,
                                                             int unknown) {
  const std::string what = initial.rate ? "initial velocity" : "initial state";
  Scope scope;
  scope.what = "an " + what;
  scope.position = true;
  auto value = evaluator_.field(initial.value, scope);
  if (!value) return std::nullopt;
  const int n = unknowns_.components_of(unknown);
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  if (value->rank == 0 && value->scalar().is(0.0)) return std::vector<Symbol>{};
  if ((value->rank == 1) != vector || static_cast<int>(value->components.size()) != n ||
      value->rank > 1) {
    mistakes_.error("E0307", initial.value.span,
                    fmt::format("the {} is {}, the unknown {}", what, describe(*value),
                                vector ? fmt::format("a vector of {}", n) : "a scalar"));
    return std::nullopt;
  }
  return value->components;
}

} // namespace hvi::lang
