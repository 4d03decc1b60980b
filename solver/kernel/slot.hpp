// The variables a pointwise expression may depend on, as numbered slots.
#pragma once

#include <array>

namespace hvi::solver {

using Slot = int;

namespace slot {
inline constexpr Slot gap = -1; ///< at the points of a pair: the distance of its sides
inline constexpr Slot t = 3;    ///< time
inline constexpr Slot lag = 4;  ///< t - s, always formed as a lag, never as a difference
/// A problem has so many unknowns at most, and a function of one of them so many derivatives.
inline constexpr int most_unknowns = 4;
inline constexpr int own_derivatives = 12;
inline constexpr int n_derivatives = most_unknowns * own_derivatives;
inline constexpr int first_field = 96;
inline constexpr int field_stride = n_derivatives;
inline constexpr int first_multiplier = 16384;
inline constexpr int first_inside = 65536;
inline constexpr int first_state = 131072;
inline constexpr int first_probe = 196608;

inline constexpr Slot x(int i) { return i; }            ///< position, i < 3
inline constexpr Slot normal(int i) { return 5 + i; }   ///< outward unit normal, i < 3
inline constexpr Slot argument(int i) { return 8 + i; } ///< argument of a law, i < 3
inline constexpr Slot r = argument(0);                  ///< of a law of a scalar, j(r)
/// Components of a function and its gradient, in one numbering ("derivative index"):
/// 0..2 are the values w_i, 3 + 3 i + j is dw_i/dx_j. A scalar function has i = 0. On axisymmetric
/// meshes 3 + 3 * 2 + 2 is w_x/x, the entry of the gradient along the circles. Those of the b-th
/// unknown of a problem with several of them are own_derivatives b behind.
inline constexpr int value(int i) { return i; }
inline constexpr int gradient(int i, int j) { return 3 + 3 * i + j; }
inline constexpr int hoop = gradient(2, 2);
inline constexpr int of_unknown(int b, int derivative) { return own_derivatives * b + derivative; }
inline constexpr int unknown_of(int derivative) { return derivative / own_derivatives; }
inline constexpr bool is_value(int derivative) { return derivative % own_derivatives < 3; }
/// At points of a pair w_i is the jump, the first side's value minus the second one's; gradients
/// are not known there, and this stands for the mean of both sides.
inline constexpr int mean(int i) { return gradient(i, 0); }
inline constexpr bool may_be_mean(int derivative) {
  return !is_value(derivative) && derivative % own_derivatives % 3 == 0;
}
/// Of a value or a mean: which w_i.
inline constexpr int component_of(int derivative) {
  const int own = derivative % own_derivatives;
  return own < 3 ? own : (own - 3) / 3;
}
/// Inside a law: the multiplier of another law at the same point (Coulomb's bound).
inline constexpr Slot coupled = 11;
/// Inside a law: what it reads of the solution at its point (LawSpec::readings), i < most_readings.
inline constexpr int most_readings = 4;
inline constexpr Slot reading(int i) { return 64 + i; }
/// Inside a law: the k-th state that it reads, k < most_law_states.
inline constexpr int most_law_states = 4;
inline constexpr Slot law_state(int k) { return 12 + k; }
/// The test function v.
inline constexpr Slot test(int derivative) { return 16 + derivative; }
inline constexpr bool is_test(Slot s) { return s >= test(0) && s < test(n_derivatives); }
/// Field k: 0 is u, 1 is u', 2 is u'', 3 + m is the m-th history field of the plan. With several
/// unknowns u stands for all of them.
inline constexpr Slot field(int k, int derivative) {
  return first_field + field_stride * k + derivative;
}
inline constexpr bool is_field(Slot s) { return s >= first_field && s < first_multiplier; }
inline constexpr int field_of(Slot s) { return (s - first_field) / field_stride; }
inline constexpr int derivative_of(Slot s) { return (s - first_field) % field_stride; }
inline constexpr bool is_field_gradient(Slot s) {
  return is_field(s) && !is_value(derivative_of(s));
}
/// A law sees so many numbers at most: a matrix in 3D.
inline constexpr int most_arguments = 9;
/// Multiplier xi of the l-th law application, component c (in the global frame).
inline constexpr Slot multiplier(int l, int c) { return first_multiplier + most_arguments * l + c; }
inline constexpr bool is_multiplier(Slot s) { return s >= first_multiplier && s < first_inside; }
inline constexpr int term_of(Slot s) { return (s - first_multiplier) / most_arguments; }
inline constexpr int row_of(Slot s) { return (s - first_multiplier) % most_arguments; }
/// 1 on part p of the plan, else 0 (a facet asks for itself, then for the cell behind it).
inline constexpr Slot inside(int p) { return first_inside + p; }
/// State i of the plan at the point (problem.hpp, StateTerm).
inline constexpr Slot state(int i) { return first_state + i; }
inline constexpr bool is_state(Slot s) { return s >= first_state && s < first_probe; }
/// The value of probe i of the report (combinations of probes).
inline constexpr Slot probe(int i) { return first_probe + i; }

/// What the order of operands follows, and with it the last bits of sums: the numbers that slots
/// had when there was one unknown, so that results stay what they were.
inline constexpr int order_key(Slot s) {
  constexpr int beyond = 1 << 20;
  if (s >= first_probe) return 32768 + s - first_probe;
  if (s >= first_state) return 28672 + s - first_state;
  if (s >= first_inside) return 16384 + s - first_inside;
  if (s >= first_multiplier) // laws had up to four arguments then
    return row_of(s) < 4 ? 4096 + 4 * term_of(s) + row_of(s) : beyond + s;
  if (is_field(s)) {
    const int d = derivative_of(s);
    return unknown_of(d) > 0 ? beyond + s : 32 + 16 * field_of(s) + d;
  }
  if (s >= reading(0)) return 28 + s - reading(0);
  return s >= test(own_derivatives) ? beyond + s : s;
}
} // namespace slot

/// A number of each of several unknowns, which have units of their own.
using ByUnknown = std::array<double, slot::most_unknowns>;

} // namespace hvi::solver
