// The preconditioner of several unknowns u, theta, ..., each with a cycle of its own.
//
// With A_ba the entries of the rows of unknown b in the columns of a, one after the other
//
//   z_b = C_b (r_b - sum_{a before b} A_ba z_a)
//
// (block Gauss-Seidel), C_b the cycle of K_bb with the diagonal that the elimination of those
// before it leaves (elimination.hpp).
#pragma once

#include "solver/linear/petsc/cycle.hpp"
#include "solver/linear/petsc/elimination.hpp"

#include <memory>
#include <vector>

namespace hvi::petsc_module {

class SeveralCycles final : public Preconditioner {
public:
  /// `first_component`: of each unknown, and the number of all; of the first process. `k`: this
  /// process's rows of K. `product`: A, whose products are asked for. `motions` as for Cycle. All
  /// but these and the numbering are kept by reference.
  SeveralCycles(const Distribution& distribution, const Numbering& numbering,
                const std::vector<int>& first_component, Mat k, Mat product,
                const std::vector<double>& motions, int n_motions);
  ~SeveralCycles() override;
  void matrix_changed() override;
  bool set_laws(const Rows& h, const FewRows& rows, bool symmetric, double shift) override;
  bool leave_laws() override;
  void set_up() override;
  PetscErrorCode apply(Vec r, Vec z) override;
  Effort effort() const override;

  /// By row of this process what makes residuals of all unknowns, whose units differ, and of rows
  /// of any stiffness alike, where the right-hand side is b: the root of 1 / (A_ii times the energy
  /// of its unknown in b).
  void weigh(Vec b, Vec weights) const;

private:
  struct Unknown;
  const Distribution& distribution_;
  Mat k_, product_;
  std::vector<std::unique_ptr<Unknown>> unknowns_; ///< as they are eliminated
  UnknownRows rows_;
  Owned<Vec> moved_, rest_;
};

} // namespace hvi::petsc_module
