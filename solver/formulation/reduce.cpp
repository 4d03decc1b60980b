// From all unknowns to the contact unknowns; see reduce.hpp. Called where a run's equations are
// made.
#include "solver/formulation/reduce.hpp"

#include "solver/discrete/fields_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace hvi::solver {
namespace {

constexpr int worth_recovering = 8; ///< steps per recovery of the interior

const char* name_of(Effect effect) {
  switch (effect) {
  case Effect::inertia:
    return "inertia";
  case Effect::viscosity:
    return "viscosity";
  case Effect::elasticity:
    return "elasticity";
  case Effect::memory:
    return "memory";
  default:
    return "a form";
  }
}

/// The first two forms that act differently on the base matrices.
std::string different_tensors(const Problem& problem, const Operators& operators) {
  for (const auto& a : problem.forms)
    for (const auto& b : problem.forms) {
      const Vector x = operators.weights.row(a.field), y = operators.weights.row(b.field);
      if (std::abs(x.dot(y)) < (1 - 1e-12) * x.norm() * y.norm())
        return fmt::format("the tensors of {} and {} are not multiples of one tensor",
                           name_of(a.effect), name_of(b.effect));
    }
  return "the forms need more than one matrix";
}

/// The name of a probe; a part of a column has none, and stands before the column.
std::string column_of(const ReportSpec& report, std::size_t probe) {
  while (probe + 1 < report.probes.size() && report.probes[probe].name.empty()) ++probe;
  return report.probes[probe].name;
}

/// How often whole fields are read: every so many steps; 0: at the end only.
int interior_every(const Plan& plan, std::string* who) {
  const int n_fields = count_fields(plan.problem);
  int every = 0, base = 0;
  for (const auto& table : plan.report.tables) base = std::gcd(base, std::max(table.every, 1));
  for (std::size_t i = 0; i < plan.report.probes.size(); ++i)
    if (base > 0 && reads_interior(plan.report.probes[i], n_fields)) {
      every = base;
      if (who != nullptr)
        *who = fmt::format("the table reads `{}` in the interior", column_of(plan.report, i));
    }
  for (const auto& fields : plan.report.fields) {
    const int own = std::max(fields.every, 1);
    if (every != 0 && own >= every) continue;
    every = own;
    if (who != nullptr) *who = "fields are written";
  }
  return every;
}

} // namespace

bool reads_interior(const Probe& probe, int n_fields) {
  using Kind = Probe::Kind;
  if (probe.kind == Kind::norm_v || probe.kind == Kind::reaction) return true;
  const bool on_region =
      probe.kind == Kind::integral || probe.kind == Kind::largest || probe.kind == Kind::smallest;
  if (!on_region && !probe.on_pair) return false;
  const auto read = fields_read({&probe.expression, 1}, n_fields);
  return std::find(read.begin(), read.end(), true) != read.end();
}

std::string proportional_obstacle(const Plan& plan, const Operators& operators,
                                  const Contact& contact, const LoadAssembler& loads,
                                  const StateLayout& layout) {
  if (!plan.options.proportional_path) return "it was asked for";
  if (plan.options.rows_refused)
    return "a step on the contact unknowns was not certified on all rows";
  if (operators.iterative) return "the solver is iterative";
  if (plan.options.factor == FactorEntries::singles) return "the factor is in single precision";
  if (plan.problem.time.is_static) return "a static problem has one step";
  if (contact.none()) return "there is no contact law";
  if (in_motion(plan.problem)) return "there is inertia";
  if (!operators.changing.empty())
    return "forms change from step to step"; // in time, or with states
  if (!plan.problem.state_loads.empty()) return "states change a load";
  if (operators.n_bases() != 1) return different_tensors(plan.problem, operators);
  if (operators.coupled) return "unknowns act on each other";
  if (!operators.symmetric) return "the matrix is not symmetric";
  if (contact.whole) return "the laws act on most of the unknowns";
  if (!loads.separable()) return "a load does not separate into functions of t and of x";
  if (layout.n_state != layout.n_unknowns) return "boundary values other than zero are imposed";
  const int n_fields = count_fields(plan.problem);
  for (std::size_t i = 0; i < plan.report.probes.size(); ++i)
    if (plan.report.probes[i].time && reads_interior(plan.report.probes[i], n_fields))
      return fmt::format("`{}` reads the interior between two steps", column_of(plan.report, i));
  for (const auto& picture : plan.report.pictures)
    if (picture.time)
      return fmt::format("the picture of `{}` reads the interior between two steps",
                         picture.field.name);
  for (const auto& line : plan.report.lines)
    if (line.time) return "a line reads the interior between two steps";
  std::string who;
  const int every = interior_every(plan, &who);
  if (every > 0 && every < worth_recovering)
    return fmt::format("{} {}", who,
                       every == 1 ? "at every step" : fmt::format("every {} steps", every));
  return {};
}

namespace {

/// Operators of one matrix, diag(S, 1): the first unknowns, the contact, are coupled with no other.
Operators of_interior(Operators all, const Interior& interior) {
  all.bases = {condensed_matrix(interior)};
  all.shared = nullptr; // what is left is small
  all.separate = interior.n_contact();
  all.n_unknowns = interior.size();
  return all;
}

StateLayout of_interior(const StateLayout& all, const std::vector<int>& contact, int size) {
  StateLayout out;
  out.n_unknowns = out.n_state = size;
  out.n_dofs = all.n_dofs;
  out.dof_of.assign(size, -1); // a mode has none
  out.entry_of.assign(all.n_dofs, -1);
  for (std::size_t c = 0; c < contact.size(); ++c) {
    out.dof_of[c] = all.dof_of[contact[c]];
    out.entry_of[out.dof_of[c]] = static_cast<int>(c);
  }
  for (const DofLink& link : all.links)
    if ((out.entry_of[link.dof] = out.entry_of[link.to]) >= 0) out.links.push_back(link);
  return out;
}

/// The contact unknowns come first, in their order.
Contact of_interior(Contact all, int size) {
  SparseMatrix g(all.problem.g), force(size, all.problem.g.rows());
  g.conservativeResize(g.rows(), size);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t c = 0; c < all.unknowns.size(); ++c)
    for (SparseMatrix::InnerIterator it(all.force, all.unknowns[c]); it; ++it)
      entries.emplace_back(static_cast<int>(c), static_cast<int>(it.col()), it.value());
  force.setFromTriplets(entries.begin(), entries.end());
  all.g = std::move(g);
  all.trace = all.trace_c;
  all.trace.conservativeResize(all.trace.rows(), size);
  all.force = std::move(force);
  for (auto& readings : all.readings) readings.restrict_to(all.unknowns, size);
  std::iota(all.unknowns.begin(), all.unknowns.end(), 0);
  all.loaded = all.unknowns;
  return all;
}

} // namespace

DiscreteProblem on_contact_unknowns(DiscreteProblem all, Interior& interior,
                                    std::span<const Vector> of_loads) {
  LoadAssembler loads = std::move(all.loads);
  loads.map([next = of_loads.begin()](const Vector&) mutable { return *next++; });
  Vector initial = add_state(interior, all.initial);
  const int n = interior.size(); // all modes are known
  const auto padded = [n](const Vector& v) {
    Vector out = Vector::Zero(n);
    out.head(v.size()) = v;
    return out;
  };
  loads.map(padded);
  StateLayout layout = of_interior(all.layout, all.contact.unknowns, n);
  return {std::move(layout), of_interior(std::move(all.operators), interior),
          of_interior(std::move(all.contact), n), std::move(loads), padded(initial)};
}

std::vector<char> checked_steps(const Plan& plan, int steps) {
  std::vector<char> out(steps + 1, 0);
  const int every = interior_every(plan, nullptr);
  for (int n = every; every > 0 && n <= steps; n += every) out[n] = 1;
  std::mt19937 random(static_cast<unsigned>(steps));
  for (int k = 0; k < random_checks; ++k) out[1 + random() % static_cast<unsigned>(steps)] = 1;
  out[steps] = 1;
  return out;
}

} // namespace hvi::solver
