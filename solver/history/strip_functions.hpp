// Sets that are symmetric about the real line: what functions make of them. Internal to
// solver/history.
#pragma once

#include "solver/history/strip.hpp"
#include "solver/kernel/table.hpp"

namespace hvi::solver::strips {

using State = Strip::State;

/// Nothing is known but that the function may not be analytic.
Strip nothing(State state);
/// A set that is not finite means the same.
Strip checked(const Strip& z);
inline bool is_number(const Strip& z) { return z.low == z.high && z.imaginary == 0; }

Strip add(const Strip& a, const Strip& b);
Strip negate(const Strip& a);
Strip multiply(const Strip& a, const Strip& b);
Strip reciprocal(const Strip& z);
Strip power(const Strip& base, const Strip& exponent);
/// z^c in the right half plane.
Strip right_power(const Strip& z, double c);

Strip exponential(const Strip& z);
Strip logarithm(const Strip& z);
Strip cosine(const Strip& z);
Strip sine(const Strip& z);
Strip arcsine(const Strip& z);
Strip arctangent(const Strip& z);
/// cosh where it is even, else sinh
Strip hyperbolic(const Strip& z, bool even);
Strip tangent_hyperbolic(const Strip& z);
Strip error_function(const Strip& z);
/// erfc, and exp(z^2) i^n erfc(z)
Strip error_left(const Strip& z);
Strip scaled_error(const Strip& order, const Strip& z);
Strip mittag_leffler(const Strip& a, const Strip& b, const Strip& z);
Strip bessel(const Strip& order, const Strip& z);
Strip tabulated(const Table& table, const Strip& z, bool slope);

} // namespace hvi::solver::strips
