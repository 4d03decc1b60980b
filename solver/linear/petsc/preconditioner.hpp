// What iterations on A = K + H are preconditioned by.
//
// All calls are made by all processes together; the first one is given K and H whole, the others
// none of them.
#pragma once

#include "solver/linear/petsc/few_rows.hpp"

#include <vector>

namespace hvi::petsc_module {

/// Of this process.
struct Effort {
  double bytes = 0.0, seconds_setup = 0.0;
  int local_factors = 0; ///< of the layers at the contact
  /// Of all processes, the finest one first.
  std::vector<HviPetscLevel> levels;
};

class Preconditioner {
public:
  virtual ~Preconditioner() = default;
  /// The entries of K have changed.
  virtual void matrix_changed() = 0;
  /// H from now on, whole and by process; both are kept by reference. `shift`: of the diagonal of
  /// K, added where A may be singular near the contact. False: A has no factor there.
  virtual bool set_laws(const Rows& h, const FewRows& rows, bool symmetric, double shift) = 0;
  /// With the softening of laws it may not be positive definite: has none of them on its levels
  /// until others are set. False: it had none.
  virtual bool leave_laws() = 0;
  /// For the entries that K has now; what was set up before serves until then.
  virtual void set_up() = 0;
  virtual PetscErrorCode apply(Vec r, Vec z) = 0;
  virtual Effort effort() const = 0; ///< so far
};

} // namespace hvi::petsc_module
