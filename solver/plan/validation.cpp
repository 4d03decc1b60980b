#include "solver/plan/validation.hpp"

#include "solver/kernel/slot.hpp"

#include <fmt/format.h>

namespace hvi::solver {

Validation::Validation(const Problem& problem, int dim)
    : problem_(problem), dim_(dim), components_(components_of(problem.space, dim)),
      n_fields_(count_fields(problem)) {}

void Validation::wrong(Origin origin, const std::string& message) {
  out_.emplace_back(FailureKind::bad_value, origin, message);
}

bool Validation::index(int i, int n, Origin origin, std::string_view what, std::string_view of) {
  if (i >= 0 && i < n) return true;
  wrong(origin, fmt::format("{} names {} {}, of {}", what, of, i, n));
  return false;
}

bool Validation::part(int i, Origin origin, std::string_view what) {
  return index(i, count(problem_.parts), origin, what, "part");
}

bool Validation::derivative(int i) const {
  const auto unknowns = unknowns_of(problem_.space);
  const int b = slot::unknown_of(i);
  if (i < 0 || b >= count(unknowns)) return false;
  const int own = i % slot::own_derivatives;
  const int components = components_of(unknowns[static_cast<std::size_t>(b)], dim_);
  if (slot::is_value(own)) return own < components;
  if (own == slot::hoop && problem_.mesh.axisymmetric) return components > 1;
  return (own - 3) / 3 < components && (own - 3) % 3 < dim_;
}

void Validation::derivative(int i, Origin origin, std::string_view what) {
  if (!derivative(i))
    wrong(origin, fmt::format("{} has the derivative {} of a function with {} component{} in "
                              "{} dimension{}",
                              what, i, components_, components_ == 1 ? "" : "s", dim_,
                              dim_ == 1 ? "" : "s"));
}

bool Validation::known(Slot s, const Allowed& allowed) const {
  if (s >= slot::x(0) && s <= slot::x(2)) return allowed.place;
  if (s == slot::gap) return allowed.gap;
  if (s == slot::t) return allowed.time;
  if (s == slot::lag) return allowed.lag;
  if (s >= slot::normal(0) && s <= slot::normal(2)) return allowed.normal;
  if (s == slot::argument(0)) return allowed.argument;
  if (s == slot::coupled) return allowed.coupled;
  if (s >= slot::reading(0) && s < slot::reading(slot::most_readings))
    return s < slot::reading(allowed.readings);
  if (s >= slot::law_state(0) && s < slot::law_state(slot::most_law_states))
    return s - slot::law_state(0) < allowed.law_states;
  if (slot::is_state(s)) return allowed.states && s - slot::first_state < count(problem_.states);
  if (s < slot::first_field) return false;
  if (s < slot::first_multiplier) {
    const int field = slot::field_of(s);
    return allowed.fields && field < n_fields_ && (!is_rate(field) || !problem_.time.is_static) &&
           (field != field_of_u(2) || in_motion(problem_)) && derivative(slot::derivative_of(s));
  }
  if (s < slot::first_inside) {
    const int term = slot::term_of(s), row = slot::row_of(s);
    return allowed.multipliers && term < count(problem_.law_terms) &&
           row < count(problem_.law_terms[static_cast<std::size_t>(term)].rows);
  }
  if (s < slot::first_probe) return allowed.place && s - slot::first_inside < count(problem_.parts);
  return s - slot::first_probe < allowed.probes;
}

void Validation::variables(const Expr& e, const Allowed& allowed, Origin origin,
                           std::string_view what) {
  for (const Slot s : e.slots())
    if (!known(s, allowed))
      wrong(origin, fmt::format("{} has the variable {}, which it cannot have", what, s));
}

bool Validation::is_pair(int i) const {
  return i >= 0 && i < count(problem_.parts) &&
         problem_.parts[static_cast<std::size_t>(i)].region.kind == RegionSpec::Kind::pair;
}

void Validation::no_pair(int i, Origin origin, std::string_view what) {
  if (is_pair(i)) wrong(origin, fmt::format("{} stands on a pair, where laws act", what));
}

} // namespace hvi::solver
