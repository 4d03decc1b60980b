// See warm_start.hpp.
#include "solver/step/warm_start.hpp"

#include <cmath>

namespace hvi::solver {

/// Has step n the matrix and the length of the steps that the predictor knows?
bool WarmStart::continues(int n, const StepMatrix& matrix) const {
  const auto& grid = evolution_.grid();
  return n > 1 && grid.length(n) == grid.length(n - 1) && predictor_.knows(matrix.gamma());
}

/// The expected increment is the predictor's, else the one that continues the last two. The
/// difference is small, so that the error of the expected increment needs no second pair of
/// triangular solves.
void WarmStart::find_change(int n, const Vector& gamma, const StepMatrix& matrix,
                            StepEquation& equation, Vector& d) const {
  equation.change = gamma - matrix.gamma();
  for (Eigen::Index b = 0; b < gamma.size(); ++b)
    if (std::abs(equation.change[b]) <= 8e-16 * std::abs(gamma[b])) equation.change[b] = 0.0;
  if (equation.exact()) return;
  equation.expected.setZero(evolution_.u().size());
  if (n < 2) return;
  const auto n_unknowns = d.size();
  auto expected = equation.expected.head(n_unknowns);
  if (ready() && continues(n, matrix)) {
    predictor_.predict(d);
    expected = d;
    return;
  }
  const auto& grid = evolution_.grid();
  const Vector &last = evolution_.scheme().last(), &before = evolution_.scheme().before();
  expected = grid.length(n) / grid.length(n - 1) * last.head(n_unknowns);
  const bool even =
      n > 2 && grid.length(n) == grid.length(n - 1) && grid.length(n) == grid.length(n - 2);
  if (even) expected += (last - before).head(n_unknowns);
}

bool WarmStart::predict(const StepMatrix& matrix, const StepEquation& equation, Trial& trial,
                        InequalityState& laws) {
  if (!ready() || !continues(equation.n, matrix)) return false;
  predictor_.predict(trial.d);
  predictor_.predict_gap(equation.rhs, trial.gap);
  if (contact_.none()) return true;
  laws.xi_guess.swap(xi_guess_);
  predictor_.predict_multipliers(laws.xi_guess);
  guess_contact(trial.d, laws);
  return true;
}

void WarmStart::begin_at(const Vector& d, InequalityState& laws) {
  laws.xi_guess = laws.xi;
  guess_contact(d, laws);
}

void WarmStart::guess_contact(const Vector& d, InequalityState& laws) {
  auto& guess = laws.c_guess;
  guess.swap(c_guess_);
  contact_part(contact_, d, guess);
}

/// The memory of a guess is kept for the next step.
void WarmStart::drop_guess(InequalityState& laws) {
  if (laws.c_guess.size() > 0) laws.c_guess.swap(c_guess_);
  if (laws.xi_guess.size() > 0) laws.xi_guess.swap(xi_guess_);
  laws.c_guess.resize(0), laws.xi_guess.resize(0);
}

void WarmStart::note(int n, const StepMatrix& matrix, Trial& trial, const Vector& xi) {
  if (!continues(n, matrix)) predictor_.clear();
  predictor_.note(matrix.gamma(), trial.d, trial.kd, xi);
}

void WarmStart::restore(std::istream& in, int n_unknowns) {
  predictor_.restore(in, n_unknowns, contact_.n_rows());
}

} // namespace hvi::solver
