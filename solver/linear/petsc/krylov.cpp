// See krylov.hpp.
#include "solver/linear/petsc/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::petsc_module {
namespace {

constexpr int most_iterations = 1000;
/// GMRES keeps a vector for each iteration until it begins anew.
constexpr int restart = 60;
/// Laws whose stiffness is beyond this part of the body's are solved exactly with their layers.
constexpr double stiff_part = 0.5;
/// An old multigrid is given up when it takes so many times the iterations for a digit.
constexpr double too_slow = 1.5;
/// The layers of a body that laws alone hold are almost singular: of K's diagonal, added to it.
constexpr double layer_shift = 1e-6;

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

Krylov::Krylov(const HviPetscMatrix& k, bool symmetric, const HviPetscUnknowns& unknowns)
    : given_(k), numbering_(unknowns, k.rows, partition_of(k, unknowns, processes())),
      distribution_(numbering_), diagonal_(typical_diagonal()), k_(k), symmetric_k_(symmetric),
      symmetric_(symmetric) {
  make_matrix();
  const int n_motions = distribution_.of_first(unknowns.n_motions);
  multigrid_.emplace(matrix_.get(), in_own_numbering(unknowns.motions, n_motions), n_motions);
  h_.start.assign(static_cast<std::size_t>(numbering_.size()) + 1, 0);
  const PetscInt n = distribution_.rows(), all = distribution_.all_rows();
  check(MatCreateShell(distribution_.comm(), n, n, all, all, this, shell_.put()));
  check(MatShellSetOperation(shell_.get(), MATOP_MULT,
                             reinterpret_cast<void (*)()>(&Krylov::apply_matrix)));
  check(MatCreateVecs(matrix_.get(), b_.put(), x_.put()));
  check(VecDuplicate(b_.get(), work_.put()));
  check(VecDuplicate(b_.get(), rest_.put()));
  check(VecDuplicate(b_.get(), unbalanced_.put()));
  all_.emplace(distribution_, b_.get());
  choose_method();
  count();
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

void Krylov::make_matrix() {
  if (!numbering_.same()) {
    own_ = numbering_.rows_of(given_, diagonal_);
    k_ = {own_.size(), own_.start.data(), own_.column.data(), own_.value.data()};
  }
  Rows mine;
  distribution_.make(distribution_.deal(k_, mine), matrix_);
  check(MatSetOption(matrix_.get(), symmetric_k_ ? MAT_SPD : MAT_SYMMETRIC,
                     symmetric_k_ ? PETSC_TRUE : PETSC_FALSE));
}

void Krylov::matrix_changed() {
  if (!numbering_.same()) numbering_.refresh(given_, diagonal_, own_);
  Rows mine;
  distribution_.refresh(distribution_.deal(k_, mine), matrix_.get());
  if (layers_) layers_->matrix_changed(b_.get());
  changed_ = free_stale_ = true;
}

void Krylov::set_free_motions(const double* motions, int count) {
  free_ = std::make_unique<FreeMotions>(distribution_, in_own_numbering(motions, count), count);
  free_stale_ = true;
  this->count();
}

bool Krylov::stiff() const {
  const Rows& h = h_;
  for (int i = 0; i < h.size(); ++i) {
    if (h.start[i] == h.start[i + 1]) continue;
    double own = 0.0, law = 0.0;
    for (int e = k_.start[i]; e < k_.start[i + 1]; ++e)
      if (k_.column[e] == i) own = std::abs(k_.value[e]);
    for (int e = h.start[i]; e < h.start[i + 1]; ++e) law += std::abs(h.value[e]);
    if (law > stiff_part * own) return true;
  }
  return false;
}

bool Krylov::set_laws(const HviPetscMatrix& h, bool symmetric) {
  const bool other_method = symmetric_ != (symmetric && symmetric_k_);
  symmetric_ = symmetric && symmetric_k_;
  h_ = numbering_.rows_of(h, 0.0);
  law_rows_.set(distribution_, b_.get(), h_.view());
  free_stale_ = true;
  if (other_method) choose_method();
  in_layers_ = distribution_.of_first(stiff());
  if (!in_layers_) return true;
  if (distribution_.of_first(!layers_ || !layers_->fit(h_)))
    layers_ = std::make_unique<Layers>(distribution_, b_.get(), k_, h_);
  in_layers_ = layers_->factor(h_, symmetric_, free_ ? layer_shift : 0.0);
  ++counts_.local_factors;
  count();
  return in_layers_;
}

void Krylov::choose_method() {
  check(KSPCreate(distribution_.comm(), ksp_.put()));
  check(KSPSetOperators(ksp_.get(), shell_.get(), shell_.get()));
  check(KSPSetType(ksp_.get(), symmetric_ ? KSPCG : KSPGMRES));
  if (!symmetric_) {
    check(KSPGMRESSetRestart(ksp_.get(), restart));
    check(KSPSetPCSide(ksp_.get(), PC_RIGHT));
  }
  check(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED));
  PC shell = nullptr;
  check(KSPGetPC(ksp_.get(), &shell));
  check(PCSetType(shell, PCSHELL));
  check(PCShellSetContext(shell, this));
  check(PCShellSetApply(shell, &Krylov::apply_preconditioner));
}

PetscErrorCode Krylov::apply_matrix(Mat shell, Vec x, Vec y) {
  void* self = nullptr;
  PetscCall(MatShellGetContext(shell, &self));
  const Krylov& of = *static_cast<const Krylov*>(self);
  PetscCall(MatMult(of.matrix_.get(), x, y));
  return of.law_rows_.add_product(1.0, x, y);
}

PetscErrorCode Krylov::apply_preconditioner(PC shell, Vec r, Vec z) {
  void* self = nullptr;
  PetscCall(PCShellGetContext(shell, &self));
  return static_cast<Krylov*>(self)->balanced(r, z);
}

PetscErrorCode Krylov::balanced(Vec r, Vec z) {
  if (!free_known_) return precondition(r, z);
  PetscCall(free_->remove(r, unbalanced_.get()));
  PetscCall(precondition(unbalanced_.get(), z));
  return free_->add(symmetric_, z);
}

/// As in layers.hpp.
PetscErrorCode Krylov::precondition(Vec r, Vec z) const {
  if (!in_layers_) return multigrid_->apply(r, z);
  const Vec rest = rest_.get(), work = work_.get();
  PetscCall(VecSet(z, 0.0));
  PetscCall(layers_->add_solved(r, z));
  PetscCall(rest_near_laws(r, z));
  PetscCall(multigrid_->apply(rest, work));
  PetscCall(VecAXPY(z, 1.0, work));
  PetscCall(rest_near_laws(r, z));
  return layers_->add_solved(rest, z);
}

/// r - (K + H) z, right where laws act and next to it.
PetscErrorCode Krylov::rest_near_laws(Vec r, Vec z) const {
  PetscCall(VecCopy(r, rest_.get()));
  PetscCall(layers_->subtract_product(z, rest_.get()));
  return law_rows_.add_product(-1.0, z, rest_.get());
}

/// The multigrid is set up when it is asked for, and again when it has become too old.
void Krylov::prepare() {
  if (multigrid_->setups == 0 || (changed_ && last_effort_ > too_slow * best_effort_)) {
    multigrid_->set_up();
    changed_ = false, best_effort_ = last_effort_ = 0.0;
    count();
  }
  if (free_stale_) free_known_ = free_ && free_->factor(shell_.get());
  free_stale_ = false;
}

HviPetscAnswer Krylov::solve(const double* b, double reduction, double* x) {
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
  check(KSPSetTolerances(ksp_.get(), reduction, 1e-300, 1e30, most_iterations));
  check(KSPSolve(ksp_.get(), b_.get(), x_.get()));
  check(VecScale(x_.get(), size));
  const double* found = nullptr;
  check(all_->read(x_.get(), &found));
  numbering_.collect(found, x);
  check(all_->done(x_.get(), &found));
  const HviPetscAnswer out = answer_of_method();
  note(out);
  return out;
}

HviPetscAnswer Krylov::answer_of_method() const {
  HviPetscAnswer out{};
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  double left = 0.0, size = 0.0;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  out.reason = in_words(reason);
  check(KSPGetIterationNumber(ksp_.get(), &iterations));
  check(KSPGetResidualNorm(ksp_.get(), &left));
  check(VecNorm(b_.get(), NORM_2, &size));
  out.iterations = iterations;
  out.reduction = size > 0.0 ? left / size : 0.0;
  out.outcome = reason > 0                              ? hvi_petsc_solved
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
  double bytes = multigrid_->bytes() + law_rows_.bytes() +
                 12.0 * static_cast<double>(own_.column.size()) +
                 distribution_.copied_bytes(matrix_.get()) + 8.0 * 12.0 * distribution_.rows();
  if (layers_) bytes += layers_->bytes();
  if (free_) bytes += free_->bytes();
  counts_.bytes = distribution_.sum(bytes);
  counts_.bytes_of_others = distribution_.largest(distribution_.is_first() ? 0.0 : most_held());
  counts_.setups = multigrid_->setups, counts_.seconds_setup = multigrid_->seconds;
}

} // namespace hvi::petsc_module
