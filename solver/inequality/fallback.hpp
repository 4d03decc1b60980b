// The globally convergent method on fixed components (fallback.cpp).
#pragma once

#include "solver/inequality/active_set.hpp"
#include "solver/inequality/last_factor.hpp"

namespace hvi::solver {

/// `newton` finishes what the method comes close to. A vast number of iterations at times.
MethodOutcome solve_globally(Position& at, LastFactor& factor, ActiveSetNewton& newton,
                             const InequalityOptions& options, InequalityReport& report);

/// The same on all components at once, with each law split into what rises and what falls
/// (rise_and_fall.hpp): the energy does not rise however steeply a law falls, and whatever it
/// jumps.
MethodOutcome solve_by_falls(Position& at, LastFactor& factor, ActiveSetNewton& newton,
                             const InequalityOptions& options, InequalityReport& report);

} // namespace hvi::solver
