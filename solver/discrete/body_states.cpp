// See body_states.hpp. Called where a run's equations are made, and by its steps.
#include "solver/discrete/body_states.hpp"

#include "solver/fem/highest_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
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

PointForm point_form(const Problem& problem, const Discretisation& d, const Contact& contact,
                     const FormTerm& form) {
  if (!reads_uniform_states_only(problem, form))
    return {d.space,
            as_block(body_group(problem, contact, form.part, form.origin, "a form").body->points),
            form};
  const RegionPoints points(d.space, d.parts[static_cast<std::size_t>(form.part)], form.rule,
                            degree_of(d.space, form));
  PointBlock all;
  points.fill(0, points.entities(), all);
  return {d.space, std::move(all), form};
}

/// Is it the time itself?
bool is_time(const Problem& problem, const StateTerm& state) {
  return is_uniform(state) && state.rate.is(1.0) && !problem.time.is_static &&
         state.initial.is(problem.time.grid.front()) && std::isinf(state.low) &&
         std::isinf(state.high);
}

/// What a form reads of states: their values at the points of their group, or anywhere.
class StateColumns {
public:
  StateColumns(const Problem& problem, const Contact& contact, const Vector& states,
               const FormTerm& term, std::size_t points)
      : contact_(contact), states_(states), points_(points),
        uniform_(reads_uniform_states_only(problem, term)) {
    for (const auto& entry : term.entries)
      for (const Slot s : entry.coefficient.slots())
        if (slot::is_state(s) && is_time(problem, problem.states[index_of(s)])) time_ = value(s);
  }

  Pointwise::Columns columns() {
    return [this](Slot s) -> const double* {
      if (!slot::is_state(s)) return nullptr;
      return uniform_ ? everywhere_.try_emplace(s, points_, *value(s)).first->second.data()
                      : value(s);
    };
  }
  const double* time() const { return time_; } ///< null: it is none of them

private:
  static std::size_t index_of(Slot s) { return static_cast<std::size_t>(s - slot::first_state); }
  const double* value(Slot s) const { return states_.data() + contact_.first_state[index_of(s)]; }

  const Contact& contact_;
  const Vector& states_;
  std::size_t points_;
  bool uniform_;
  const double* time_ = nullptr;
  std::map<Slot, std::vector<double>> everywhere_;
};

void assemble(const Problem& problem, const Contact& contact, const Vector& states,
              const FormTerm& term, const DofSelection& dofs, PointForm& form, SparseMatrix& into) {
  StateColumns read(problem, contact, states, term, form.points());
  form.assemble(dofs, read.columns(), into, read.time());
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
  LawTerm& term = out->term;
  term.origin = state.origin;
  term.name = state.name;
  term.part = state.part;
  term.rule = rule_of(problem, d.space.order, state.part);
  term.rule_of = unknown_of_highest_order(d.space);
  term.rows.resize(1);
  term.rows.front().u[0] = 1.0;
  out->points =
      assemble_law(d.space, d.parts[static_cast<std::size_t>(state.part)], term, -1, false);
  out->points.g.resize(0, 0);
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

ChangingForms::ChangingForms(const Problem& problem, const Discretisation& d,
                             const Contact& contact, const Operators& operators)
    : problem_(&problem) {
  for (const auto& [base, form] : operators.changing)
    forms_.push_back({base, form, point_form(problem, d, contact, *form)});
}

void ChangingForms::take(const Contact& contact, const StateLayout& layout, Operators& operators) {
  const DofSelection dofs{layout.entry_of, layout.n_unknowns, layout.n_state};
  for (auto& [base, term, form] : forms_)
    assemble(*problem_, contact, contact.state_values, *term, dofs, form,
             operators.bases[static_cast<std::size_t>(base)]);
}

TimedForms::TimedForms(const Problem& problem, const Discretisation& d, const Contact& contact)
    : problem_(problem), contact_(contact) {
  for (const FormTerm& form : problem.forms)
    if (reads_states(form) && reads_uniform_states_only(problem, form))
      forms_.emplace_back(&form, point_form(problem, d, contact, form));
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
  for (auto& [term, form] : forms_) {
    StateColumns read(problem_, contact_, states, *term, form.points());
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
      PointForm at_points = point_form(problem, d, contact, form);
      assemble(problem, contact, states, form, {}, at_points, of_form);
    }
    out = SparseMatrix(out + of_form);
  }
  return out;
}

} // namespace hvi::solver
