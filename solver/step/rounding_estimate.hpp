// How far rounding may have moved the state of a run.
#pragma once

#include "solver/discrete/rounding.hpp"
#include "solver/step/balance.hpp"

namespace hvi::solver {

class RoundingEstimate {
public:
  /// Keeps references to all of them.
  RoundingEstimate(const Problem& problem, Formulation& formulation, const Evolution& evolution,
                   const Balance& balance);

  /// After each accepted step: what it left of its equation, with that backward error. `room`: any
  /// state.
  void note(double error, const Vector& gap, const Vector& xi, Vector& room);
  /// The largest |u| that was seen, within a factor 1.6.
  double largest_size() const { return largest_.size; }

  /// Samples of the error that rounding may have left in the state: each for a random change of
  /// the matrices and loads by a unit in the last place, and one for what the steps left of their
  /// equations; `backward_error`: of the steps so far. To be asked after the last step, with its
  /// matrix and multipliers.
  std::vector<ErrorSample> samples(StepMatrix& matrix, const InequalityState& accepted,
                                   double backward_error) const;
  /// By what an error of every step's equation grows over the steps together.
  double amplification() const;

  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  void note_size(Vector& room);
  std::vector<double> memory_of_one() const;
  Vector coefficients_of_one() const;
  std::vector<Vector> forces(double backward_error) const;
  std::vector<double> over_the_run(std::span<const Vector> forces, StepMatrix& matrix,
                                   const InequalityState& at, std::vector<Vector>& x,
                                   std::vector<Vector>& xi) const;

  const Problem& problem_;
  Formulation& formulation_;
  const Evolution& evolution_;
  const Balance& balance_;

  /// The state of the largest size so far: what acted on each base matrix then.
  struct Largest {
    double size = 0.0;
    int step = 0;
    std::vector<Vector> on_base;
  };
  Largest largest_;
  /// What the worst step so far left of its equation, within a factor 1.6.
  struct LeftOver {
    double error = 0.0; ///< its backward error
    Vector force;
  };
  LeftOver left_over_;
};

} // namespace hvi::solver
