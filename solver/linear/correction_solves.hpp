// The two triangular solves of a correction.
#pragma once

#include "solver/linear/factorisation.hpp"

#include <iosfwd>
#include <span>

namespace hvi::solver {

/// A step's equation is solved by corrections of a first state: what is left of the equation is
/// computed after each of them, and decides whether another one follows. So the solves of a
/// correction may be rough where it is small. Here they are those of the factor itself; another
/// class may make them cheaper (linear/mixed), and whoever asks for corrections need not know how.
class CorrectionSolves {
public:
  /// `tolerance`: an error of the equation that is small enough.
  explicit CorrectionSolves(double tolerance) : tolerance_(tolerance) {}
  virtual ~CorrectionSolves() = default;

  /// Begins the corrections of one step, whose matrix is known by where K is; `guessed`: of a state
  /// near the solution. The error that they have to reach.
  virtual double begin(const SparseMatrix& /*k*/, bool /*guessed*/) { return tolerance_; }
  /// Factorisation::forward and Factorisation::back with the columns of the interior. `moved`: how
  /// far the correction takes the contact unknowns, over their size.
  virtual void forward(Factorisation& factor, Vector& y) { factor.forward(y, Columns::interior); }
  virtual void back(Factorisation& factor, double /*moved*/, Vector& y) {
    factor.back(y, Columns::interior);
  }
  /// What the correction left of the equation. `exact`: the factor is that of the step's own
  /// matrix.
  virtual void judge(double /*moved*/, double /*error*/, bool /*exact*/) {}

  /// After an accepted step. `predictable`: the next one is near an extrapolation.
  virtual void accept(const SparseMatrix& /*k*/, const Factorisation& /*factor*/,
                      bool /*predictable*/, int /*steps_left*/) {}
  /// From now on every solve is the factor's own.
  virtual void stop() {}
  /// What it did and holds besides the factors.
  virtual FactorStatistics statistics() const { return {}; }
  /// `matrices`: all of the run, in the same order.
  virtual void save(std::ostream& /*out*/, std::span<const SparseMatrix* const> /*matrices*/) {}
  virtual void restore(std::istream& /*in*/, std::span<const SparseMatrix* const> /*matrices*/) {}

protected:
  double tolerance() const { return tolerance_; }

private:
  double tolerance_;
};

} // namespace hvi::solver
