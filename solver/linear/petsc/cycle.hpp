// The preconditioner of one unknown: the multigrid of K and of what laws add where they are not
// stiffer than the body, and the layers at the contact before and after it where H is stiff there
// (layers.hpp).
#pragma once

#include "solver/linear/petsc/layers.hpp"
#include "solver/linear/petsc/multigrid.hpp"
#include "solver/linear/petsc/preconditioner.hpp"

#include <memory>
#include <vector>

namespace hvi::petsc_module {

class Cycle final : public Preconditioner {
public:
  /// `k` in the numbering of `distribution`; `matrix`: this process's rows of it, as are the
  /// `n_motions` columns of `motions`. All but these are kept by reference.
  Cycle(const Distribution& distribution, const WholeMatrix& k, Mat matrix,
        const std::vector<double>& motions, int n_motions);
  void matrix_changed() override;
  bool set_laws(const Rows& h, const FewRows& rows, bool symmetric, double shift) override;
  bool leave_laws() override;
  void set_up() override { multigrid_.set_up(); }
  PetscErrorCode apply(Vec r, Vec z) override;
  Effort effort() const override;

private:
  PetscErrorCode rest_near_laws(Vec r, Vec z) const;
  bool stiff(const Rows& h) const;
  Rows not_stiffer(const Rows& h, bool symmetric) const;
  void give_to_multigrid(const Rows& h);

  const Distribution& distribution_;
  const WholeMatrix& k_;
  Multigrid multigrid_;
  const FewRows* law_rows_ = nullptr;
  std::unique_ptr<Layers> layers_;
  bool in_layers_ = false; ///< are they solved exactly?
  int local_factors_ = 0;
  Owned<Vec> work_, rest_;
};

} // namespace hvi::petsc_module
