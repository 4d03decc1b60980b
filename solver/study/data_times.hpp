// What the data do in time, read from their formulas: where loads, imposed values, offsets, laws
// and kernels jump or have a kink, and how short the pieces of time are on which they vary little.
// A grid made of these times resolves a pulse that would lie between two steps of another grid and
// that no run on that grid would show.
#pragma once

#include "solver/plan/problem.hpp"

#include <vector>

namespace hvi::solver {

/// A time at which the data are not smooth.
struct DataBreak {
  double t = 0.0;
  bool jump = false;    ///< the value jumps; else its slope does
  bool imposed = false; ///< of an imposed value: the solution itself follows
};

struct DataTimes {
  std::vector<DataBreak> breaks; ///< sorted, inside (t_0, T]; at T only jumps
  /// t_0 < ... < T, the breaks among them: between two of them no part of the data varies by more
  /// than half its range, by interval bounds of the value and of the slope.
  std::vector<double> pieces;
  /// False: a function has no interval rule, or there are more pieces than are kept.
  bool complete = true;
};

/// Parts of the data smaller than `negligible` times the largest of their kind are left out.
/// Functions of x and t that do not separate are looked at at a few points of the mesh.
DataTimes data_times(const Problem& problem, double negligible);

/// How far from a jump, relative to T - t_0, the times lie that stand for its two sides.
inline constexpr double beside_a_jump = 1e-9;

} // namespace hvi::solver
