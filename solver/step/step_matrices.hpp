// The matrices of a run's steps that have a factor.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/time_scheme.hpp"
#include "solver/formulation/formulation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/work.hpp"

#include <functional>
#include <list>
#include <utility>

namespace hvi::solver {

/// The matrix of a step.
struct FoundMatrix {
  StepMatrix& matrix;
  bool fresh; ///< it has just been factored
};

/// One that is kept, for steps of its kind.
struct KeptMatrix {
  double rate, length; ///< the scheme's factor of u', and the length of the step
  std::unique_ptr<StepMatrix> matrix;
};

/// A step's matrix depends on its length and on the scheme's factors; memories may change it a
/// little in every step, and then the factor of another step serves (balance.hpp).
class StepMatrices {
public:
  /// Keeps references to all of them.
  StepMatrices(const Plan& plan, const Discretisation& discretisation,
               const Formulation& formulation, const TimeScheme& scheme);
  StepMatrices(const StepMatrices&) = delete; // its matrices call it
  StepMatrices& operator=(const StepMatrices&) = delete;

  /// One that serves step n; else it is factored for the fields' factors in that step
  /// (Evolution::factors).
  FoundMatrix find(int n, const Vector& factors);
  /// Factors K_n. Throws Failure(not_coercive) in the user's words.
  void factor(int n, const Vector& factors, StepMatrix& matrix) const;
  /// Of the last step; null before the first one.
  StepMatrix* latest() const { return kept_.empty() ? nullptr : kept_.front().matrix.get(); }
  /// All of them, in the order of use.
  std::vector<const SparseMatrix*> all() const;

  /// Called before every iteration of a step, which ends by what it throws.
  void call_before_iterations(std::function<void()> what) { before_iteration_ = std::move(what); }
  void before_iteration() const {
    if (before_iteration_) before_iteration_();
  }

  /// Adds what factors cost, and the bytes they hold, to the counters and phases of a run.
  void account(WorkCounters& work, Timing& timing) const;
  void save(std::ostream& out) const;
  /// Factors again for the saved coefficients.
  void restore(std::istream& in);

private:
  const Plan& plan_;
  const Discretisation& discretisation_;
  const Formulation& formulation_;
  std::vector<RigidMotions> motions_; ///< that imposed values allow, by unknown
  const TimeScheme& scheme_;
  std::size_t most_;
  std::function<void()> before_iteration_;
  std::list<KeptMatrix> kept_; ///< most recently used first
};

/// Adds the cost of one factor.
void charge(const FactorStatistics& factor, WorkCounters& work, Timing& timing);

} // namespace hvi::solver
