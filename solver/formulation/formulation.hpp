// The equations of a run, in the unknowns that its steps are solved in.
//
// There are two: all unknowns of the problem, or, where all tensors are multiples of one, the
// contact unknowns with a few modes (interior.hpp). A step is the same equation in both.
#pragma once

#include "solver/discrete/body_states.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/discrete/state_loads.hpp"
#include "solver/formulation/row_checks.hpp"
#include "solver/formulation/step_matrix.hpp"
#include "solver/plan/plan.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace hvi::solver {

struct DiscreteProblem {
  StateLayout layout;
  Operators operators;
  Contact contact;
  LoadAssembler loads; ///< on the unknowns
  Vector initial;      ///< state u_0
  ChangingForms changing{};
  StateLoads state_loads{}; ///< on the unknowns
};

class Formulation {
public:
  explicit Formulation(DiscreteProblem&& problem) : problem_(std::move(problem)) {}
  Formulation(const Formulation&) = delete;
  Formulation& operator=(const Formulation&) = delete;
  virtual ~Formulation() = default;

  const StateLayout& layout() const { return problem_.layout; }
  const Operators& operators() const { return problem_.operators; }
  const Contact& contact() const { return problem_.contact; }
  Contact& contact() { return problem_.contact; } ///< laws are prepared for each step
  /// Do states change forms?
  bool changes_forms() const { return !problem_.changing.none(); }
  /// Do states change the equation: forms, or loads?
  bool changes() const { return changes_forms() || !problem_.state_loads.none(); }
  /// Forms that read states become those of contact().state_values.
  void take_states() {
    problem_.changing.take(problem_.contact, problem_.layout, problem_.operators);
  }
  /// Those that read states; `loads` has the others.
  const StateLoads& state_loads() const { return problem_.state_loads; }
  const LoadAssembler& loads() const { return later_loads_ ? *later_loads_ : problem_.loads; }
  /// Other ones take their place. Only where states hold all unknowns.
  void take_loads(LoadAssembler&& loads) { later_loads_.emplace(std::move(loads)); }
  const Vector& initial() const { return problem_.initial; }
  bool imposed() const { return layout().n_state > layout().n_unknowns; }
  /// Factors leave room for so many bytes that a run will take besides them.
  void expect_memory(double bytes) { problem_.operators.memory_to_come = bytes; }

  /// Why states hold all unknowns of the problem; empty: they hold the contact unknowns.
  virtual const std::string& obstacle() const = 0;
  bool reduced() const { return obstacle().empty(); }
  /// Full vector of a state; dofs without a value in it become 0.
  virtual void scatter(const Vector& state, Vector& full) const = 0;
  /// The same for dofs that will be read in every step. `scatter_observed` sets these and the
  /// contact unknowns; others may keep what they have.
  virtual void observe(std::span<const int> dofs) = 0;
  virtual void scatter_observed(const Vector& state, Vector& full) const = 0;

  /// Of the problem on all its unknowns: the layout, the values of a state on the columns of its
  /// base matrices (in `room`, or the state itself), and add_rounding (rounding.hpp) of such a
  /// matrix and such values.
  virtual const StateLayout& whole_layout() const = 0;
  virtual const Vector& whole_state(const Vector& state, Vector& room) const = 0;
  virtual void add_rounding_of_base(int b, const Vector& values, double unit,
                                    RoundingForces& forces, Vector& size) const = 0;
  /// respond (step_matrix.hpp) of the matrix on all unknowns; `matrix` is that of a step with these
  /// coefficients.
  virtual bool respond(std::span<const Vector> forces, StepMatrix& matrix, const Vector& gamma,
                       const InequalityState& at, std::vector<Vector>& x,
                       std::vector<Vector>& xi) const = 0;
  /// The condition number of a step's matrix on all unknowns, estimated; 0: there is none.
  virtual double condition(StepMatrix* of_step) const = 0;
  /// The checks that steps owe beyond their own rows; null: none.
  virtual std::unique_ptr<RowChecks> row_checks(const Plan& plan) const = 0;
  /// Of factors besides those of the steps' matrices.
  virtual FactorStatistics statistics() const = 0;

private:
  DiscreteProblem problem_;
  std::optional<LoadAssembler> later_loads_;
};

/// The loads of a problem on these unknowns.
LoadAssembler loads_on(const Problem& problem, const Discretisation& discretisation,
                       const StateLayout& layout);

/// On the contact unknowns where that is possible (reduce.hpp), else on all unknowns.
std::unique_ptr<Formulation> formulate(const Plan& plan, const Discretisation& discretisation);

} // namespace hvi::solver
