// The fields of everything that a plan is made of, for those who have to see all of them. A field
// that is added and not named here does not compile: a structured binding names every one.
#pragma once

#include "solver/plan/plan.hpp"

#include <tuple>

namespace hvi::solver {

// Left out: origins, which are places in a script, and notes for readers (Problem::effects).

inline auto fields_of(const PronySeries& of) {
  const auto& [constant, weights, times] = of;
  return std::tie(constant, weights, times);
}
inline auto fields_of(const KernelSpec& of) {
  const auto& [name, origin, expression, series] = of;
  return std::tie(name, expression, series);
}
inline auto fields_of(const LawSpec& of) {
  const auto& [name, origin, radial, by_slope, expression, coupled, readings, states] = of;
  return std::tie(name, radial, by_slope, expression, coupled, readings, states);
}
inline auto fields_of(const TensorSpec& of) {
  const auto& [name, origin, kind, constants, axes] = of;
  return std::tie(name, kind, constants, axes);
}
inline auto fields_of(const MeshSpec& of) {
  const auto& [name, origin, kind, low, high, cells, grading, crossed, path, allow_geo, geometry,
               numbers, constants, refinements, axisymmetric, adapted, at, split, pieces] = of;
  return std::tie(name, kind, low, high, cells, grading, crossed, path, allow_geo, geometry,
                  numbers, constants, refinements, axisymmetric, adapted, at, split, pieces);
}
inline auto fields_of(const RegionSpec& of) {
  const auto& [kind, origin, name, point, children, predicate, reach] = of;
  return std::tie(kind, name, point, children, predicate, reach);
}
inline auto fields_of(const PartSpec& of) {
  const auto& [name, origin, region] = of;
  return std::tie(name, region);
}
inline auto fields_of(const DirichletSpec& of) {
  const auto& [origin, part, component, value, unknown] = of;
  return std::tie(part, component, value, unknown);
}
inline auto fields_of(const PeriodicSpec& of) {
  const auto& [origin, first, second, component, unknown] = of;
  return std::tie(first, second, component, unknown);
}
inline auto fields_of(const UnknownSpec& of) {
  const auto& [name, space, origin, vector, order, domain] = of;
  return std::tie(name, space, vector, order, domain);
}
inline auto fields_of(const SpaceSpec& of) {
  const auto& [name, origin, vector, order, dirichlet, unknown, more, domain, periodic] = of;
  return std::tie(name, vector, order, dirichlet, unknown, more, domain, periodic);
}
inline auto fields_of(const FormTerm::Entry& of) {
  const auto& [test, trial, coefficient] = of;
  return std::tie(test, trial, coefficient);
}
inline auto fields_of(const FormTerm::Tensor& of) {
  const auto& [index, factor, unknown] = of;
  return std::tie(index, factor, unknown);
}
inline auto fields_of(const FormTerm& of) {
  const auto& [origin, part, field, rule, effect, entries, tensor] = of;
  return std::tie(part, field, rule, effect, entries, tensor);
}
inline auto fields_of(const LoadTerm::Entry& of) {
  const auto& [test, value] = of;
  return std::tie(test, value);
}
inline auto fields_of(const LoadTerm& of) {
  const auto& [origin, part, rule, effect, entries] = of;
  return std::tie(part, rule, effect, entries);
}
inline auto fields_of(const HistoryTerm& of) {
  const auto& [origin, kernel, route] = of;
  return std::tie(kernel, route);
}
inline auto fields_of(const SeenField& of) {
  const auto& [field, times] = of;
  return std::tie(field, times);
}
inline auto fields_of(const LawTerm::Row& of) {
  const auto& [u, offset] = of;
  return std::tie(u, offset);
}
inline auto fields_of(const LawTerm& of) {
  const auto& [origin, name, law, part, field, unknown, mean, seen, rule, rule_of, effect, factor,
               rows] = of;
  return std::tie(name, law, part, field, unknown, mean, seen, rule, rule_of, effect, factor, rows);
}
/// Without `placed_by`, which a run gives to its start.
inline auto fields_of(const StateTerm& of) {
  const auto& [origin, name, part, rate, initial, low, high, placed_by, algebraic] = of;
  return std::tie(name, part, rate, initial, low, high, algebraic);
}
/// Without `start`, which follows from Plan::start.
inline auto fields_of(const TimeSpec& of) {
  const auto& [origin, is_static, grid, scheme, sampling, interpolant, initial, start, velocity,
               velocity_origin, hht_alpha] = of;
  return std::tie(is_static, grid, scheme, sampling, interpolant, initial, velocity, hht_alpha);
}
inline auto fields_of(const Problem& of) {
  const auto& [title, mesh, parts, space, tensors, forms, histories, laws, law_terms, states, loads,
               state_loads, time, effects] = of;
  return std::tie(title, mesh, parts, space, tensors, forms, histories, laws, law_terms, states,
                  loads, state_loads, time);
}
inline auto fields_of(const SolverOptions& of) {
  const auto& [solver, factor, tolerance, memory_tolerance, route, branch, threads,
               proportional_path, rows_refused, jumps_as_unknowns, reduced_precision, audit] = of;
  return std::tie(solver, factor, tolerance, memory_tolerance, route, branch, threads,
                  proportional_path, rows_refused, jumps_as_unknowns, reduced_precision, audit);
}
inline auto fields_of(const Probe& of) {
  const auto& [name, origin, kind, expression, point, on_pair, part, rule, time, unknown, component,
               may_be_free, unit] = of;
  return std::tie(name, kind, expression, point, on_pair, part, rule, time, unknown, component,
                  may_be_free, unit);
}
inline auto fields_of(const TableSpec& of) {
  const auto& [origin, probes, every, from_start, file] = of;
  return std::tie(probes, every, from_start, file);
}
inline auto fields_of(const FieldSpec& of) {
  const auto& [name, origin, components, unit, across] = of;
  return std::tie(name, components, unit, across);
}
inline auto fields_of(const FieldsSpec& of) {
  const auto& [origin, fields, every, from_start, file] = of;
  return std::tie(fields, every, from_start, file);
}
inline auto fields_of(const PictureSpec& of) {
  const auto& [origin, field, time, file, deformed, in_row] = of;
  return std::tie(field, time, file, deformed, in_row);
}
inline auto fields_of(const LineSpec& of) {
  const auto& [origin, fields, from, to, points, time, file] = of;
  return std::tie(fields, from, to, points, time, file);
}
inline auto fields_of(const PlotSpec& of) {
  const auto& [origin, columns, against, file] = of;
  return std::tie(columns, against, file);
}
inline auto fields_of(const GraphSpec& of) {
  const auto& [name, what] = of;
  return std::tie(name, what);
}
inline auto fields_of(const GraphsSpec& of) {
  const auto& [origin, graphs, file] = of;
  return std::tie(graphs, file);
}
inline auto fields_of(const ReportSpec& of) {
  const auto& [probes, tables, fields, pictures, lines, plots, graphs, unit_of_time, unit_of_length,
               unit_of_energy] = of;
  return std::tie(probes, tables, fields, pictures, lines, plots, graphs, unit_of_time,
                  unit_of_length, unit_of_energy);
}
inline auto fields_of(const Plan& of) {
  const auto& [problem, options, report, start] = of;
  return std::tie(problem, options, report, start);
}

} // namespace hvi::solver
