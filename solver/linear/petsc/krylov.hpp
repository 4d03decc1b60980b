// Conjugate gradients, or GMRES where a matrix is not symmetric, for (K + H) x = b.
//
// Each process has one of each solver, and all make the same calls. Only the first one is given H
// and b, and K where its rows are not dealt out; the others give empty ones.
#pragma once

#include "solver/linear/petsc/free_motions.hpp"
#include "solver/linear/petsc/several.hpp"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace hvi::petsc_module {

class Krylov {
public:
  /// `mine`: this process's rows of K, of which k has the number of all then; null: k is K.
  Krylov(const HviPetscMatrix& k, const HviPetscMatrix* mine, bool symmetric,
         const HviPetscUnknowns& unknowns);
  ~Krylov();
  Krylov(const Krylov&) = delete; // PETSc calls it
  Krylov& operator=(const Krylov&) = delete;
  void matrix_changed(const HviPetscMatrix* mine);
  /// Those that K leaves free.
  void set_free_motions(const double* motions, int count);
  /// False: the layers at the contact have no factor.
  bool set_laws(const HviPetscMatrix& h, bool symmetric);
  /// `watch` of the first process; null of the others.
  HviPetscAnswer solve(const double* b, double reduction, const HviPetscWatch* watch, double* x);
  HviPetscCounts counts() const;

private:
  static PetscErrorCode apply_matrix(Mat shell, Vec x, Vec y);
  static PetscErrorCode apply_weighted(Mat shell, Vec x, Vec y);
  static PetscErrorCode apply_preconditioner(PC shell, Vec r, Vec z);
  static PetscErrorCode judge(KSP ksp, PetscInt n, PetscReal norm, KSPConvergedReason* reason,
                              void* self);
  PetscErrorCode balanced(Vec r, Vec z);
  std::vector<double> in_own_numbering(const double* columns, int count) const;
  void prepare();
  void iterate();
  KSPConvergedReason reason() const;
  int iterations() const;
  HviPetscAnswer answer_of_method() const;
  WholeMatrix whole_matrix(bool is_dealt);
  HviPetscMatrix deal_matrix(Rows& room);
  void make_matrix(const HviPetscMatrix* mine);
  void make_shell(PetscErrorCode (*product)(Mat, Vec, Vec), Owned<Mat>& shell);
  void make_preconditioner(const HviPetscUnknowns& unknowns);
  void count();
  void choose_method();
  void note(const HviPetscAnswer& answer);
  double typical_diagonal() const;

  HviPetscMatrix given_; ///< K as the caller numbers it
  Numbering numbering_;
  Distribution distribution_;
  double diagonal_; ///< of rows without an unknown
  WholeMatrix k_;
  Rows mine_; ///< of K; a process that is alone gives PETSc these arrays
  Rows h_;    ///< whole
  FewRows law_rows_;
  bool symmetric_k_, symmetric_ = true;
  Owned<Mat> matrix_;
  Owned<Mat> shell_, weighted_; ///< A, and W A, W the weights
  std::unique_ptr<Preconditioner> preconditioner_;
  SeveralCycles* several_ = nullptr;  ///< the same; null: there is one unknown
  std::optional<View> all_;           ///< how the first process sees right-hand sides and solutions
  std::unique_ptr<FreeMotions> free_; ///< null: K holds the body
  bool free_known_ = false;           ///< are they solved exactly, for the laws at hand?
  bool free_stale_ = false;           ///< has A changed since?
  HviPetscCounts counts_{};
  std::vector<HviPetscLevel> levels_;
  std::array<double, 3> sent_{}; ///< by this process, of all iterations
  Owned<KSP> ksp_;
  void* default_test_ = nullptr; ///< PETSc's, of ksp_
  const HviPetscWatch* watch_ = nullptr;
  bool stopped_ = false; ///< by the watch
  Owned<Vec> b_, x_, weights_, unweighted_, unbalanced_;
  /// Iterations for each digit, since the multigrid was set up and of the last solve.
  double best_effort_ = 0.0, last_effort_ = 0.0;
  bool changed_ = false; ///< has K changed since the multigrid was set up?
};

} // namespace hvi::petsc_module
