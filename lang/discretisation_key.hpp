// Which plans have the same mesh, parts and space, so that runs of them can share a Discretisation.
#pragma once

#include "solver/plan/plan.hpp"

#include <string>

namespace hvi::lang {

/// Equal for plans with the same mesh, parts and space. What mesh files hold is not in it.
std::string discretisation_key(const solver::Plan& plan);

} // namespace hvi::lang
