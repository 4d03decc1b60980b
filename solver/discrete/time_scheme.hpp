// How the derivatives of the unknown at t_n are written in the increment of the step.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/time_grid.hpp"
#include "solver/linear/sparse.hpp"

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
using KnownTerms = std::array<KnownTerm, 3>;

/// With the increment d_n = u_n - u_{n-1} of step n the j-th derivative in time is
///
///   u^(j)(t_n) = factor(n, j) d_n + known(n, j),    j = 1, 2, ...
///
/// A step's equation is made of these, and of what they were a step ago: with F_j the forms in
/// u^(j), those in memories and the loads counting as F_0,
///
///   sum_j F_j (present(j) u^(j)(t_n) + past(j) u^(j)(t_{n-1}))
///     + G^T W (xi_n + past_of_laws() xi_{n-1}) = 0,    xi_n in dj(M u_n), dj(M u'(t_n)).
///
/// A scheme with another formula is another class, which carries from step to step what its known
/// parts are made of.
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
  /// The share of u^(j)(t_n), and that of u^(j)(t_{n-1}), in the equation of step n.
  virtual double present(int derivative) const;
  virtual double past(int derivative) const;
  virtual double past_of_laws() const { return 0.0; }
  /// Does an equation hold anything of the step before?
  bool looks_back() const { return past(0) != 0.0; }

  /// From rest, with states of this size.
  virtual void start(int n_state);
  /// In motion: the state u'(t_0). Where needs_acceleration(), u''(t_0) as well.
  virtual void start_motion(const Vector& velocity, const Vector& acceleration);
  virtual bool needs_acceleration() const { return false; }
  /// In motion: the velocity at the end of the last step, of which kinetic energy is made; null at
  /// rest.
  virtual const Vector* velocity() const { return nullptr; }
  /// Before step n of a state whose entries from `first` on are imposed: d, a state, has what they
  /// move by. A scheme that carries velocities takes theirs from their values alone.
  virtual void impose(int /*n*/, Eigen::Index /*first*/, const Vector& /*d*/) {}
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
/// With u'' both take it from u' as they take u' from u, u'(t_0) being given.
/// The others are those of motion.hpp.
std::unique_ptr<TimeScheme> make_scheme(const Problem& problem);

/// By field: what its forms count in a step's equation (TimeScheme::present).
Vector present_shares(const TimeScheme& scheme, int n_fields);

/// How many factors of matrices are worth keeping: 1 where no coefficient of u' comes back after
/// another one.
int useful_factors(const TimeScheme& scheme);

} // namespace hvi::solver
