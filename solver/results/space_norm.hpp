// The norm of an unknown in its space.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/discretisation.hpp"

#include <vector>

namespace hvi::solver {

/// sqrt(int eps(u) : eps(u) dx) on the cells of an unknown (scalars: grad u . grad u, and u^2 where
/// no value is imposed, for then the gradients alone are no norm). Summed cell by cell: sqrt(u^T G
/// u) with the Gram matrix G would be the root of rounding in a body that all but moves rigidly.
class SpaceNorm {
public:
  SpaceNorm(const Discretisation& discretisation, int unknown);
  /// `u`: all dofs, those in `values`, too.
  double value(const Vector& u, const FieldValues& values) const;

private:
  const Space& space_;
  int unknown_;
  Region cells_;                    ///< whose strains are summed by `squares_of_strain`
  std::vector<Integrator> squares_; ///< what is added: values, and strains of bodies of revolution
};

} // namespace hvi::solver
