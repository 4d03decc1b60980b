// From all unknowns to the contact unknowns; see reduce.hpp. Called by the Stepper before its first
// step, and by the forecast of a plan.
#include "solver/time/reduce.hpp"

#include "solver/time/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace hvi::solver {
namespace {

constexpr int worth_recovering = 8; ///< steps per recovery of the interior

const char* name_of(Effect effect) {
  switch (effect) {
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
std::string different_tensors(const Plan& plan, const Operators& operators) {
  for (const auto& a : plan.forms)
    for (const auto& b : plan.forms) {
      const Vector x = operators.weights.row(a.field), y = operators.weights.row(b.field);
      if (std::abs(x.dot(y)) < (1 - 1e-12) * x.norm() * y.norm())
        return fmt::format("the tensors of {} and {} are not multiples of one tensor",
                           name_of(a.effect), name_of(b.effect));
    }
  return "the forms need more than one matrix";
}

/// How often whole fields are read: every so many steps; 0: at the end only.
int interior_every(const Plan& plan, std::string* who) {
  const int n_fields = first_history_field + static_cast<int>(plan.histories.size());
  int every = 0, base = 0;
  for (const auto& table : plan.report.tables) base = std::gcd(base, std::max(table.every, 1));
  for (const auto& probe : plan.report.probes)
    if (base > 0 && reads_interior(probe, n_fields)) {
      every = base;
      if (who != nullptr) *who = fmt::format("the table reads `{}` in the interior", probe.name);
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
  if (probe.kind == Probe::Kind::norm_v) return true;
  if (probe.kind != Probe::Kind::integral) return false;
  const auto read = fields_read({&probe.expression, 1}, n_fields);
  return std::find(read.begin(), read.end(), true) != read.end();
}

std::string proportional_obstacle(const Plan& plan, const Operators& operators,
                                  const Contact& contact, const LoadAssembler& loads,
                                  const StateLayout& layout) {
  if (!plan.options.proportional_path) return "it was asked for";
  if (plan.time.is_static) return "a static problem has one step";
  if (contact.none()) return "there is no contact law";
  if (operators.n_bases() != 1) return different_tensors(plan, operators);
  if (!operators.symmetric) return "the matrix is not symmetric";
  if (contact.whole) return "the laws act on most of the unknowns";
  if (!loads.separable()) return "a load does not separate into functions of t and of x";
  if (layout.n_state != layout.n_unknowns) return "boundary values other than zero are imposed";
  const int n_fields = first_history_field + static_cast<int>(plan.histories.size());
  for (const auto& probe : plan.report.probes)
    if (probe.time && reads_interior(probe, n_fields))
      return fmt::format("`{}` reads the interior between two steps", probe.name);
  for (const auto& picture : plan.report.pictures)
    if (picture.time)
      return fmt::format("the picture of `{}` reads the interior between two steps",
                         picture.field.name);
  std::string who;
  const int every = interior_every(plan, &who);
  if (every > 0 && every < worth_recovering)
    return fmt::format("{} {}", who,
                       every == 1 ? "at every step" : fmt::format("every {} steps", every));
  return {};
}

bool live_on_contact(StateLayout& layout, Operators& operators, Contact& contact,
                     LoadAssembler& loads, Vector& u0) {
  // All states are unknowns here. The factor comes first: what follows cannot fail.
  auto factor = lend_factor(operators.shared, operators.bases[0], contact.unknowns, true);
  if (rounding_growth(operators.bases[0], *factor.operator->()) > growth_to_refine) return false;
  const auto interior =
      std::make_shared<Interior>(operators.bases[0], std::move(factor), layout, contact.unknowns);
  loads.map([&](const Vector& f) { return interior->add_mode(f); });
  u0 = interior->add_state(u0);
  const int n = interior->size(), nc = interior->n_contact();
  const auto padded = [n](const Vector& v) {
    Vector out = Vector::Zero(n);
    out.head(v.size()) = v;
    return out;
  };
  loads.map(padded);
  u0 = padded(u0);

  operators.bases = {interior->matrix()};
  operators.shared = nullptr; // what is left is small
  operators.separate = nc;
  operators.n_unknowns = n;
  interior->force = contact.force; // for the certificate on all rows
  SparseMatrix g(contact.problem.g), force(n, contact.problem.g.rows());
  g.conservativeResize(g.rows(), n);
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < nc; ++c)
    for (SparseMatrix::InnerIterator it(contact.force, contact.unknowns[c]); it; ++it)
      entries.emplace_back(c, static_cast<int>(it.col()), it.value());
  force.setFromTriplets(entries.begin(), entries.end());
  std::vector<std::int32_t> dof_of(n, -1), entry_of(layout.n_dofs, -1);
  for (int c = 0; c < nc; ++c) {
    dof_of[c] = layout.dof_of[contact.unknowns[c]];
    entry_of[dof_of[c]] = c;
  }
  contact.g = std::move(g);
  contact.force = std::move(force);
  std::iota(contact.unknowns.begin(), contact.unknowns.end(), 0);
  layout.n_unknowns = layout.n_state = n;
  layout.dof_of = std::move(dof_of);
  layout.entry_of = std::move(entry_of);
  layout.interior = interior;
  return true;
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
