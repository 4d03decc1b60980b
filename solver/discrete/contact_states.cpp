// States at the points of laws; see contact_states.hpp. Called by make_contact.
#include "solver/discrete/contact_states.hpp"

#include "solver/discrete/body_states.hpp"
#include "solver/fem/pointwise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hvi::solver {
namespace {

std::vector<double> initial_values(const Problem& problem, const StateTerm& state,
                                   const LawPoints& points) {
  std::vector<double> out(points.x.size());
  if (out.empty()) return out;
  const double t = problem.time.is_static ? 0.0 : problem.time.grid.front();
  Pointwise({&state.initial, 1}).evaluate(as_block(points), t, state.origin, out);
  for (std::size_t p = 0; p < out.size(); ++p) {
    if (!std::isfinite(out[p]))
      throw_not_finite(state.origin, fmt::format("the initial value of `{}`", state.name), out[p],
                       points.x[p], points.dim);
    if (out[p] < state.low || out[p] > state.high)
      throw Failure(FailureKind::bad_value, state.origin,
                    fmt::format("`{}` begins with {:.6g} at {}, outside [{:.6g}, {:.6g}]",
                                state.name, out[p], describe_point(points.x[p], points.dim),
                                state.low, state.high),
                    "let it begin inside the interval that it is kept in");
  }
  return out;
}

/// The states that a law term reads, in its law or in the offset of its argument.
std::vector<int> states_read(const Problem& problem, const LawTerm& term) {
  std::vector<int> out = problem.laws[term.law].states;
  for (const auto& row : term.rows)
    for (const Slot s : row.offset.slots())
      if (slot::is_state(s)) out.push_back(s - slot::first_state);
  return out;
}

/// Does the term read states, or a rate of a state of its part its multiplier?
bool is_of_states(const Problem& problem, int l) {
  const LawTerm& term = problem.law_terms[static_cast<std::size_t>(l)];
  const Slot first = slot::multiplier(l, 0);
  return !states_read(problem, term).empty() ||
         std::ranges::any_of(problem.states, [&](const StateTerm& state) {
           return state.part == term.part &&
                  state.rate.depends_on_any(first, first + slot::most_arguments);
         });
}

/// The first law term on the part that has to do with a state there, else the first one there; -1:
/// none.
int host_of(const Problem& problem, int part) {
  int out = -1;
  for (int l = 0; l < std::ssize(problem.law_terms); ++l) {
    if (problem.law_terms[static_cast<std::size_t>(l)].part != part) continue;
    if (is_of_states(problem, l)) return l;
    if (out < 0) out = l;
  }
  return out;
}

bool same_points(const LawPoints& a, const LawPoints& b) {
  return a.x == b.x && a.normal == b.normal;
}

/// Algebraic states stand with those inside a body, never at the points of a law.
StateGroup& group_of(const Problem& problem, const Discretisation& d, const StateTerm& state,
                     Contact& contact) {
  const auto known = std::ranges::find_if(contact.state_groups, [&](const StateGroup& group) {
    return group.part == state.part && (group.body || !state.algebraic);
  });
  if (known != contact.state_groups.end()) return *known;
  StateGroup group;
  group.part = state.part;
  group.host = state.algebraic ? -1 : host_of(problem, state.part);
  if (state.algebraic) {
    group.body = make_body_points(problem, d, state);
  } else if (group.host < 0) {
    if (d.parts[static_cast<std::size_t>(state.part)].kind != Group::Kind::cells)
      throw Failure(FailureKind::bad_value, state.origin,
                    fmt::format("no law acts on `{}`, where the state `{}` is to live",
                                problem.parts[state.part].name, state.name),
                    "a state lives inside a body or at the points of a law: put one on its part");
    group.body = make_body_points(problem, d, state);
  }
  group.n_points = static_cast<int>(points_of(contact, group).x.size());
  contact.state_groups.push_back(std::move(group));
  return contact.state_groups.back();
}

/// What the rates of a group read besides place, time and each other.
void find_inputs(const Problem& problem, const Contact& contact, StateGroup& group) {
  for (const int i : group.states) {
    const StateTerm& state = problem.states[static_cast<std::size_t>(i)];
    for (const Slot s : state.rate.slots()) {
      if (slot::is_state(s)) {
        const StateTerm& other = problem.states[static_cast<std::size_t>(s - slot::first_state)];
        if (other.part != state.part)
          throw Failure(FailureKind::bad_value, state.origin,
                        fmt::format("the rate of `{}` reads `{}`, which lives on `{}`", state.name,
                                    other.name, problem.parts[other.part].name),
                        "states that read each other live on one part");
        if (std::ranges::find(group.states, s - slot::first_state) == group.states.end())
          throw_not_in_body(problem, state.part, state.origin, "a load");
      } else if (slot::is_multiplier(s)) {
        const int term = slot::term_of(s);
        if (!same_points(contact.terms[term].points, points_of(contact, group)))
          throw Failure(FailureKind::bad_value, state.origin,
                        fmt::format("the rate of `{}` reads the multiplier of `{}`, which does not "
                                    "act at its points",
                                    state.name, problem.law_terms[term].name),
                        "put both on the same part, the laws with the same rule");
        group.multipliers.push_back(s);
      } else if (slot::is_field(s)) {
        group.fields.push_back(s);
      }
    }
  }
  for (auto* slots : {&group.fields, &group.multipliers}) {
    std::ranges::sort(*slots);
    slots->erase(std::unique(slots->begin(), slots->end()), slots->end());
  }
}

using slot::field_of;

/// Which fields the rates of a group read at points with this normal: u.nu on a flat side reads one
/// component.
std::vector<char> fields_read_at(const Problem& problem, const StateGroup& group,
                                 const Point& normal) {
  std::vector<std::pair<Slot, Expr>> values;
  for (int j = 0; j < 3; ++j) values.emplace_back(slot::normal(j), Expr(normal[j]));
  std::vector<char> out(group.fields.size(), 0);
  for (const int i : group.states) {
    const Expr rate = substitute(problem.states[static_cast<std::size_t>(i)].rate, values);
    for (std::size_t f = 0; f < out.size(); ++f)
      if (rate.depends_on(group.fields[f])) out[f] = 1;
  }
  return out;
}

/// Rows of a value at the points of a group.
SparseMatrix values_at(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                       const StateGroup& group, int derivative) {
  LawTerm term;
  term.origin = problem.states[static_cast<std::size_t>(group.states.front())].origin;
  term.part = group.part;
  const LawTerm& host = problem.law_terms[group.host];
  term.rule = host.rule;
  term.rule_of = host.rule_of.value_or(host.unknown);
  term.rows.resize(1);
  term.unknown = slot::unknown_of(derivative);
  term.mean = !slot::is_value(derivative);
  term.rows.front().u[static_cast<std::size_t>(slot::component_of(derivative))] = 1.0;
  return restrict_columns(assemble_law(d.space, d.parts[group.part], term, -1, false).g, layout);
}

void add_trace(const Problem& problem, const Discretisation& d, const StateLayout& layout,
               const Contact& contact, const StateGroup& group,
               std::vector<Eigen::Triplet<double>>& entries) {
  const auto& normals = contact.terms[group.host].points.normal;
  std::map<Point, std::vector<char>> read;
  for (std::size_t f = 0; f < group.fields.size(); ++f) {
    const int derivative = slot::derivative_of(group.fields[f]);
    const SparseMatrix rows = values_at(problem, d, layout, group, derivative);
    for (int p = 0; p < group.n_points; ++p) {
      auto [known, fresh] = read.try_emplace(normals[p]);
      if (fresh) known->second = fields_read_at(problem, group, normals[p]);
      if (known->second[f] == 0) continue;
      const int row = group.first_input + static_cast<int>(f) * group.n_points + p;
      for (SparseMatrix::InnerIterator it(rows, p); it; ++it)
        entries.emplace_back(row, static_cast<int>(it.col()), it.value());
    }
  }
}

/// Where a term finds the states that it reads.
void place_states(const Problem& problem, Contact& contact, ContactTerm& term) {
  const auto& spec = problem.law_terms[term.points.law_term];
  for (const int i : states_read(problem, spec)) {
    const StateTerm& state = problem.states[static_cast<std::size_t>(i)];
    const auto group = std::ranges::find_if(contact.state_groups, [&](const StateGroup& one) {
      return std::ranges::find(one.states, i) != one.states.end();
    });
    const auto& host = points_of(contact, *group);
    if (state.part != spec.part || !same_points(term.points, host))
      throw Failure(
          FailureKind::bad_value, spec.origin,
          state.part != spec.part
              ? fmt::format("`{}` acts on `{}` and reads the state `{}` of `{}`", spec.name,
                            problem.parts[spec.part].name, state.name,
                            problem.parts[state.part].name)
              : fmt::format("`{}` reads the state `{}`, which lives at the points of `{}`",
                            spec.name, state.name,
                            group->body ? problem.parts[group->part].name
                                        : problem.law_terms[group->host].name),
          state.part != spec.part ? "a state is known on its own part only"
                                  : "give the laws of one part the same rule");
  }
  for (const int i : problem.laws[spec.law].states)
    term.first_states.push_back(contact.first_state[static_cast<std::size_t>(i)]);
  term.offset_of_states = std::ranges::any_of(spec.rows, [](const LawTerm::Row& row) {
    return row.offset.depends_on_any(slot::first_state, slot::first_probe);
  });
}

} // namespace

void check_initial_states(const Problem& problem, const Discretisation& d) {
  for (const StateTerm& state : problem.states)
    if (!state.algebraic && !state.initial.is_constant() &&
        d.parts[static_cast<std::size_t>(state.part)].kind == Group::Kind::cells)
      initial_values(problem, state, make_body_points(problem, d, state)->points);
}

bool is_of_place_and_time(const StateTerm& state) {
  return std::ranges::none_of(state.rate.slots(), [](Slot s) {
    return slot::is_state(s) || slot::is_field(s) || slot::is_multiplier(s);
  });
}

void check_given_rates(const Problem& problem, const Contact& contact, double t) {
  for (const StateGroup& group : contact.state_groups)
    for (const int i : group.states) {
      const StateTerm& state = problem.states[static_cast<std::size_t>(i)];
      if (state.algebraic || state.rate.is_constant() || !is_of_place_and_time(state)) continue;
      const LawPoints& points = points_of(contact, group);
      std::vector<double> rates(points.x.size());
      Pointwise({&state.rate, 1}).evaluate(as_block(points), t, state.origin, rates);
      for (std::size_t p = 0; p < rates.size(); ++p)
        if (!std::isfinite(rates[p]))
          throw_not_finite(state.origin, fmt::format("the rate of the state `{}`", state.name),
                           rates[p], points.x[p], points.dim, &t);
    }
}

std::vector<LawTime> initial_law_times(const Problem& problem, const Law& law,
                                       const LawPoints& points, double t,
                                       std::span<const Readings> first_readings) {
  std::vector<LawTime> out(points.x.size(), LawTime(t));
  for (std::size_t p = 0; p < first_readings.size(); ++p) out[p].readings = first_readings[p];
  const auto& states = law.spec().states;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const auto values =
        initial_values(problem, problem.states[static_cast<std::size_t>(states[k])], points);
    for (std::size_t p = 0; p < out.size(); ++p) out[p].states[k] = values[p];
  }
  return out;
}

void add_states(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                Contact& contact) {
  int n_values = 0, n_inputs = 0;
  std::vector<double> values;
  for (std::size_t i = 0; i < problem.states.size(); ++i) {
    const StateTerm& state = problem.states[i];
    StateGroup& group = group_of(problem, d, state, contact);
    group.states.push_back(static_cast<int>(i));
    const auto initial = initial_values(problem, state, points_of(contact, group));
    contact.first_state.push_back(n_values);
    values.insert(values.end(), initial.begin(), initial.end());
    n_values += group.n_points;
  }
  contact.state_values =
      Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
  std::vector<Eigen::Triplet<double>> entries, in_bodies;
  for (auto& group : contact.state_groups) {
    find_inputs(problem, contact, group);
    group.first_input = n_inputs;
    n_inputs += group.n_inputs();
    group.body ? add_body_trace(d, layout, group, in_bodies)
               : add_trace(problem, d, layout, contact, group, entries);
    auto& others = contact.state_fields;
    for (const Slot s : group.fields)
      if (field_of(s) != field_of_u(0) && std::ranges::find(others, field_of(s)) == others.end())
        others.push_back(field_of(s));
  }
  contact.trace.resize(n_inputs, layout.n_state);
  contact.trace.setFromTriplets(entries.begin(), entries.end());
  contact.body_trace.resize(n_inputs, layout.n_state);
  contact.body_trace.setFromTriplets(in_bodies.begin(), in_bodies.end());
  for (auto& term : contact.terms) place_states(problem, contact, term);
}

} // namespace hvi::solver
