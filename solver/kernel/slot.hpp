// The variables a pointwise expression may depend on, as numbered slots.
#pragma once

namespace hvi::solver {

using Slot = int;

namespace slot {
inline constexpr Slot gap = -1; ///< at the points of a pair: the distance of its sides
inline constexpr Slot t = 3;    ///< time
inline constexpr Slot lag = 4;  ///< t - s, always formed as a lag, never as a difference
inline constexpr int first_field = 32;
inline constexpr int field_stride = 16;
inline constexpr int first_multiplier = 4096;
inline constexpr int first_inside = 16384;
inline constexpr int first_state = 28672;
inline constexpr int first_probe = 32768;

inline constexpr Slot x(int i) { return i; }            ///< position, i < 3
inline constexpr Slot normal(int i) { return 5 + i; }   ///< outward unit normal, i < 3
inline constexpr Slot argument(int i) { return 8 + i; } ///< argument of a law, i < 3
inline constexpr Slot r = argument(0);                  ///< of a law of a scalar, j(r)
/// Components of a function and its gradient, in one numbering ("derivative index"):
/// 0..2 are the values w_i, 3 + 3 i + j is dw_i/dx_j. A scalar function has i = 0. On axisymmetric
/// meshes 3 + 3 * 2 + 2 is w_x/x, the entry of the gradient along the circles.
inline constexpr int value(int i) { return i; }
inline constexpr int gradient(int i, int j) { return 3 + 3 * i + j; }
inline constexpr int hoop = gradient(2, 2);
/// Inside a law: the multiplier of another law at the same point (Coulomb's bound).
inline constexpr Slot coupled = 11;
/// Inside a law: what it reads of memories at its point (LawSpec::readings), i < most_readings.
inline constexpr int most_readings = 4;
inline constexpr Slot reading(int i) { return 28 + i; }
/// Inside a law: the k-th state that it reads, k < most_law_states.
inline constexpr int most_law_states = 4;
inline constexpr Slot law_state(int k) { return 12 + k; }
/// The test function v.
inline constexpr Slot test(int derivative) { return 16 + derivative; }
/// Field k: 0 is u, 1 is u', 2 is u'', 3 + m is the m-th history field of the plan.
inline constexpr Slot field(int k, int derivative) {
  return first_field + field_stride * k + derivative;
}
/// Multiplier xi of the l-th law application, component c (in the global frame).
inline constexpr Slot multiplier(int l, int c) { return first_multiplier + 4 * l + c; }
/// 1 on part p of the plan, else 0 (a facet asks for itself, then for the cell behind it).
inline constexpr Slot inside(int p) { return first_inside + p; }
/// State i of the plan at the point (problem.hpp, StateTerm).
inline constexpr Slot state(int i) { return first_state + i; }
inline constexpr bool is_state(Slot s) { return s >= first_state && s < first_probe; }
/// The value of probe i of the report (combinations of probes).
inline constexpr Slot probe(int i) { return first_probe + i; }
} // namespace slot

} // namespace hvi::solver
