// See krylov.hpp.
#include "solver/linear/petsc/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::petsc_module {
namespace {

constexpr int most_iterations = 1000;
/// GMRES keeps two vectors for each iteration until it begins anew: as many as this memory of a
/// process holds, but at least and at most so many.
constexpr double bytes_of_vectors = 1e8;
constexpr int least_restart = 60, most_restart = 300;
/// After so many iterations several processes agree whether to stop: that is a message to all.
constexpr int between_looks = 8;
/// An old multigrid is given up when it takes so many times the iterations for a digit.
constexpr double too_slow = 1.5;
/// The layers of a body that laws alone hold are almost singular: of K's diagonal, added to it.
constexpr double layer_shift = 1e-6;

int restart_of(double rows) {
  const double fit = bytes_of_vectors / (2.0 * sizeof(double) * std::max(rows, 1.0));
  return static_cast<int>(std::clamp<double>(fit, least_restart, most_restart));
}

/// PETSc's reason, and what it means.
const char* in_words(KSPConvergedReason reason) {
  switch (reason) {
  case KSP_DIVERGED_ITS:
    return "the most iterations were reached (DIVERGED_ITS)";
  case KSP_DIVERGED_DTOL:
    return "the residual grows (DIVERGED_DTOL)";
  case KSP_DIVERGED_BREAKDOWN:
    return "the directions of the search ended (DIVERGED_BREAKDOWN)";
  case KSP_DIVERGED_INDEFINITE_PC:
    return "the multigrid is not positive definite (DIVERGED_INDEFINITE_PC)";
  case KSP_DIVERGED_INDEFINITE_MAT:
    return "the matrix is not positive definite (DIVERGED_INDEFINITE_MAT)";
  case KSP_DIVERGED_NANORINF:
    return "numbers became infinite (DIVERGED_NANORINF)";
  case KSP_DIVERGED_PC_FAILED:
    return "the multigrid failed (DIVERGED_PC_FAILED)";
  default:
    return reason > 0 ? "solved" : "PETSc's solver broke down";
  }
}

} // namespace

Krylov::Krylov(const HviPetscMatrix& k, const HviPetscMatrix* mine, bool symmetric,
               const HviPetscUnknowns& unknowns)
    : given_(k), numbering_(unknowns, k.rows, partition_of(k, unknowns, processes())),
      distribution_(numbering_), diagonal_(mine == nullptr ? typical_diagonal() : 0.0),
      k_(whole_matrix(mine != nullptr)),
      symmetric_k_(symmetric && distribution_.of_first(unknowns.unknowns) == 1),
      symmetric_(symmetric_k_) {
  make_matrix(mine);
  h_.start.assign(static_cast<std::size_t>(numbering_.size()) + 1, 0);
  make_shell(&Krylov::apply_matrix, shell_);
  check(MatCreateVecs(matrix_.get(), b_.put(), x_.put()));
  check(VecDuplicate(b_.get(), unbalanced_.put()));
  all_.emplace(distribution_, b_.get());
  make_preconditioner(unknowns);
  choose_method();
  count();
}

void Krylov::make_shell(PetscErrorCode (*product)(Mat, Vec, Vec), Owned<Mat>& shell) {
  const PetscInt n = distribution_.rows(), all = distribution_.all_rows();
  check(MatCreateShell(distribution_.comm(), n, n, all, all, this, shell.put()));
  check(MatShellSetOperation(shell.get(), MATOP_MULT, reinterpret_cast<void (*)()>(product)));
}

void Krylov::make_preconditioner(const HviPetscUnknowns& unknowns) {
  const int n_motions = distribution_.of_first(unknowns.n_motions);
  const std::vector<double> motions = in_own_numbering(unknowns.motions, n_motions);
  if (distribution_.of_first(unknowns.unknowns) == 1) {
    preconditioner_ = std::make_unique<Cycle>(distribution_, k_, matrix_.get(), motions, n_motions);
    return;
  }
  std::vector<int> first(unknowns.first_component, unknowns.first_component + unknowns.unknowns);
  first.push_back(unknowns.components);
  auto several = std::make_unique<SeveralCycles>(distribution_, numbering_, first, matrix_.get(),
                                                 shell_.get(), motions, n_motions);
  several_ = several.get();
  preconditioner_ = std::move(several);
  make_shell(&Krylov::apply_weighted, weighted_);
  check(VecDuplicate(b_.get(), weights_.put()));
  check(VecDuplicate(b_.get(), unweighted_.put()));
}

std::vector<double> Krylov::in_own_numbering(const double* columns, int count) const {
  std::vector<double> out(static_cast<std::size_t>(numbering_.size()) *
                          static_cast<std::size_t>(count));
  for (int m = 0; m < count; ++m) {
    const double* from = columns + static_cast<std::ptrdiff_t>(m) * given_.rows;
    double* to = out.data() + static_cast<std::ptrdiff_t>(m) * numbering_.size();
    numbering_.spread(from, to);
  }
  return distribution_.deal(std::move(out), count);
}

double Krylov::typical_diagonal() const {
  double most = 0.0;
  for (int i = 0; i < given_.rows; ++i)
    for (int e = given_.start[i]; e < given_.start[i + 1]; ++e)
      if (given_.column[e] == i) most = std::max(most, std::abs(given_.value[e]));
  return most > 0.0 ? most : 1.0;
}

WholeMatrix Krylov::whole_matrix(bool is_dealt) {
  if (!is_dealt) return {given_, numbering_, diagonal_};
  return {numbering_.size(), [this](const std::vector<int>& named) {
            return distribution_.fetch(named, matrix_.get());
          }};
}

/// This process's rows of K, in `room` where PETSc copies them.
HviPetscMatrix Krylov::deal_matrix(Rows& room) {
  const HviPetscMatrix mine = distribution_.deal(k_, room);
  if (!distribution_.alone() || k_.as_it_is() != nullptr) return mine;
  if (mine_.size() == mine.rows) // PETSc reads these arrays
    std::copy(room.value.begin(), room.value.end(), mine_.value.begin());
  else
    mine_ = std::move(room);
  return mine_.view();
}

void Krylov::make_matrix(const HviPetscMatrix* mine) {
  Rows room;
  distribution_.make(mine != nullptr ? *mine : deal_matrix(room), matrix_);
  check(MatSetOption(matrix_.get(), symmetric_k_ ? MAT_SPD : MAT_SYMMETRIC,
                     symmetric_k_ ? PETSC_TRUE : PETSC_FALSE));
}

void Krylov::matrix_changed(const HviPetscMatrix* mine) {
  Rows room;
  distribution_.refresh(mine != nullptr ? *mine : deal_matrix(room), matrix_.get());
  k_.changed();
  preconditioner_->matrix_changed();
  changed_ = free_stale_ = true;
}

void Krylov::set_free_motions(const double* motions, int count) {
  free_ = std::make_unique<FreeMotions>(distribution_, in_own_numbering(motions, count), count);
  free_stale_ = true;
  this->count();
}

bool Krylov::set_laws(const HviPetscMatrix& h, bool symmetric) {
  const bool other_method = symmetric_ != (symmetric && symmetric_k_);
  symmetric_ = symmetric && symmetric_k_;
  h_ = WholeMatrix(h, numbering_, 0.0).part(0, numbering_.size());
  law_rows_.set(distribution_, b_.get(), h_.view());
  free_stale_ = true;
  if (other_method) choose_method();
  const bool there =
      preconditioner_->set_laws(h_, law_rows_, symmetric_, free_ ? layer_shift : 0.0);
  count();
  return there;
}

void Krylov::choose_method() {
  check(KSPCreate(distribution_.comm(), ksp_.put()));
  if (default_test_ == nullptr) check(KSPConvergedDefaultCreate(&default_test_));
  check(KSPSetConvergenceTest(ksp_.get(), &Krylov::judge, this, nullptr));
  const Mat matrix = several_ != nullptr ? weighted_.get() : shell_.get();
  check(KSPSetOperators(ksp_.get(), matrix, matrix));
  check(KSPSetType(ksp_.get(), symmetric_ ? KSPCG : several_ != nullptr ? KSPFGMRES : KSPGMRES));
  if (!symmetric_) {
    const double rows = 1.0 * distribution_.all_rows() / processes();
    check(KSPGMRESSetRestart(ksp_.get(), restart_of(rows)));
    // Once is too little where hundreds of vectors are kept: they are no longer at right angles.
    check(KSPGMRESSetCGSRefinementType(ksp_.get(), KSP_GMRES_CGS_REFINE_IFNEEDED));
    check(KSPSetPCSide(ksp_.get(), PC_RIGHT));
  }
  check(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED));
  PC shell = nullptr;
  check(KSPGetPC(ksp_.get(), &shell));
  check(PCSetType(shell, PCSHELL));
  check(PCShellSetContext(shell, this));
  check(PCShellSetApply(shell, &Krylov::apply_preconditioner));
}

Krylov::~Krylov() {
  if (default_test_ != nullptr) static_cast<void>(KSPConvergedDefaultDestroy(default_test_));
}

/// PETSc's own test; where that goes on, all processes end with an iteration after which the first
/// one is asked to stop.
PetscErrorCode Krylov::judge(KSP ksp, PetscInt n, PetscReal norm, KSPConvergedReason* reason,
                             void* self) {
  Krylov& of = *static_cast<Krylov*>(self);
  PetscCall(KSPConvergedDefault(ksp, n, norm, reason, of.default_test_));
  if (*reason != KSP_CONVERGED_ITERATING) return 0;
  if (!of.distribution_.alone() && n % between_looks != 0) return 0;
  const bool asked = of.watch_ != nullptr && of.watch_->stop(of.watch_->context) != 0;
  of.stopped_ = of.distribution_.of_first(asked ? 1 : 0) != 0;
  if (of.stopped_) *reason = KSP_DIVERGED_BREAKDOWN;
  return 0;
}

PetscErrorCode Krylov::apply_matrix(Mat shell, Vec x, Vec y) {
  void* self = nullptr;
  PetscCall(MatShellGetContext(shell, &self));
  const Krylov& of = *static_cast<const Krylov*>(self);
  PetscCall(MatMult(of.matrix_.get(), x, y));
  return of.law_rows_.add_product(1.0, x, y);
}

PetscErrorCode Krylov::apply_weighted(Mat shell, Vec x, Vec y) {
  PetscCall(apply_matrix(shell, x, y));
  void* self = nullptr;
  PetscCall(MatShellGetContext(shell, &self));
  return VecPointwiseMult(y, y, static_cast<const Krylov*>(self)->weights_.get());
}

PetscErrorCode Krylov::apply_preconditioner(PC shell, Vec r, Vec z) {
  void* self = nullptr;
  PetscCall(PCShellGetContext(shell, &self));
  Krylov& of = *static_cast<Krylov*>(self);
  if (of.several_ == nullptr) return of.balanced(r, z);
  PetscCall(VecPointwiseDivide(of.unweighted_.get(), r, of.weights_.get())); // 0 / 0 = 0
  return of.balanced(of.unweighted_.get(), z);
}

PetscErrorCode Krylov::balanced(Vec r, Vec z) {
  if (!free_known_) return preconditioner_->apply(r, z);
  PetscCall(free_->remove(r, unbalanced_.get()));
  PetscCall(preconditioner_->apply(unbalanced_.get(), z));
  return free_->add(symmetric_, z);
}

/// The multigrid is set up when it is asked for, and again when it has become too old.
void Krylov::prepare() {
  if (counts_.setups == 0 || (changed_ && last_effort_ > too_slow * best_effort_)) {
    preconditioner_->set_up();
    ++counts_.setups;
    changed_ = false, best_effort_ = last_effort_ = 0.0;
    count();
  }
  if (free_stale_) free_known_ = free_ && free_->factor(shell_.get());
  free_stale_ = false;
}

HviPetscAnswer Krylov::solve(const double* b, double reduction, const HviPetscWatch* watch,
                             double* x) {
  watch_ = watch, stopped_ = false;
  prepare();
  if (free_ && !free_known_) {
    std::fill_n(x, given_.rows, 0.0);
    HviPetscAnswer none{};
    none.reason = "the laws leave a motion of the body free";
    none.reduction = 1.0;
    none.outcome = hvi_petsc_indefinite;
    return none;
  }
  double* to = nullptr;
  check(all_->write(b_.get(), &to));
  numbering_.spread(b, to);
  check(all_->put(b_.get(), &to));
  double size = 0.0; // squares of sizes may be beyond any number
  check(VecNorm(b_.get(), NORM_INFINITY, &size));
  if (size > 0.0) check(VecScale(b_.get(), 1.0 / size));
  if (several_ != nullptr) {
    several_->weigh(b_.get(), weights_.get());
    check(VecPointwiseMult(b_.get(), b_.get(), weights_.get()));
  }
  check(KSPSetTolerances(ksp_.get(), reduction, 1e-300, 1e30, most_iterations));
  iterate();
  int before = 0;
  if (reason() == KSP_DIVERGED_INDEFINITE_PC && preconditioner_->leave_laws()) {
    before = iterations();
    iterate();
  }
  check(VecScale(x_.get(), size));
  const double* found = nullptr;
  check(all_->read(x_.get(), &found));
  numbering_.collect(found, x);
  check(all_->done(x_.get(), &found));
  HviPetscAnswer out = answer_of_method();
  note(out);
  out.iterations += before;
  return out;
}

void Krylov::iterate() {
  const std::array<double, 3> before = sent();
  check(KSPSolve(ksp_.get(), b_.get(), x_.get()));
  const std::array<double, 3> after = sent();
  for (std::size_t i = 0; i < sent_.size(); ++i) sent_[i] += after[i] - before[i];
  std::array<double, 3> most = sent_;
  distribution_.largest(most.data(), static_cast<int>(most.size()));
  counts_.messages = most[0], counts_.bytes_sent = most[1], counts_.reductions = most[2];
}

KSPConvergedReason Krylov::reason() const {
  KSPConvergedReason out = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_.get(), &out));
  return out;
}

int Krylov::iterations() const {
  PetscInt out = 0;
  check(KSPGetIterationNumber(ksp_.get(), &out));
  return out;
}

HviPetscAnswer Krylov::answer_of_method() const {
  HviPetscAnswer out{};
  const KSPConvergedReason reason = this->reason();
  double left = 0.0, size = 0.0;
  out.reason = in_words(reason);
  check(KSPGetResidualNorm(ksp_.get(), &left));
  check(VecNorm(b_.get(), NORM_2, &size));
  out.iterations = iterations();
  out.reduction = size > 0.0 ? left / size : 0.0;
  out.outcome = stopped_                                ? hvi_petsc_stopped
                : reason > 0                            ? hvi_petsc_solved
                : reason == KSP_DIVERGED_INDEFINITE_MAT ? hvi_petsc_indefinite
                                                        : hvi_petsc_stagnated;
  return out;
}

/// What a digit costs; without the layers of stiff laws it says whether the multigrid is too old.
void Krylov::note(const HviPetscAnswer& answer) {
  if (answer.iterations < 3 || !(answer.reduction < 0.5)) return;
  last_effort_ = answer.iterations / -std::log10(std::max(answer.reduction, 1e-300));
  if (best_effort_ == 0.0 || !changed_) best_effort_ = std::max(best_effort_, last_effort_);
}

/// Bytes of all processes, seconds of this one.
void Krylov::count() {
  const Effort effort = preconditioner_->effort();
  double bytes = effort.bytes + law_rows_.bytes() +
                 12.0 * static_cast<double>(mine_.column.size()) +
                 distribution_.copied_bytes(matrix_.get()) + 8.0 * 12.0 * distribution_.rows();
  if (free_) bytes += free_->bytes();
  counts_.bytes = distribution_.sum(bytes);
  counts_.bytes_of_others = distribution_.largest(distribution_.is_first() ? 0.0 : most_held());
  counts_.seconds_setup = effort.seconds_setup, counts_.local_factors = effort.local_factors;
  levels_ = effort.levels;
}

HviPetscCounts Krylov::counts() const {
  HviPetscCounts out = counts_;
  out.levels = static_cast<int>(levels_.size()), out.level = levels_.data();
  return out;
}

} // namespace hvi::petsc_module
