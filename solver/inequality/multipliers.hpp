// The multipliers that stand for certain at a place of a search.
#pragma once

#include "solver/inequality/position.hpp"

namespace hvi::solver {

/// Of one point, at the present z: the slope inside a piece, xi clipped at a break.
Small certain_multiplier(const Position& at, int p);
/// Adds the residual of a resting point's own equations to its multiplier in `trial`, if the law
/// allows it; false: nothing changed.
bool balance_point(const Position& at, int p, const Vector& residual, Vector& trial);
/// The multipliers of all points in `trial`, and the worst componentwise ratio of the residual with
/// them. Points that rest and have their unknowns to themselves take what their equations leave
/// them, exactly. Updates S c and the snaps.
double certain_multipliers(Position& at, double snap_factor, Vector& trial);
/// The same, but where rounding of z hides which way a point slips, the search's own multiplier
/// stays if that is as near to the law as anybody can tell.
double likely_multipliers(Position& at, double snap_factor, Vector& trial);

} // namespace hvi::solver
