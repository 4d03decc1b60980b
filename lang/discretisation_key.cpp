// See discretisation_key.hpp.
#include "lang/discretisation_key.hpp"

#include "solver/time/adapt.hpp"

namespace hvi::lang {

std::string discretisation_key(const solver::Plan& plan) {
  solver::Plan space;
  space.problem.mesh = plan.problem.mesh, space.problem.parts = plan.problem.parts,
  space.problem.space = plan.problem.space;
  std::string key = solver::to_string(space);
  if (plan.problem.mesh.adapted > 0) key += solver::adapted_key(plan);
  return key;
}

} // namespace hvi::lang
