// Enclosures of kernels off the real line: what proves that a quadrature rule has seen everything.
//
// Every operation is real on the real line, so that f(conj z) = conj f(z): a set that is symmetric
// about the real line stays so, and three numbers describe it.
#pragma once

#include "solver/kernel/tape.hpp"

#include <limits>
#include <span>
#include <vector>

namespace hvi::solver {

/// All z with low <= Re z <= high, |Im z| <= imaginary. Beside it the range over the real points of
/// the panel, by which a case of a kernel is chosen: the case then goes on, as an analytic
/// function, beyond the panel's ends.
struct Strip {
  double low = 0, high = 0, imaginary = 0;
  double real_low = 0, real_high = 0;
  enum class State : unsigned char {
    analytic,
    singular, ///< a singularity, a kink or a jump may lie within: smaller panels decide
    unknown   ///< an operation without a rule: nothing is proved, however small the panel
  };
  State state = State::analytic;

  static Strip exactly(double x) { return {x, x, 0, x, x, State::analytic}; }
  /// |z| is at most this; infinite where nothing is known.
  double modulus() const;
};

/// The ellipse with foci low, high whose half axes add up to `ellipse` (high - low) / 2, in a
/// rectangle. An analytic f with |f| <= M within it is approximated by polynomials of degree n
/// to 2 M ellipse^-n / (ellipse - 1) (Bernstein; L. N. Trefethen, Approximation Theory and
/// Approximation Practice, 2013, chapter 8).
inline constexpr double ellipse = 2.5;
Strip around(double low, double high);
/// t - z, z^c (singular where the set reaches the left half plane and c is no whole number), c z.
Strip difference(double t, const Strip& z);
Strip raised(const Strip& z, double c);
Strip scaled(double c, const Strip& z);

/// A bound of |f| on the ellipse around a panel.
struct Modulus {
  double most = 0;
  Strip::State state = Strip::State::analytic;
};

/// Encloses the values of the tape's first output; inputs[i] of slot tape.inputs[i].
Strip enclose(const Tape& tape, std::span<const Strip> inputs, std::vector<Strip>& registers);

} // namespace hvi::solver
