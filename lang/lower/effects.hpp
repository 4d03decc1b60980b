// The effects of the theory, and what became of each in this script: on, off or dropped.
#pragma once

#include "lang/check/model.hpp"
#include "solver/plan/problem.hpp"

#include <vector>

namespace hvi::lang {

/// Notes for viscosity, elasticity, memory, body force, traction and every law, in this order.
/// An effect that stands in the script but folds to zero is `dropped`, with its line.
std::vector<solver::EffectNote> effects(Model& model, const solver::Problem& problem);

/// Is it friction: a law of a vector that is no gradient?
bool rubs(const Model& model, const LawUse& use);

} // namespace hvi::lang
