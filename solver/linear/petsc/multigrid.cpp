// See multigrid.hpp.
#include "solver/linear/petsc/multigrid.hpp"

#include <algorithm>
#include <ctime>

namespace hvi::petsc_module {
namespace {

double cpu_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void option(const char* name, const char* value) {
  check(PetscOptionsSetValue(nullptr, name, value));
}

/// Smoothers: Chebyshev polynomials of the Jacobi method, which are symmetric, so that conjugate
/// gradients may use the cycle. The coarsest level is solved exactly, by singular values: small
/// aggregates leave rows of zeros there, and bodies that laws alone hold all but those.
void set_options() {
  option("-hvi_pc_gamg_type", "agg");
  option("-hvi_pc_gamg_agg_nsmooths", "1");
  option("-hvi_pc_gamg_threshold", "0.0");
  option("-hvi_pc_gamg_coarse_eq_limit", "100");
  option("-hvi_mg_coarse_pc_type", "svd");
  option("-hvi_mg_levels_ksp_type", "chebyshev");
  option("-hvi_mg_levels_ksp_max_it", "2");
  option("-hvi_mg_levels_pc_type", "jacobi");
}

/// From the third level on a step of the smoother more on each than on the one before it. These
/// levels are small, and with the same number of steps on all iterations grow with the number of
/// levels (J. H. Bramble, J. E. Pasciak and J. Xu, The analysis of multigrid algorithms for
/// nonsymmetric and indefinite elliptic problems, 1988: the variable V-cycle).
void smooth_small_levels_more(PC multigrid) {
  PetscInt levels = 0, steps = 0;
  check(PCMGGetLevels(multigrid, &levels));
  for (PetscInt l = levels - 3; l > 0; --l) {
    KSP before = nullptr, smoother = nullptr;
    check(PCMGGetSmoother(multigrid, l + 1, &before));
    check(PCMGGetSmoother(multigrid, l, &smoother));
    check(KSPGetTolerances(before, nullptr, nullptr, nullptr, &steps));
    check(KSPSetTolerances(smoother, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, steps + 1));
  }
}

} // namespace

Multigrid::Multigrid(Mat k, const std::vector<double>& motions, int n_motions) : k_(k) {
  PetscInt n = 0;
  check(MatGetLocalSize(k, &n, nullptr));
  if (n_motions > 0) {
    std::vector<Vec> columns(static_cast<std::size_t>(n_motions));
    check(MatCreateVecs(k, &columns[0], nullptr));
    for (std::size_t m = 1; m < columns.size(); ++m) check(VecDuplicate(columns[0], &columns[m]));
    for (std::size_t m = 0; m < columns.size(); ++m) {
      double* to = nullptr;
      check(VecGetArrayWrite(columns[m], &to));
      std::copy_n(motions.data() + m * static_cast<std::size_t>(n), n, to);
      check(VecRestoreArrayWrite(columns[m], &to));
    }
    // One after the other orthonormal, as a null space has to be.
    for (std::size_t m = 0; m < columns.size(); ++m) {
      for (int twice = 0; twice < 2; ++twice)
        for (std::size_t before = 0; before < m; ++before) {
          double product = 0.0;
          check(VecDot(columns[m], columns[before], &product));
          check(VecAXPY(columns[m], -product, columns[before]));
        }
      check(VecNormalize(columns[m], nullptr));
    }
    MatNullSpace space = nullptr;
    check(MatNullSpaceCreate(world(), PETSC_FALSE, n_motions, columns.data(), &space));
    check(MatSetNearNullSpace(k, space));
    check(MatNullSpaceDestroy(&space));
    for (Vec& column : columns) check(VecDestroy(&column));
  }
}

void Multigrid::set_up() {
  const double begin = cpu_now();
  set_options();
  check(PCCreate(world(), pc_.put()));
  check(PCSetType(pc_.get(), PCGAMG));
  check(PCSetOptionsPrefix(pc_.get(), "hvi_"));
  check(PCSetOperators(pc_.get(), k_, k_));
  check(PCSetFromOptions(pc_.get()));
  check(PCSetUp(pc_.get()));
  smooth_small_levels_more(pc_.get());
  check(PCSetReusePreconditioner(pc_.get(), PETSC_TRUE)); // until the next call, whatever K becomes
  single_.clear();
  laws_.forget_levels();
  measure();
  read_less();
  spread_laws();
  seconds += cpu_now() - begin;
}

void Multigrid::measure() {
  PetscInt count = 0;
  check(PCMGGetLevels(pc_.get(), &count));
  levels_.clear();
  for (PetscInt l = count - 1; l >= 0; --l) {
    KSP smoother = nullptr;
    Mat a = nullptr;
    PetscInt rows = 0;
    MatInfo info{};
    check(PCMGGetSmoother(pc_.get(), l, &smoother));
    check(KSPGetOperators(smoother, &a, nullptr));
    check(MatGetSize(a, &rows, nullptr));
    check(MatGetInfo(a, MAT_GLOBAL_SUM, &info));
    levels_.push_back({static_cast<double>(rows), info.nz_used});
  }
}

/// Of the rows of each level: products of several processes forget them, interpolations do not.
std::vector<PetscInt> Multigrid::block_sizes() const {
  PetscInt levels = 0;
  check(PCMGGetLevels(pc_.get(), &levels));
  std::vector<PetscInt> out(static_cast<std::size_t>(levels), 1);
  check(MatGetBlockSize(k_, &out.back()));
  for (PetscInt l = 1; l < levels; ++l) {
    Mat p = nullptr;
    check(PCMGGetInterpolation(pc_.get(), l, &p));
    check(MatGetBlockSizes(p, nullptr, &out[l - 1]));
  }
  return out;
}

/// The matrices of all levels but the coarsest in single precision; those that PETSc made end.
void Multigrid::read_less() {
  const std::vector<PetscInt> block = block_sizes();
  for (std::size_t level = block.size() - 1; level > 0; --level) {
    const PetscInt l = static_cast<PetscInt>(level);
    KSP smoother = nullptr;
    Mat a = nullptr, p = nullptr;
    check(PCMGGetSmoother(pc_.get(), l, &smoother));
    check(KSPGetOperators(smoother, &a, nullptr));
    check(PCMGGetInterpolation(pc_.get(), l, &p));
    if (a != k_) check(MatProductClear(a)); // what P^T A P was formed with
    SingleLevel& single = single_.emplace_back();
    single.matrix = std::make_unique<SingleMatrix>(a, block[level], block[level]);
    single.interpolation = std::make_unique<SingleMatrix>(p, block[level], block[level - 1]);
    const Mat matrix = single.matrix->shell(), interpolation = single.interpolation->shell();
    check(KSPSetOperators(smoother, matrix, matrix));
    check(PCMGSetResidual(pc_.get(), l, PCMGResidualDefault, matrix));
    check(PCMGSetInterpolation(pc_.get(), l, interpolation));
    check(PCMGSetRestriction(pc_.get(), l, interpolation));
  }
  KSP smoother = nullptr;
  Mat a = nullptr;
  check(PCMGGetSmoother(pc_.get(), 0, &smoother));
  check(KSPGetOperators(smoother, &a, nullptr));
  check(MatDuplicate(a, MAT_COPY_VALUES, coarsest_.put()));
}

void Multigrid::set_laws(const Distribution& distribution, const HviPetscMatrix& h) {
  laws_.set(distribution, h);
  if (pc_) spread_laws();
}

bool Multigrid::leave_laws() {
  if (!laws_.leave()) return false;
  spread_laws();
  return true;
}

void Multigrid::spread_laws() {
  const Mat h = laws_.spread(single_);
  check(MatDuplicate(coarsest_.get(), MAT_COPY_VALUES, coarsest_with_laws_.put()));
  if (h != nullptr) check(MatAXPY(coarsest_with_laws_.get(), 1.0, h, DIFFERENT_NONZERO_PATTERN));
  KSP solver = nullptr;
  check(PCMGGetSmoother(pc_.get(), 0, &solver));
  check(KSPSetOperators(solver, coarsest_with_laws_.get(), coarsest_with_laws_.get()));
}

double Multigrid::bytes() const {
  double out = laws_.bytes();
  for (const SingleLevel& level : single_)
    out += level.matrix->bytes() + level.interpolation->bytes();
  return out;
}

} // namespace hvi::petsc_module
