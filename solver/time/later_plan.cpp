// See later_plan.hpp.
#include "solver/time/later_plan.hpp"

#include "solver/discrete/domains.hpp"
#include "solver/discrete/law_readings.hpp"
#include "solver/plan/validate.hpp"
#include "solver/time/checkpoint.hpp"

#include <algorithm>
#include <tuple>

namespace hvi::solver {
namespace {

/// A plan of nothing else than what an aspect is about.
using Aspect = Plan (*)(const Plan&);

Plan mesh_of(const Plan& plan) {
  Plan out;
  out.problem.mesh = plan.problem.mesh, out.problem.parts = plan.problem.parts;
  return out;
}

/// Which values are imposed, not what they are.
Plan space_of(const Plan& plan) {
  Plan out;
  out.problem.parts = plan.problem.parts, out.problem.space = plan.problem.space;
  for (DirichletSpec& imposed : out.problem.space.dirichlet)
    for (Expr& value : imposed.value) value = 1.0;
  return out;
}

Plan beginning_of(const Plan& plan) {
  Plan out;
  out.problem.time = plan.problem.time;
  out.problem.states = plan.problem.states;
  for (StateTerm& state : out.problem.states) state.rate = 0.0, state.low = state.high = 0.0;
  return out;
}

Plan memories_of(const Plan& plan) {
  Plan out;
  out.problem.histories = plan.problem.histories;
  for (HistoryTerm& history : out.problem.histories) history.route.reset();
  return out;
}

/// What the laws see, not what they answer.
Plan arguments_of(const Plan& plan) {
  Plan out;
  out.problem.parts = plan.problem.parts, out.problem.law_terms = plan.problem.law_terms;
  out.problem.laws = plan.problem.laws;
  for (LawTerm& term : out.problem.law_terms) {
    term.factor = 1.0;
    for (LawTerm::Row& row : term.rows) row.offset = 0.0;
  }
  for (LawSpec& law : out.problem.laws) {
    law.expression = 0.0;
    for (Expr& reading : law.readings) reading = 0.0;
  }
  return out;
}

Plan tables_of(const Plan& plan) {
  Plan out;
  out.report = plan.report;
  const auto forget = [](Expr& entry) { entry = 0.0; };
  for (Probe& probe : out.report.probes) forget(probe.expression);
  for (PictureSpec& picture : out.report.pictures) for_each_entry(picture.field, forget);
  for (LineSpec& line : out.report.lines)
    for (FieldSpec& field : line.fields) for_each_entry(field, forget);
  out.report.graphs.clear();
  return out;
}

bool same(Aspect aspect, const Plan& a, const Plan& b) {
  const Mesh none;
  return fingerprint(aspect(a), none) == fingerprint(aspect(b), none);
}

bool same_kind(const LawTerm& a, const LawTerm& b) {
  const auto key = [](const LawTerm& t) {
    return std::tie(t.law, t.part, t.field, t.unknown, t.mean, t.seen, t.rule, t.rule_of);
  };
  return key(a) == key(b);
}

bool same_fields(const LawSpec& a, const LawSpec& b) {
  return a.radial == b.radial && a.coupled == b.coupled && a.states == b.states &&
         std::ranges::equal(fields_read(a), fields_read(b));
}

bool same_laws(const Problem& a, const Problem& b) {
  return std::ranges::equal(a.law_terms, b.law_terms, same_kind) &&
         std::ranges::equal(a.laws, b.laws, same_fields);
}

[[noreturn]] void refuse(const std::string& why, const std::string& help, Origin origin = {}) {
  throw Failure(FailureKind::bad_value, origin, why, help);
}

} // namespace

void take_loads_of(const Plan& next, Problem& problem) {
  problem.loads = next.problem.loads;
  problem.space.dirichlet = next.problem.space.dirichlet;
  problem.effects = next.problem.effects; // a load that is zero is off
}

bool only_loads_differ(const Plan& now, const Plan& next) {
  Plan with_loads = now;
  take_loads_of(next, with_loads.problem);
  const Mesh none;
  return fingerprint(with_loads, none) == fingerprint(next, none);
}

void require_same_evolution(const Plan& now, const Plan& next,
                            const Discretisation& discretisation) {
  const std::string anew = "begin another run with these values";
  const Problem &a = now.problem, &b = next.problem;
  if (!same(mesh_of, now, next))
    refuse("the values change the mesh or its parts, on which the run's state lives", anew,
           b.mesh.origin);
  if (!same(space_of, now, next))
    refuse("the values change which degrees of freedom are imposed", anew, b.space.origin);
  if (a.time.grid != b.time.grid)
    refuse("the values change the times of the steps", anew, b.time.origin);
  if (!same(memories_of, now, next))
    refuse("the values change a kernel, with which the past has been summed up",
           "put what changes into the coefficient in front of the memory, or " + anew,
           b.histories.empty() ? b.time.origin : b.histories.front().origin);
  if (!same(beginning_of, now, next) || in_motion(a) != in_motion(b))
    refuse("the values change what the run has begun with", anew, b.time.origin);
  if (!same_laws(a, b) || !same(arguments_of, now, next))
    refuse("the values change what laws act on: a law with the factor 0 is left out", anew,
           b.law_terms.empty() ? b.space.origin : b.law_terms.front().origin);
  if (!same(tables_of, now, next)) refuse("the values change places or times of the report", anew);
  for (const Failure& failure : validate(next, discretisation.mesh.dim)) throw Failure(failure);
  for (const Failure& failure : outside_domains(next, discretisation)) throw Failure(failure);
}

} // namespace hvi::solver
