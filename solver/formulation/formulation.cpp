// The two formulations of a problem; see formulation.hpp. Made by the Stepper.
#include "solver/formulation/formulation.hpp"

#include "solver/discrete/dealt_operators.hpp"
#include "solver/discrete/nodes_of_unknowns.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/formulation/field_recovery.hpp"
#include "solver/formulation/halved_bases.hpp"
#include "solver/formulation/interior.hpp"
#include "solver/formulation/pair_unknowns.hpp"
#include "solver/formulation/reduce.hpp"
#include "solver/formulation/solver_choice.hpp"
#include "solver/linear/processes.hpp"

namespace hvi::solver {
namespace {

class OnAllUnknowns final : public Formulation {
public:
  OnAllUnknowns(DiscreteProblem&& problem, std::string obstacle)
      : Formulation(std::move(problem)), obstacle_(std::move(obstacle)) {}

  const std::string& obstacle() const override { return obstacle_; }
  void scatter(const Vector& state, Vector& full) const override { layout().scatter(state, full); }
  void observe(std::span<const int>) override {}
  void scatter_observed(const Vector& state, Vector& full) const override { scatter(state, full); }
  const StateLayout& whole_layout() const override { return layout(); }
  const Vector& whole_state(const Vector& state, Vector&) const override { return state; }
  void add_rounding_of_base(int b, const Vector& values, double unit, RoundingForces& forces,
                            Vector& size) const override {
    const auto at = static_cast<std::size_t>(b);
    if (operators().dealt)
      operators().dealt->add_rounding(b, values, unit, forces, size);
    else if (operators().halves.empty())
      add_rounding(operators().bases[at], values, unit, forces, size);
    else
      add_rounding(operators().halves[at], values, unit, forces, size);
  }
  bool respond(std::span<const Vector> forces, StepMatrix& matrix, const Vector&,
               const InequalityState& at, std::vector<Vector>& x,
               std::vector<Vector>& xi) const override {
    return hvi::solver::respond(matrix, forces, at, x, xi);
  }
  double condition(StepMatrix* of_step) const override {
    return of_step == nullptr ? 0.0 : hvi::solver::condition(*of_step, operators());
  }
  std::unique_ptr<RowChecks> row_checks(const Plan&) const override { return nullptr; }
  FactorStatistics statistics() const override { return {}; }

private:
  std::string obstacle_;
};

class OnContactUnknowns final : public Formulation {
public:
  /// `force`: G^T W on all unknowns.
  OnContactUnknowns(DiscreteProblem&& problem, std::unique_ptr<Interior> interior,
                    SparseMatrix force)
      : Formulation(std::move(problem)), interior_(std::move(interior)), fields_(*interior_),
        equilibrium_(*interior_, std::move(force)) {}

  const std::string& obstacle() const override { return none_; }
  void scatter(const Vector& state, Vector& full) const override { fields_.scatter(state, full); }
  void observe(std::span<const int> dofs) override { fields_.observe(dofs); }
  void scatter_observed(const Vector& state, Vector& full) const override {
    fields_.scatter_observed(state, full);
  }
  const StateLayout& whole_layout() const override { return interior_->layout; }
  const Vector& whole_state(const Vector& state, Vector& room) const override {
    expand(*interior_, state, room);
    return room;
  }
  void add_rounding_of_base(int, const Vector& values, double unit, RoundingForces& forces,
                            Vector& size) const override {
    add_rounding(interior_->t, values, unit, forces, size);
  }
  bool respond(std::span<const Vector> forces, StepMatrix& matrix, const Vector& gamma,
               const InequalityState& at, std::vector<Vector>& x,
               std::vector<Vector>& xi) const override {
    return solver::respond(*interior_, forces, matrix, gamma[0], at, x, xi);
  }
  double condition(StepMatrix*) const override {
    return estimate_condition(interior_->t, *interior_->factor);
  }
  std::unique_ptr<RowChecks> row_checks(const Plan& plan) const override {
    return std::make_unique<RowChecks>(equilibrium_, fields_, plan);
  }
  FactorStatistics statistics() const override { return interior_->factor.statistics(); }

private:
  std::string none_;
  std::unique_ptr<Interior> interior_;
  mutable FieldRecovery fields_; ///< remembers the last state
  InteriorEquilibrium equilibrium_;
};

/// For iterations: by all processes, where there are several. One process has the same base
/// matrices then: it may go on from the checkpoint of several.
Operators operators_for_iterations(const Plan& plan, const Discretisation& d,
                                   const StateLayout& layout) {
  const int processes = plan.problem.forms.empty() ? 1 : processes_led();
  if (processes > 1) return deal_operators(plan.problem, d, layout, processes);
  return assemble_operators(plan.problem, d, layout, plan.options.threads, false);
}

/// Where nobody asked for a solver the first process assembles, for the choice goes by that.
Operators operators_of(const Plan& plan, const Discretisation& d, const StateLayout& layout) {
  if (plan.options.solver == LinearSolver::iterative)
    return operators_for_iterations(plan, d, layout);
  return assemble_operators(plan.problem, d, layout, plan.options.threads);
}

/// What was assembled for the choice serves no more.
void take_iterations(const Plan& plan, const Discretisation& d, const StateLayout& layout,
                     Operators& operators, Contact& contact) {
  const ChosenSolver chosen = std::move(operators.chosen);
  if (plan.options.solver != LinearSolver::iterative) {
    operators = {};
    operators = operators_for_iterations(plan, d, layout);
    contact = make_contact(plan.problem, d, layout, true);
  }
  operators.chosen = chosen;
  if (!operators.iterative) operators.iterative = nodes_of_unknowns(d, layout);
}

DiscreteProblem on_all_unknowns(const Plan& plan, const Discretisation& d) {
  const StateLayout layout = make_layout(d.space, d.dofs);
  LoadAssembler loads = loads_on(plan.problem, d, layout);
  Vector initial = initial_state(plan.problem, d, layout);
  Operators operators = operators_of(plan, d, layout);
  const bool asked = plan.options.solver == LinearSolver::iterative;
  Contact contact = make_contact(plan.problem, d, layout, asked);
  operators.chosen = choose_solver(plan, d, layout, operators, contact);
  if (operators.chosen.solver == LinearSolver::iterative)
    take_iterations(plan, d, layout, operators, contact);
  ChangingForms changing(plan.problem, d, contact, operators);
  changing.take(contact, layout, operators);
  StateLoads state_loads(plan.problem, d, contact, &layout);
  if (operators.iterative && !operators.dealt) keep_halves(operators, plan.options.threads);
  return {layout,
          std::move(operators),
          std::move(contact),
          std::move(loads),
          std::move(initial),
          std::move(changing),
          std::move(state_loads)};
}

/// The evolution on contact unknowns needs those of both sides of a pair: beyond so many of them
/// the laws of a step take longer than its triangular solves.
constexpr std::size_t most_on_both_sides = 1500;

/// False: the contact unknowns stay those of both sides.
bool take_jumps_as_unknowns(const Plan& plan, const Discretisation& d, DiscreteProblem& all) {
  // With inertia bodies rest, or all but rest, while others move: rounding of these would be most
  // of what a factor that joins them leaves there.
  if (!plan.options.jumps_as_unknowns || in_motion(plan.problem) || all.operators.iterative)
    return false;
  auto jumps = jumps_as_unknowns(plan.problem, d.space, all.layout, all.contact);
  if (!jumps.change) return false;
  const Operators& operators = all.operators;
  if (const auto motions = motions_of_unknowns(d); !motions.empty())
    if (const auto free = find_free_body(
            motions, combine(operators, Vector::Ones(operators.n_bases())), all.layout);
        free && !all_make_jumps(*free, all.contact, jumps.rows))
      return false;
  change_unknowns(plan.problem, d.space, all.layout, std::move(jumps.change), all.contact);
  if (!all.contact.whole) return true;
  change_unknowns(plan.problem, d.space, all.layout, nullptr, all.contact);
  return false;
}

/// The body that follows from its contact unknowns; null, and nothing is taken: T is
/// ill-conditioned. What T makes of rounding and of the loads comes from one reading of its factor.
std::unique_ptr<Formulation> condensed(DiscreteProblem& all) {
  SparseMatrix& t = all.operators.bases[0];
  auto factor = take_factor(all.operators.shared, t, all.contact.unknowns, true);
  const RowUnits unit(own_stiffness(t), all.contact.of_unknown);
  std::vector<Vector> right{growth_probe(t, unit)}, r, of_loads;
  all.loads.map([&](const Vector& f) { return right.emplace_back(f); });
  DenseMatrix y;
  forward(*factor, right, y, r);
  const auto inside = y.leftCols(factor->order().interior);
  if (!(rounding_growth(right[0], unit, inside.row(0), r[0], *factor) <= growth_to_refine))
    return nullptr;
  auto interior =
      std::make_unique<Interior>(t, std::move(factor), all.layout, all.contact.unknowns);
  for (std::size_t k = 1; k < right.size(); ++k)
    of_loads.push_back(
        add_mode(*interior, right[k], inside.row(static_cast<Eigen::Index>(k)), r[k]));
  SparseMatrix force = all.contact.force; // of all rows, for their certificate
  auto reduced = on_contact_unknowns(std::move(all), *interior, of_loads);
  return std::make_unique<OnContactUnknowns>(std::move(reduced), std::move(interior),
                                             std::move(force));
}

} // namespace

LoadAssembler loads_on(const Problem& problem, const Discretisation& d, const StateLayout& layout) {
  LoadAssembler out(d.space, d.parts, problem.loads);
  out.restrict_to({layout.dof_of.data(), static_cast<std::size_t>(layout.n_unknowns)},
                  layout.links);
  return out;
}

std::unique_ptr<Formulation> formulate(const Plan& plan, const Discretisation& discretisation) {
  DiscreteProblem all = on_all_unknowns(plan, discretisation);
  std::string obstacle =
      proportional_obstacle(plan, all.operators, all.contact, all.loads, all.layout);
  if (obstacle.empty() && !all.contact.none() &&
      find_free_body(motions_of_unknowns(discretisation), all.operators.bases[0], all.layout))
    obstacle = "laws alone hold the body";
  if (obstacle.empty() && all.contact.unknowns.size() > most_on_both_sides &&
      take_jumps_as_unknowns(plan, discretisation, all))
    obstacle = "the jumps across a pair become unknowns";
  if (obstacle.empty()) {
    try {
      if (auto made = condensed(all)) return made;
      obstacle = "its matrix is ill-conditioned, and steps are refined on all unknowns";
    } catch (const NotFactorable&) { // the first step will say which motion is free
      obstacle = "its matrix has no factor";
    }
  }
  if (!all.contact.change) take_jumps_as_unknowns(plan, discretisation, all);
  return std::make_unique<OnAllUnknowns>(std::move(all), std::move(obstacle));
}

} // namespace hvi::solver
