// Rates of states, compiled for points; see state_rates.hpp.
#include "solver/discrete/state_rates.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

int index_in(const std::vector<Slot>& slots, Slot s) {
  return static_cast<int>(std::ranges::find(slots, s) - slots.begin());
}

/// A derivative at a kink of the rate, as of norm at 0, may be no number: taken as 0.
void without_kinks(std::span<double> values) {
  for (double& v : values)
    if (!std::isfinite(v)) v = 0.0;
}

} // namespace

StateRates::StateRates(const Problem& problem, const StateGroup& group, const LawPoints& points)
    : n_(static_cast<int>(group.states.size())), points_(points) {
  std::vector<Expr> rates, derivatives;
  for (const int i : group.states)
    rates.push_back(problem.states[static_cast<std::size_t>(i)].rate);
  for (const Expr& rate : rates)
    for (const int j : group.states) derivatives.push_back(derivative(rate, slot::state(j)));
  for (const Expr& rate : rates)
    for (const auto* slots : {&group.fields, &group.multipliers})
      for (const Slot s : *slots) derivatives.push_back(derivative(rate, s));
  rates_ = compile(rates), derivatives_ = compile(derivatives);
  of_rates_ = sources(rates_, group);
  of_derivatives_ = sources(derivatives_, group);
}

std::vector<StateRates::Source> StateRates::sources(const Tape& tape,
                                                    const StateGroup& group) const {
  std::vector<Source> out;
  const int n_fields = static_cast<int>(group.fields.size());
  for (const Slot s : tape.inputs) {
    if (s <= slot::x(2))
      out.push_back({Source::Kind::place, s});
    else if (s == slot::t)
      out.push_back({Source::Kind::time, 0});
    else if (slot::is_field(s))
      out.push_back({Source::Kind::input, index_in(group.fields, s)});
    else if (slot::is_multiplier(s))
      out.push_back({Source::Kind::input, n_fields + index_in(group.multipliers, s)});
    else if (slot::is_state(s))
      out.push_back({Source::Kind::state, index_in(group.states, s - slot::first_state)});
    else if (s >= slot::first_inside)
      out.push_back({Source::Kind::inside, s - slot::first_inside});
    else
      out.push_back({Source::Kind::normal, s - slot::normal(0)});
  }
  return out;
}

/// What does not change from step to step.
double StateRates::of_place(const Source& source, std::size_t point) const {
  const auto i = static_cast<std::size_t>(source.index);
  if (source.kind == Source::Kind::place) return points_.x[point][i];
  if (source.kind == Source::Kind::normal) return points_.normal[point][i];
  return points_.indicators->value(source.index, points_.kind, points_.facet[point],
                                   points_.cell[point]);
}

void StateRates::run(const Tape& tape, const std::vector<Source>& sources, double t, Columns z,
                     Columns inputs, std::vector<double>& out) const {
  thread_local TapeWorkspace workspace;
  const std::size_t n = points_.x.size();
  std::vector<std::vector<double>> made; // columns that are nowhere yet
  made.reserve(sources.size());
  std::vector<const double*> columns;
  for (const Source& s : sources) {
    if (s.kind == Source::Kind::state) {
      columns.push_back(z[static_cast<std::size_t>(s.index)]);
    } else if (s.kind == Source::Kind::input) {
      columns.push_back(inputs[static_cast<std::size_t>(s.index)]);
    } else {
      auto& column = made.emplace_back(n, t);
      for (std::size_t p = 0; p < n && s.kind != Source::Kind::time; ++p)
        column[p] = of_place(s, p);
      columns.push_back(column.data());
    }
  }
  out.resize(n * tape.outputs.size());
  evaluate(tape, columns, n, out, workspace);
}

void StateRates::run(const Tape& tape, const std::vector<Source>& sources, int p, double t,
                     std::span<const double> z, std::span<const double> inputs,
                     std::span<double> out) const {
  thread_local TapeWorkspace workspace;
  thread_local std::vector<double> values;
  thread_local std::vector<const double*> pointers;
  values.resize(sources.size());
  pointers.resize(sources.size());
  const auto at = static_cast<std::size_t>(p);
  const auto value = [&](const Source& s) {
    const auto i = static_cast<std::size_t>(s.index);
    switch (s.kind) {
    case Source::Kind::time:
      return t;
    case Source::Kind::state:
      return z[i];
    case Source::Kind::input:
      return inputs[i];
    case Source::Kind::place:
    case Source::Kind::normal:
    case Source::Kind::inside:
      break;
    }
    return of_place(s, at);
  };
  for (std::size_t i = 0; i < sources.size(); ++i) {
    values[i] = value(sources[i]);
    pointers[i] = &values[i];
  }
  evaluate(tape, {pointers.data(), pointers.size()}, 1, out, workspace);
}

void StateRates::rates(int p, double t, std::span<const double> z, std::span<const double> inputs,
                       std::span<double> out) const {
  run(rates_, of_rates_, p, t, z, inputs, out);
}

void StateRates::rates(double t, Columns z, Columns inputs, std::vector<double>& out) const {
  run(rates_, of_rates_, t, z, inputs, out);
}

void StateRates::derivatives(double t, Columns z, Columns inputs, std::vector<double>& out) const {
  run(derivatives_, of_derivatives_, t, z, inputs, out);
  without_kinks(out);
}

void StateRates::derivatives(int p, double t, std::span<const double> z,
                             std::span<const double> inputs, std::span<double> by_state,
                             std::span<double> by_input) const {
  thread_local std::vector<double> both;
  both.resize(derivatives_.outputs.size());
  run(derivatives_, of_derivatives_, p, t, z, inputs, both);
  without_kinks(both);
  std::copy_n(both.begin(), by_state.size(), by_state.begin());
  std::copy(both.begin() + static_cast<std::ptrdiff_t>(by_state.size()),
            both.begin() + static_cast<std::ptrdiff_t>(by_state.size() + by_input.size()),
            by_input.begin());
}

} // namespace hvi::solver
