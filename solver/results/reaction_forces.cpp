// See reaction_forces.hpp. Used by the probes of a report.
#include "solver/results/reaction_forces.hpp"

#include "solver/discrete/body_states.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/operators.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

bool is_reaction(const Probe& probe) { return probe.kind == Probe::Kind::reaction; }

const Region& part_of(const Discretisation& d, const Probe& probe) {
  return d.parts[static_cast<std::size_t>(probe.part)];
}

/// Of the space.
int component_of(const Space& space, const Probe& probe) {
  return space.blocks[static_cast<std::size_t>(probe.unknown)].first + probe.component;
}

bool holds(const DirichletSpec& condition, const Probe& probe) {
  return condition.unknown == probe.unknown &&
         (condition.component < 0 || condition.component == probe.component);
}

enum class Share { none, some, all };

/// How much of a law's part, or of the second side of its pair, lies on a part: of facets on a part
/// of cells, those of its cells.
Share share_on(const Mesh& mesh, Group::Kind kind, std::vector<std::int32_t> entities,
               const Region& part) {
  std::vector<std::int32_t> room;
  const std::vector<std::int32_t>* inside = &part.entities;
  if (kind == Group::Kind::points && part.kind != Group::Kind::points) {
    room = nodes_of(mesh, part);
    inside = &room;
  } else if (kind == Group::Kind::facets && part.kind == Group::Kind::cells) {
    for (auto& e : entities) e = mesh.facets[static_cast<std::size_t>(e)].cell;
  } else if (kind != part.kind) {
    return Share::none;
  }
  const auto n = std::ranges::count_if(
      entities, [&](std::int32_t e) { return std::ranges::binary_search(*inside, e); });
  if (n == 0) return Share::none;
  return n == std::ssize(entities) ? Share::all : Share::some;
}

/// Does what this condition holds count for the part? A node where two parts meet counts for the
/// one whose condition it has its value from; a part without a condition of its own has what is
/// held on entities that it shares, or at its points.
bool counts(const Problem& problem, const Discretisation& d, const DirichletSpec& condition,
            const Probe& probe) {
  if (condition.part == probe.part) return true;
  const bool has_its_own =
      std::ranges::any_of(problem.space.dirichlet, [&](const DirichletSpec& other) {
        return other.part == probe.part && holds(other, probe);
      });
  if (has_its_own) return false;
  const Region& part = part_of(d, probe);
  const Region& on = d.parts[static_cast<std::size_t>(condition.part)];
  return part.kind == Group::Kind::points ||
         share_on(d.mesh, on.kind, on.entities, part) != Share::none;
}

/// The dofs of the component that conditions hold on the part.
std::vector<int> held_dofs(const Problem& problem, const Discretisation& d, const Probe& probe) {
  const auto& conditions = problem.space.dirichlet;
  std::vector<char> counted;
  for (const DirichletSpec& condition : conditions)
    counted.push_back(counts(problem, d, condition, probe) ? 1 : 0);
  const auto nodes = nodes_on(d.space, part_of(d, probe));
  const int component = component_of(d.space, probe);
  std::vector<int> out;
  for (const Eliminated& e : d.dofs.eliminated)
    if (e.dirichlet >= 0 && e.dof % d.space.components == component &&
        counted[static_cast<std::size_t>(e.dirichlet)] != 0 &&
        std::ranges::binary_search(nodes, e.node))
      out.push_back(e.dof);
  return out;
}

/// +1: the law acts on the part; -1: the part is the second side of its pair; 0: neither or both.
/// What acts on means acts by half on either side. Throws Failure(bad_value) where the law acts on
/// a piece of the part only.
double side_of(const Problem& problem, const Discretisation& d, const LawTerm& term,
               const Probe& probe) {
  const Region& on = d.parts[static_cast<std::size_t>(term.part)];
  const Share first = share_on(d.mesh, on.kind, on.entities, part_of(d, probe));
  const Share second =
      on.is_pair() ? share_on(d.mesh, on.kind, on.second, part_of(d, probe)) : Share::none;
  if (first == Share::some || second == Share::some)
    throw Failure(FailureKind::bad_value, probe.origin,
                  fmt::format("only a piece of `{}`, where the law `{}` acts, lies on `{}`",
                              problem.parts[static_cast<std::size_t>(term.part)].name, term.name,
                              problem.parts[static_cast<std::size_t>(probe.part)].name),
                  "ask for the reaction of a part that has all of it, or nothing");
  const double of_first = first == Share::all ? 1.0 : 0.0;
  const double of_second = second == Share::all ? 1.0 : 0.0;
  return term.mean ? 0.5 * (of_first + of_second) : of_first - of_second;
}

/// By row of a term's points: what a unit multiplier does to the component of all nodes of the
/// first side (of the only one) together, without the weights.
std::vector<double> unit_forces(const LawTerm& term, const LawPoints& points, int component) {
  std::vector<Expr> rows;
  for (const auto& row : term.rows) rows.push_back(row.u[static_cast<std::size_t>(component)]);
  const std::size_t n = points.x.size(), n_rows = rows.size();
  std::vector<double> values(n * n_rows);
  Pointwise(rows).evaluate(as_block(points), 0.0, term.origin, values);
  if (points.frames.empty()) return values; // one row
  std::vector<double> out;
  for (std::size_t p = 0; p < n; ++p)
    for (int r = 0; r < points.rows; ++r) {
      double sum = 0.0;
      for (std::size_t k = 0; k < n_rows; ++k)
        sum += points.frames[p](static_cast<Eigen::Index>(k), r) * values[k * n + p];
      out.push_back(sum);
    }
  return out;
}

SparseMatrix matrix_of(const Problem& problem, const Discretisation& d, int field) {
  return field == field_of_u(2) ? inertia_matrix(problem, d) : matrix_of_field(problem, d, field);
}

/// With u, u' and u'' counting by themselves and memories as u does (time_scheme.hpp).
int order_of_field(int field) { return is_memory(field) ? 0 : field; }

} // namespace

double ReactionForces::Row::operator()(const Vector& v) const {
  double out = 0.0;
  for (std::size_t k = 0; k < at.size(); ++k) out += weight[k] * v[at[k]];
  return out;
}

ReactionForces::ReactionForces(const Problem& problem, const Discretisation& discretisation,
                               const RunState& run, std::span<const Probe> probes)
    : problem_(problem), d_(discretisation), contact_(run.contact()),
      scheme_(run.evolution.scheme()), changes_(run.formulation->changes_forms()),
      index_(probes.size(), -1) {
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (!is_reaction(probes[i])) continue;
    Reaction out;
    out.unknown = probes[i].unknown;
    out.held = held_dofs(problem_, d_, probes[i]);
    std::vector<double> of_rows(static_cast<std::size_t>(contact_.n_rows()), 0.0);
    add_supports(out, of_rows);
    add_laws(probes[i], of_rows);
    for (std::size_t row = 0; row < of_rows.size(); ++row)
      if (of_rows[row] != 0.0) out.multipliers.add(static_cast<int>(row), of_rows[row]);
    index_[i] = static_cast<int>(reactions_.size());
    reactions_.push_back(std::move(out));
  }
  if (reactions_.empty()) return;
  loads_.emplace(d_.space, d_.parts, problem_.loads);
  state_loads_ = StateLoads(problem_, d_, contact_, nullptr);
  load_transfer_ = load_transfer(problem_, d_);
  rows_ = rows_with(run.states());
}

void ReactionForces::take_loads() {
  if (!loads_) return;
  loads_.emplace(d_.space, d_.parts, problem_.loads);
  load_step_ = -1;
}

/// What laws do to the dofs that the part holds is carried by the support.
void ReactionForces::add_supports(const Reaction& of, std::vector<double>& of_rows) const {
  const std::set<int> held(of.held.begin(), of.held.end());
  for (const auto& term : contact_.terms)
    for (int row = 0; row < term.n_rows(); ++row)
      for (SparseMatrix::InnerIterator it(term.points.g, row); it; ++it)
        if (held.contains(static_cast<int>(it.col())))
          of_rows[static_cast<std::size_t>(term.first_row + row)] +=
              it.value() * term.points.weight[static_cast<std::size_t>(row / term.points.rows)];
}

void ReactionForces::add_laws(const Probe& probe, std::vector<double>& of_rows) const {
  for (const auto& term : contact_.terms) {
    const LawTerm& spec = problem_.law_terms[static_cast<std::size_t>(term.points.law_term)];
    if (spec.unknown != probe.unknown) continue;
    const double side = side_of(problem_, d_, spec, probe);
    if (side == 0.0) continue;
    const auto forces = unit_forces(spec, term.points, probe.component);
    for (int row = 0; row < term.n_rows(); ++row)
      of_rows[static_cast<std::size_t>(term.first_row + row)] -=
          side * forces[static_cast<std::size_t>(row)] *
          term.points.weight[static_cast<std::size_t>(row / term.points.rows)];
  }
}

SparseMatrix ReactionForces::matrix_at(int field, const Vector& states) const {
  return changes_ && field != field_of_u(2) ? matrix_of_field(problem_, d_, field, contact_, states)
                                            : matrix_of(problem_, d_, field);
}

/// The rows of the forms' matrices that belong to held dofs, added up.
ReactionForces::FormRows ReactionForces::rows_with(const Vector& states) const {
  const int n_fields = count_fields(problem_);
  FormRows out{states, {}};
  out.of.assign(reactions_.size(), std::vector<Row>(static_cast<std::size_t>(n_fields)));
  for (int field = 0; field < n_fields; ++field) {
    const bool any = std::ranges::any_of(problem_.forms,
                                         [&](const FormTerm& form) { return form.field == field; });
    if (!any) continue;
    const SparseMatrix k = matrix_at(field, states);
    for (std::size_t i = 0; i < reactions_.size(); ++i) {
      Vector sum = Vector::Zero(d_.space.n_dofs());
      std::set<int> touched;
      for (const int dof : reactions_[i].held)
        for (SparseMatrix::InnerIterator it(k, dof); it; ++it) {
          sum[it.col()] += it.value();
          touched.insert(static_cast<int>(it.col()));
        }
      // Entries of other unknowns are zero where nothing couples them, and may be of what is no
      // number (their derivatives at the initial time).
      for (const int dof : touched)
        if (sum[dof] != 0.0) out.of[i][static_cast<std::size_t>(field)].add(dof, sum[dof]);
    }
  }
  return out;
}

/// What of the step before acts in this one has the forms of the states that it ended with.
void ReactionForces::take_states(const Snapshot& now, const Snapshot& before) {
  if (!changes_) return;
  if (look_back() && (past_rows_.of.empty() || before.states() != past_rows_.states))
    past_rows_ = before.states() == rows_.states ? rows_ : rows_with(before.states());
  if (now.states() != rows_.states) rows_ = rows_with(now.states());
}

std::vector<bool> ReactionForces::fields() const {
  std::vector<bool> out(static_cast<std::size_t>(count_fields(problem_)), false);
  // A form that changes may be zero now and not later.
  if (changes_ && !reactions_.empty())
    for (const FormTerm& form : problem_.forms) out[static_cast<std::size_t>(form.field)] = true;
  for (const auto& of_reaction : rows_.of)
    for (std::size_t field = 0; field < out.size(); ++field)
      if (!of_reaction[field].at.empty()) out[field] = true;
  return out;
}

/// All but the load: what acts now, or what of the step before acts in this one.
double ReactionForces::forces(std::size_t reaction, const Snapshot& at, bool past) const {
  const auto& rows = (past && changes_ ? past_rows_ : rows_).of[reaction];
  double out = 0.0;
  for (int field = 0; field < std::ssize(rows); ++field) {
    const Row& row = rows[static_cast<std::size_t>(field)];
    const int order = order_of_field(field);
    const double share = past ? scheme_.past(order) : scheme_.present(order);
    if (!row.at.empty() && share != 0.0) out += share * row(at.field(field));
  }
  return out + (past ? scheme_.past_of_laws() : 1.0) * reactions_[reaction].multipliers(at.xi());
}

/// The load in the equation of a step.
const Vector& ReactionForces::load(const Snapshot& now, const Snapshot& before) {
  const int step = now.step();
  if (load_step_ == step && state_loads_.none()) return load_;
  load_ = Vector::Zero(d_.space.n_dofs());
  add_step_load(*loads_, problem_.time, scheme_, step, load_);
  if (load_transfer_.nonZeros() > 0) load_ = load_transfer_ * load_;
  state_loads_.add(scheme_.grid().t(step), now.states(), scheme_.present(0), load_);
  if (look_back() && !state_loads_.none())
    state_loads_.add(scheme_.grid().t(step - 1), before.states(), scheme_.past(0), load_);
  load_step_ = step;
  return load_;
}

double ReactionForces::value(int i, const Snapshot& now, const Snapshot& before) {
  take_states(now, before);
  const auto reaction = static_cast<std::size_t>(index_[static_cast<std::size_t>(i)]);
  double out = forces(reaction, now, false);
  if (look_back()) out += forces(reaction, before, true);
  const Vector& f = load(now, before);
  for (const int dof : reactions_[reaction].held) out -= f[dof];
  return out / (scheme_.present(0) + scheme_.past(0));
}

/// Adds the forces of the fields that reactions read and the forces of laws, by dof.
void ReactionForces::add_nodal(const Snapshot& at, bool past, Vector& of_fields,
                               Vector& of_laws) const {
  const auto read = fields();
  for (int field = 0; field < std::ssize(read); ++field) {
    const int order = order_of_field(field);
    const double share = past ? scheme_.past(order) : scheme_.present(order);
    if (read[static_cast<std::size_t>(field)] && share != 0.0)
      of_fields += share * (matrix_at(field, at.states()) * at.field(field));
  }
  const double share = past ? scheme_.past_of_laws() : 1.0;
  for (const auto& term : contact_.terms)
    for (int row = 0; row < term.n_rows(); ++row) {
      const double by = share * at.xi()[term.first_row + row] *
                        term.points.weight[static_cast<std::size_t>(row / term.points.rows)];
      for (SparseMatrix::InnerIterator it(term.points.g, row); it; ++it)
        of_laws[it.col()] += by * it.value();
    }
}

double ReactionForces::scale(int unknown, const Snapshot& now, const Snapshot& before) {
  Vector of_fields = Vector::Zero(d_.space.n_dofs()), of_laws = of_fields;
  add_nodal(now, false, of_fields, of_laws);
  if (look_back()) add_nodal(before, true, of_fields, of_laws);
  const Vector& f = load(now, before);
  std::set<int> held;
  for (const auto& reaction : reactions_)
    if (reaction.unknown == unknown) held.insert(reaction.held.begin(), reaction.held.end());
  double out = 0.0;
  for (const int dof : held) out += std::abs(of_fields[dof] + of_laws[dof] - f[dof]);
  const SpaceBlock& block = d_.space.blocks[static_cast<std::size_t>(unknown)];
  for (int node = 0; node < std::ssize(d_.space.nodes); ++node)
    for (int c = 0; c < block.components; ++c) {
      const int dof = d_.space.dof(node, block.first + c);
      out += std::abs(of_laws[dof]) + std::abs(f[dof]);
    }
  return out / (scheme_.present(0) + scheme_.past(0));
}

namespace {

/// Of a part that no node counts for: with a condition of its own these count for others.
Failure without_reaction(const Problem& problem, const Probe& probe) {
  const std::string& part = problem.parts[static_cast<std::size_t>(probe.part)].name;
  const bool has_its_own =
      std::ranges::any_of(problem.space.dirichlet, [&](const DirichletSpec& condition) {
        return condition.part == probe.part && condition.unknown == probe.unknown;
      });
  if (has_its_own)
    return {FailureKind::bad_value, probe.origin,
            fmt::format("all nodes of `{}` have their values from conditions on other parts, and "
                        "their reactions count there",
                        part),
            "let the condition on it stand before those, or ask for the reaction of those parts"};
  return {FailureKind::bad_value, probe.origin,
          fmt::format("nothing holds `{}`, and no law acts on it: no support or law could have a "
                      "reaction there",
                      part),
          "ask for a part where the space is zero, a value is imposed, or a law acts"};
}

} // namespace

std::vector<Failure> reactions_of_nothing(const Plan& plan, const Discretisation& d) {
  std::vector<Failure> out;
  std::set<std::pair<int, int>> seen; // the components of one reaction are probes with one origin
  for (const Probe& probe : plan.report.probes) {
    if (!is_reaction(probe) || !seen.emplace(probe.origin.id, probe.part).second) continue;
    const auto& block = d.space.blocks[static_cast<std::size_t>(probe.unknown)];
    bool held = probe.may_be_free;
    for (Probe of = probe; of.component < block.components; ++of.component)
      held = held || !held_dofs(plan.problem, d, of).empty();
    try {
      for (const LawTerm& term : plan.problem.law_terms)
        if (term.unknown == probe.unknown && side_of(plan.problem, d, term, probe) != 0)
          held = true;
      if (!held) throw without_reaction(plan.problem, probe);
    } catch (const Failure& failure) {
      out.push_back(failure);
    }
  }
  return out;
}

} // namespace hvi::solver
