// Inside the kernel: the interval extension of each operation.
#pragma once

#include "solver/kernel/interval.hpp"
#include "solver/kernel/table.hpp"

#include <span>

namespace hvi::solver::rules {

/// glibc's elementary functions are off by less than this.
inline constexpr int library_ulps = 4;

Bounds add(const Bounds& a, const Bounds& b);
Bounds negate(const Bounds& a);
Bounds multiply(const Bounds& a, const Bounds& b);
Bounds divide(const Bounds& a, const Bounds& b);
/// Power with any exponent; a whole constant one is treated exactly.
Bounds power(const Bounds& base, const Bounds& exponent);
Bounds hull(const Bounds& a, const Bounds& b);

/// One-argument functions, sign included.
Bounds function(Op op, const Bounds& x);
/// bessel_j, erfcx, mittag_leffler, polygamma, gamma: parameters first, the variable last.
Bounds special(Op op, std::span<const Bounds> args);
Bounds arctangent(const Bounds& y, const Bounds& x);
Bounds tabulated(const Table& table, const Bounds& x, bool slope);

/// The enclosure of an operation (not of a leaf) from those of its arguments.
Bounds extension(const Expr& e, std::span<const Bounds> args);

/// Flags of a result that depends on a and b.
Bounds with_flags(double low, double high, const Bounds& a, const Bounds& b);
/// Widened by `ulps` units in the last place at both ends.
Bounds widened(Bounds b, int ulps);
/// Nothing is known but the flags.
Bounds anything(const Bounds& from);
inline bool is_point(const Bounds& b) { return b.low == b.high; }

} // namespace hvi::solver::rules
