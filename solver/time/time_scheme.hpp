// How the derivatives of the unknown at t_n are written in the increment of the step.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/linear/sparse.hpp"
#include "solver/time/time_grid.hpp"

#include <array>
#include <iosfwd>
#include <memory>

namespace hvi::solver {

/// A factor times a vector of states that the scheme carries.
struct KnownTerm {
  double factor = 0.0;
  const Vector* of = nullptr; ///< null: no term
};
/// Their sum.
using KnownTerms = std::array<KnownTerm, 2>;

/// With the increment d_n = u_n - u_{n-1} of step n the j-th derivative in time is
///
///   u^(j)(t_n) = factor(n, j) d_n + known(n, j),    j = 1, 2, ...
///
/// A step's equation is made of these. A scheme with another formula, or one that knows the second
/// derivative, is another class, which carries from step to step what its known parts are made of.
class TimeScheme {
public:
  explicit TimeScheme(const TimeSpec& spec) : grid_(spec) {}
  TimeScheme(const TimeScheme&) = delete;
  TimeScheme& operator=(const TimeScheme&) = delete;
  virtual ~TimeScheme() = default;

  const TimeGrid& grid() const { return grid_; }
  /// 0: the scheme gives this derivative the value 0.
  virtual double factor(int n, int derivative) const = 0;
  /// Of step n, after step n - 1.
  virtual KnownTerms known(int n, int derivative) const;
  /// out = u^(j)(t_n), after step n.
  virtual void derivative(int n, int derivative, Vector& out) const;

  /// From rest, with states of this size.
  virtual void start(int n_state);
  /// Step n has the increment d, a state. Takes it and leaves any vector of its size in its place.
  virtual void accept(int n, Vector& d);
  /// d_n and d_{n-1} after step n.
  const Vector& last() const { return last_; }
  const Vector& before() const { return before_; }

  virtual void save(StateWriter& w) const;
  virtual void restore(StateReader& r);

private:
  TimeGrid grid_;
  Vector last_, before_;
};

/// Static: every derivative is zero.
/// Backward Euler: u'(t_n) = d_n / k_n.
/// BDF2 on steps of any length, w = k_n / k_{n-1}:
///   u'(t_n) = (1 + 2 w) / ((1 + w) k_n) d_n - w^2 / ((1 + w) k_n) d_{n-1};
/// its first step is backward Euler, whose single local error of order k^2 keeps the second order
/// (M. Crouzeix, F. J. Lisbona, The convergence of variable-stepsize, variable-formula, multistep
/// methods, SIAM J. Numer. Anal. 21 (1984) 512-534).
std::unique_ptr<TimeScheme> make_scheme(const TimeSpec& spec);

/// How many factors of matrices are worth keeping: 1 where no coefficient of u' comes back after
/// another one.
int useful_factors(const TimeScheme& scheme);

} // namespace hvi::solver
