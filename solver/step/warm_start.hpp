// Where the solution of a step begins: at an extrapolation of the last steps, if they were alike.
#pragma once

#include "solver/step/balance.hpp"
#include "solver/step/predictor.hpp"

namespace hvi::solver {

class WarmStart {
public:
  /// Keeps references to both.
  WarmStart(const Evolution& evolution, const Contact& contact)
      : evolution_(evolution), contact_(contact) {}

  /// Was there an extrapolation for the last step, is there one for the next?
  bool ready() const { return predictor_.ready(); }
  void clear() { predictor_.clear(); }

  /// The difference between K_n, of the coefficients gamma, and the factored matrix, and the
  /// expected increment with which that difference is moved to the right-hand side. `d` is room.
  void find_change(int n, const Vector& gamma, const StepMatrix& matrix, StepEquation& equation,
                   Vector& d) const;
  /// Extrapolates from the last steps, if they had this factor: d and gap = rhs - K_n d, for d is
  /// then what the change of K_n was moved with. The laws' search begins there, too.
  bool predict(const StepMatrix& matrix, const StepEquation& equation, Trial& trial,
               InequalityState& laws);
  /// The laws' search begins at their present multipliers and at the contact unknowns of d.
  void begin_at(const Vector& d, InequalityState& laws);
  /// The search begins anywhere.
  void drop_guess(InequalityState& laws);
  /// After an accepted step n. Takes trial.kd and leaves any vector in its place.
  void note(int n, const StepMatrix& matrix, Trial& trial, const Vector& xi);

  void save(std::ostream& out) const { predictor_.save(out); }
  void restore(std::istream& in, int n_unknowns);

private:
  bool continues(int n, const StepMatrix& matrix) const;
  void guess_contact(const Vector& d, InequalityState& laws);

  const Evolution& evolution_;
  const Contact& contact_;
  Predictor predictor_;
  Vector c_guess_, xi_guess_; ///< memory of the last guesses
};

} // namespace hvi::solver
