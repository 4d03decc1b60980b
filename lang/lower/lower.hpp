// Third phase: from the typed model to the engine's plan. Integrands are taken apart into entries
// test x trial, terms that fold to zero are dropped (and noted), effects get their names.
#pragma once

#include "lang/check/model.hpp"
#include "solver/plan/plan.hpp"

namespace hvi::lang {

/// The plan of a model. The model's table of origins grows by the plan's items.
solver::Plan lower(Model& model);

} // namespace hvi::lang
