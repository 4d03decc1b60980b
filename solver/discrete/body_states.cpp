// See body_states.hpp. Called where a run's equations are made, and by its steps.
#include "solver/discrete/body_states.hpp"

#include "solver/discrete/dealt_matrices.hpp"
#include "solver/fem/highest_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace hvi::solver {
namespace {

using slot::is_value;

bool reads_values(const FormTerm& form) {
  return std::ranges::any_of(form.entries, [](const FormTerm::Entry& entry) {
    return is_value(entry.test) || is_value(entry.trial);
  });
}

bool reads_values(const LoadTerm& load) {
  return std::ranges::any_of(load.entries,
                             [](const LoadTerm::Entry& entry) { return is_value(entry.test); });
}

const Expr& placing_rate(const StateTerm& state) {
  return state.placed_by ? *state.placed_by : state.rate;
}

bool reads_values(const StateTerm& state) {
  const auto slots = placing_rate(state).slots();
  return std::ranges::any_of(
      slots, [](Slot s) { return slot::is_field(s) && !slot::is_field_gradient(s); });
}

/// Of points in a body, when no unknown has a higher order than this.
Rule rule_of(const Problem& problem, int order, int part) {
  if (order > 1) return Rule::gauss;
  const bool values =
      std::ranges::any_of(problem.forms,
                          [&](const FormTerm& form) {
                            return form.part == part && reads_states(form) && reads_values(form);
                          }) ||
      std::ranges::any_of(
          problem.state_loads,
          [&](const LoadTerm& load) { return load.part == part && reads_values(load); }) ||
      std::ranges::any_of(problem.states, [&](const StateTerm& state) {
        return state.part == part && reads_values(state);
      });
  return values ? Rule::gauss : Rule::midpoint;
}

bool reads_uniform_states_only(const Problem& problem, const FormTerm& form) {
  return std::ranges::all_of(form.entries, [&](const FormTerm::Entry& entry) {
    return std::ranges::all_of(entry.coefficient.slots(), [&](Slot s) {
      if (!slot::is_state(s)) return true;
      const auto& state = problem.states[static_cast<std::size_t>(s - slot::first_state)];
      return is_uniform(state) && placing_rate(state).is_constant();
    });
  });
}

/// Is it the time itself?
bool is_time(const Problem& problem, const StateTerm& state) {
  return is_uniform(state) && state.rate.is(1.0) && !problem.time.is_static &&
         state.initial.is(problem.time.grid.front()) && std::isinf(state.low) &&
         std::isinf(state.high);
}

std::size_t index_of(Slot s) { return static_cast<std::size_t>(s - slot::first_state); }

/// Of the states that a form reads, in `states`.
std::vector<const double*> values_read(const StateReading& reading, const Contact& contact,
                                       const Vector& states) {
  std::vector<const double*> out;
  for (const Slot s : reading.states)
    out.push_back(states.data() + contact.first_state[index_of(s)]);
  return out;
}

/// Where the states live that a form reads; null: everywhere.
const LawPoints* points_of_states(const Problem& problem, const Contact& contact,
                                  const FormTerm& form, const StateReading& reading) {
  if (reading.uniform) return nullptr;
  return &body_group(problem, contact, form.part, form.origin, "a form").body->points;
}

/// The points inside the cells of a part.
LawTerm term_in_body(const Discretisation& d, int part, Rule rule) {
  LawTerm out;
  out.part = part;
  out.rule = rule;
  out.rule_of = unknown_of_highest_order(d.space);
  out.rows.resize(1);
  out.rows.front().u[0] = 1.0;
  return out;
}

LawPoints points_in_body(const Discretisation& d, const LawTerm& term) {
  LawPoints out =
      assemble_law(d.space, d.parts[static_cast<std::size_t>(term.part)], term, -1, false);
  out.g.resize(0, 0);
  return out;
}

} // namespace

const StateGroup& body_group(const Problem& problem, const Contact& contact, int part,
                             Origin origin, std::string_view what) {
  const auto group = std::ranges::find_if(
      contact.state_groups, [&](const StateGroup& one) { return one.part == part && one.body; });
  if (group == contact.state_groups.end()) throw_not_in_body(problem, part, origin, what);
  return *group;
}

void throw_not_in_body(const Problem& problem, int part, Origin origin, std::string_view what) {
  throw Failure(FailureKind::bad_value, origin,
                fmt::format("{} on `{}` reads a state that lives at the points of a law", what,
                            problem.parts[static_cast<std::size_t>(part)].name),
                "give the law a part of its own, or what reads the state a state of its own");
}

bool is_uniform(const StateTerm& state) {
  return !state.algebraic && state.rate.is_constant() && state.initial.is_constant();
}

bool reads_states(const FormTerm& form) {
  return std::ranges::any_of(form.entries, [](const FormTerm::Entry& entry) {
    return entry.coefficient.depends_on_any(slot::first_state, slot::first_probe);
  });
}

FormTerm at_initial_states(const Problem& problem, const FormTerm& form) {
  std::vector<std::pair<Slot, Expr>> initial;
  for (std::size_t i = 0; i < problem.states.size(); ++i)
    initial.emplace_back(slot::state(static_cast<int>(i)), problem.states[i].initial);
  FormTerm out = form;
  out.tensor.reset(); // whose constants may read states, too
  for (auto& entry : out.entries) entry.coefficient = substitute(entry.coefficient, initial);
  return out;
}

std::shared_ptr<const BodyPoints> make_body_points(const Problem& problem, const Discretisation& d,
                                                   const StateTerm& state) {
  auto out = std::make_shared<BodyPoints>();
  out->term = term_in_body(d, state.part, rule_of(problem, d.space.order, state.part));
  out->term.origin = state.origin;
  out->term.name = state.name;
  out->points = points_in_body(d, out->term);
  return out;
}

void add_body_trace(const Discretisation& d, const StateLayout& layout, const StateGroup& group,
                    std::vector<Eigen::Triplet<double>>& entries) {
  const PointBlock points = as_block(group.body->points);
  for (std::size_t f = 0; f < group.fields.size(); ++f) {
    const int index = slot::derivative_of(group.fields[f]);
    const SparseMatrix rows =
        restrict_columns(derivative_rows(d.space, points, index, group.body->term.origin), layout);
    const int first = group.first_input + static_cast<int>(f) * group.n_points;
    for (int p = 0; p < group.n_points; ++p)
      for (SparseMatrix::InnerIterator it(rows, p); it; ++it)
        entries.emplace_back(first + p, static_cast<int>(it.col()), it.value());
  }
}

StateReading reading_of(const Problem& problem, const Discretisation& d, const FormTerm& form) {
  StateReading out;
  out.uniform = reads_uniform_states_only(problem, form);
  out.rule = rule_of(problem, d.space.order, form.part);
  for (const auto& entry : form.entries)
    for (const Slot s : entry.coefficient.slots())
      if (slot::is_state(s)) out.states.push_back(s);
  std::ranges::sort(out.states);
  out.states.erase(std::unique(out.states.begin(), out.states.end()), out.states.end());
  for (std::size_t k = 0; k < out.states.size(); ++k)
    if (is_time(problem, problem.states[index_of(out.states[k])])) out.time = static_cast<int>(k);
  return out;
}

PointForm point_form(const Discretisation& d, const FormTerm& form, const StateReading& reading,
                     const LawPoints* known) {
  if (!reading.uniform) {
    PointBlock points = as_block(
        known != nullptr ? *known : points_in_body(d, term_in_body(d, form.part, reading.rule)));
    return {d.space, std::move(points), form};
  }
  const RegionPoints points(d.space, d.parts[static_cast<std::size_t>(form.part)], form.rule,
                            degree_of(d.space, form));
  PointBlock all;
  points.fill(0, points.entities(), all);
  return {d.space, std::move(all), form};
}

StateColumns::StateColumns(const StateReading& reading, std::vector<const double*> values,
                           std::size_t points)
    : reading_(reading), values_(std::move(values)), points_(points) {}

Pointwise::Columns StateColumns::columns() {
  return [this](Slot s) -> const double* {
    const auto at = std::ranges::lower_bound(reading_.states, s);
    if (at == reading_.states.end() || *at != s) return nullptr;
    const auto k = static_cast<std::size_t>(at - reading_.states.begin());
    return reading_.uniform ? everywhere_.try_emplace(k, points_, *values_[k]).first->second.data()
                            : values_[k];
  };
}

ChangingForms::ChangingForms(const Problem& problem, const Discretisation& d,
                             const Contact& contact, const Operators& operators) {
  for (const auto& [base, form] : operators.changing) {
    Changing& of = forms_.emplace_back(Changing{base, reading_of(problem, d, *form), {}});
    const LawPoints* const points = points_of_states(problem, contact, *form, of.reading);
    if (!operators.dealt)
      of.form.emplace(point_form(d, *form, of.reading, points));
    else if (points != nullptr)
      of.points_of = operators.dealt->points_of_each(points->cell);
  }
}

/// By form and state the values at the process's points, or the one of all points.
std::vector<double> ChangingForms::states_of(int process, const Contact& contact) const {
  std::vector<double> out;
  for (const Changing& of : forms_)
    for (const double* const value : values_read(of.reading, contact, contact.state_values)) {
      if (of.reading.uniform) out.push_back(*value);
      if (!of.reading.uniform)
        for (const int point : of.points_of[static_cast<std::size_t>(process)])
          out.push_back(value[point]);
    }
  return out;
}

void ChangingForms::take(const Contact& contact, const StateLayout& layout, Operators& operators) {
  if (operators.dealt && !none()) {
    operators.dealt->take_states([&](int process) { return states_of(process, contact); });
    return;
  }
  const DofSelection dofs{layout.entry_of, layout.n_unknowns, layout.n_state};
  for (auto& [base, reading, form, points_of] : forms_) {
    StateColumns read(reading, values_read(reading, contact, contact.state_values), form->points());
    form->assemble(dofs, read.columns(), operators.bases[static_cast<std::size_t>(base)],
                   read.time());
  }
}

TimedForms::TimedForms(const Problem& problem, const Discretisation& d, const Contact& contact)
    : problem_(problem), contact_(contact) {
  for (const FormTerm& form : problem.forms) {
    if (!reads_states(form)) continue;
    StateReading reading = reading_of(problem, d, form);
    if (!reading.uniform) continue;
    PointForm at_points = point_form(d, form, reading);
    forms_.push_back({std::move(reading), std::move(at_points)});
  }
}

void TimedForms::check(double t) {
  Vector states = contact_.state_values;
  const double passed = t - problem_.time.grid.front();
  for (const StateGroup& group : contact_.state_groups)
    for (const int i : group.states) {
      const StateTerm& state = problem_.states[static_cast<std::size_t>(i)];
      if (!is_uniform(state)) continue;
      states.segment(contact_.first_state[static_cast<std::size_t>(i)], group.n_points)
          .setConstant(std::clamp(state.initial.value() + state.rate.value() * passed, state.low,
                                  state.high));
    }
  for (auto& [reading, form] : forms_) {
    StateColumns read(reading, values_read(reading, contact_, states), form.points());
    form.evaluate(read.columns(), read.time());
  }
}

SparseMatrix matrix_of_field(const Problem& problem, const Discretisation& d, int field,
                             const Contact& contact, const Vector& states) {
  SparseMatrix out(d.space.n_dofs(), d.space.n_dofs());
  for (const auto& form : problem.forms) {
    if (form.field != field) continue;
    SparseMatrix of_form =
        assemble_form(d.space, d.parts[static_cast<std::size_t>(form.part)],
                      reads_states(form) ? at_initial_states(problem, form) : form);
    if (reads_states(form)) {
      const StateReading reading = reading_of(problem, d, form);
      PointForm at_points =
          point_form(d, form, reading, points_of_states(problem, contact, form, reading));
      StateColumns read(reading, values_read(reading, contact, states), at_points.points());
      at_points.assemble({}, read.columns(), of_form, read.time());
    }
    out = SparseMatrix(out + of_form);
  }
  return out;
}

} // namespace hvi::solver
