// See solver_choice.hpp.
#include "solver/formulation/solver_choice.hpp"

#include "solver/formulation/reduce.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

// Measured by `tools/bench solvers` and `scale` on one processor of 2024 (docs/scale.md); only
// their ratios decide.
constexpr double seconds_of_a_flop = 1.0 / 4.5e10, seconds_of_an_entry = 1.0 / 1.5e9;
constexpr double reads_of_a_step = 6.0;        ///< of the factor
constexpr double seconds_of_ordering = 1.2e-7; ///< an entry of K
/// Of K in an iteration: it is read by smoothers, interpolations and products.
constexpr double seconds_of_iterated_entry = 6e-9, seconds_of_set_up_entry = 1e-6;
constexpr double seconds_of_start = 0.15; ///< of PETSc
constexpr double iterations_of_a_step = 12.0, iterations_of_friction = 48.0,
                 iterations_of_several = 170.0, iterations_of_several_that_rub = 270.0;
/// Of the condensed matrix, in a step of friction: Cholesky's, of which some columns change, or LU
/// in each of Newton's steps, which cost two of the former.
constexpr double factors_of_friction = 1.0, factors_of_friction_by_lu = 50.0;
constexpr double reads_of_friction_by_lu = 50.0; ///< of the factor, in such a step

/// Bytes of an entry by rows, and as part of a half.
constexpr double by_rows = 12.0, by_halves = 4.7;
/// Bytes of the multigrid for an entry of K, set-up included, and vectors of an iteration.
constexpr double multigrid = 19.0, vectors = 60.0;
/// More of both with several unknowns: each has a part of K, and GMRES keeps its directions.
constexpr double parts = 2.0 * by_rows, directions = 80.0;

/// So much more memory than predicted has to be there.
constexpr double spare = 1.15;

/// No factor of a mesh is larger than this many times unknowns^(4/3) entries.
constexpr double most_of_any_factor = 60.0;

std::string cost_text(const SolverCost& cost) {
  return fmt::format("{} and {:.2g} s", bytes_text(cost.bytes), cost.seconds);
}

SolverCost direct_cost(const StepSizes& s) {
  const double sides = s.symmetric ? 1.0 : 2.0, c = s.contact;
  const double entry = s.singles ? 0.5 : 1.0; // of a double
  SolverCost out;
  out.bytes = 8.0 * entry * sides * s.factor.nonzeros + (2 + s.matrices) * by_rows * s.entries +
              2.0 * sizeof(double) * c * c;
  const bool by_lu = s.rubs && !s.symmetric;
  const double factors = by_lu ? factors_of_friction_by_lu : s.rubs ? factors_of_friction : 0.0;
  const double laws = factors * c * c * c / 3.0;
  const double reads = by_lu ? reads_of_friction_by_lu : reads_of_a_step;
  const double solves = s.one_matrix ? c * c : reads * sides * s.factor.nonzeros;
  out.seconds = seconds_of_ordering * s.entries +
                seconds_of_a_flop * entry * sides * s.factor.flops +
                s.steps * (seconds_of_a_flop * laws + seconds_of_an_entry * solves);
  return out;
}

SolverCost iterative_cost(const StepSizes& s) {
  SolverCost out;
  const double matrices = (s.symmetric ? by_halves : by_rows) * s.matrices;
  out.bytes = s.entries * (by_rows + multigrid + matrices + (s.several ? parts : 0.0)) +
              sizeof(double) * (vectors + (s.several ? directions : 0.0)) * s.unknowns *
                  (s.symmetric ? 1.0 : 2.0);
  const double each = s.several && s.rubs ? iterations_of_several_that_rub
                      : s.several         ? iterations_of_several
                      : s.rubs            ? iterations_of_friction
                                          : iterations_of_a_step;
  out.seconds = seconds_of_start +
                s.entries * (seconds_of_set_up_entry + s.steps * each * seconds_of_iterated_entry);
  return out;
}

} // namespace

SolverCosts predicted_costs(const StepSizes& sizes) {
  return {direct_cost(sizes), iterative_cost(sizes)};
}

ChosenSolver choose_solver(LinearSolver asked, const SolverCosts& costs,
                           const std::string& obstacle, const MemoryRoom& room) {
  const bool fits = spare * costs.direct.bytes <= room.bytes,
             other = spare * costs.iterative.bytes <= room.bytes;
  ChosenSolver out{LinearSolver::direct, ""};
  if (asked == LinearSolver::direct || asked == LinearSolver::iterative) {
    out.solver = asked;
  } else if (!obstacle.empty()) {
    if (asked == LinearSolver::automatic || !fits) out.why = "iterations cannot: " + obstacle;
  } else if (!fits && !other) {
    out.why =
        fmt::format("neither a factor ({}) nor iterations ({}) fit into what {} leaves",
                    bytes_text(costs.direct.bytes), bytes_text(costs.iterative.bytes), room.from);
  } else if (!fits) {
    out = {LinearSolver::iterative,
           fmt::format("a factor takes {}, more than {} leaves; iterations take {}",
                       bytes_text(costs.direct.bytes), room.from,
                       bytes_text(costs.iterative.bytes))};
  } else if (asked == LinearSolver::automatic) {
    if (other && costs.iterative.seconds < costs.direct.seconds)
      out.solver = LinearSolver::iterative;
    out.why = fmt::format("a factor is predicted to take {}, iterations {}",
                          cost_text(costs.direct), cost_text(costs.iterative));
  }
  return out;
}

namespace {

/// The plan says nothing, and any factor of this size fits.
bool fits_in_any_case(LinearSolver asked, const StateLayout& layout) {
  if (asked == LinearSolver::direct || asked == LinearSolver::iterative) return true;
  if (asked == LinearSolver::automatic) return false;
  const double most = 8.0 * most_of_any_factor * std::pow(layout.n_unknowns, 4.0 / 3.0);
  return most < little_memory || spare * most < memory_room().bytes;
}

} // namespace

StepSizes sizes_of_steps(const Plan& plan, const Discretisation& d, const StateLayout& layout,
                         const Operators& operators, const Contact& contact) {
  const Space& space = d.space;
  std::vector<int> unknowns(space.nodes.size(), 0), last(space.nodes.size(), 0);
  const auto node = [&](int i) {
    return static_cast<std::size_t>(layout.dof_of[static_cast<std::size_t>(i)] / space.components);
  };
  for (int i = 0; i < layout.n_unknowns; ++i) ++unknowns[node(i)];
  StepSizes out;
  if (!contact.whole) {
    for (const int i : contact.unknowns) ++last[node(i)];
    out.contact = static_cast<double>(contact.unknowns.size());
  }
  out.unknowns = layout.n_unknowns;
  for (const SparseMatrix& base : operators.bases)
    out.entries = std::max(out.entries, static_cast<double>(base.nonZeros()));
  out.factor = estimate_factor(space.nodes, *space.graph, unknowns, last);
  out.matrices = operators.n_bases();
  out.steps = plan.problem.time.is_static ? 1 : static_cast<int>(plan.problem.time.grid.size()) - 1;
  out.symmetric = operators.symmetric && !contact.mixed;
  out.one_matrix = operators.n_bases() == 1 && !contact.none() && out.steps > 1;
  out.several = space.is_product();
  out.singles =
      plan.options.factor == FactorEntries::singles && operators.symmetric && !operators.coupled;
  out.rubs = std::ranges::any_of(plan.problem.laws, [](const LawSpec& law) { return law.radial; });
  return out;
}

ChosenSolver choose_solver(const Plan& plan, const Discretisation& d, const StateLayout& layout,
                           const Operators& operators, const Contact& contact) {
  const LinearSolver asked = plan.options.solver;
  if (fits_in_any_case(asked, layout)) return choose_solver(asked, {}, "", {});
  const SolverCosts costs = predicted_costs(sizes_of_steps(plan, d, layout, operators, contact));
  const MemoryRoom room = memory_room();
  const auto chosen = choose_solver(asked, costs, "", room);
  if (chosen.solver == LinearSolver::direct || petsc_is_there()) return chosen;
  return choose_solver(asked, costs, "the package hvi-petsc is not installed", room);
}

} // namespace hvi::solver
