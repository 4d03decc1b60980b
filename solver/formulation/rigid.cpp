// Why a matrix has no factor, in the user's words; see rigid.hpp.
#include "solver/formulation/rigid.hpp"

#include "solver/common/joined.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/discrete/strain.hpp"
#include "solver/fem/geometry.hpp"
#include "solver/formulation/whole_time.hpp"
#include "solver/linear/dense.hpp"

#include <fmt/format.h>

#include <optional>

namespace hvi::solver {
namespace {

/// Energies below this, relative to those of single unknowns, may be rounding.
constexpr double energy_of_rounding = 1e-12;
/// Strains times the cell's size below this, relative to the motion, are rounding.
constexpr double strain_of_rounding = 1e-8;

/// The motion x of least energy x^T K x by its size x^T D x, D = diag K: inverse iteration with
/// K + energy_of_rounding D. Nothing where not even that is positive: K has clearly negative
/// energies, or an unknown without any.
std::optional<Vector> softest_motion(const SparseMatrix& k) {
  SparseMatrix shifted = 0.5 * (k + SparseMatrix(k.transpose()));
  const Vector diagonal = k.diagonal();
  for (int i = 0; i < shifted.rows(); ++i)
    shifted.coeffRef(i, i) += energy_of_rounding * diagonal[i];
  shifted.makeCompressed(); // unknowns in no form had no entry
  try {
    const auto factor = analyse(shifted, {}, true);
    factor->factor(shifted);
    Vector x(k.rows()), b;
    for (int i = 0; i < k.rows(); ++i) x[i] = random_unit(static_cast<std::uint64_t>(i), 0);
    for (int pass = 0; pass < 4; ++pass) {
      b = diagonal.cwiseProduct(x);
      solve(*factor, b, x);
      x.normalize();
    }
    if (x.allFinite()) return x;
  } catch (const NotFactorable&) {
  }
  return std::nullopt;
}

/// Does the motion strain no cell? Then pieces of the mesh are not held, or turn about a point.
bool strains_nothing(const Space& space, const Vector& motion) {
  double strain = 0.0;
  for (const SpaceBlock& block : space.blocks)
    for (int cell = 0; cell < n_cells(space); ++cell)
      strain = std::max(strain, cell_size(space, cell) *
                                    cell_strain(space, block, motion, cell).cwiseAbs().maxCoeff());
  return strain <= strain_of_rounding * motion.cwiseAbs().maxCoeff();
}

/// No rigid motion of the whole body is free: is K really not positive definite, or by rounding
/// only?
[[noreturn]] void explain(const SparseMatrix& k, const NotFactorable& failure, const Origin& origin,
                          const Space& space, const Formulation& formulation) {
  const StateLayout& layout = formulation.layout();
  const auto place = failure.unknown >= 0 && failure.unknown < layout.n_unknowns
                         ? describe_dof(space, layout.dof_of[failure.unknown])
                         : std::string("an unknown that is not known");
  const auto where =
      fmt::format("elimination breaks down at {} (relative pivot {:.3g})", place, failure.pivot);
  const auto softest = softest_motion(k);
  if (!softest)
    throw Failure(FailureKind::not_coercive, origin,
                  "the bilinear forms are not coercive: " + where,
                  "check the signs of the forms, and that every part of the body has a stiffness");
  Vector state = Vector::Zero(layout.n_state), motion = Vector::Zero(layout.n_dofs);
  state.head(layout.n_unknowns) = *softest;
  formulation.scatter(state, motion);
  if (strains_nothing(space, motion))
    throw Failure(
        FailureKind::not_coercive, origin,
        "the forms and boundary values leave a motion free that strains no cell: " + where,
        "hold each piece of the mesh; pieces that share a point only (in 3D an edge only) "
        "turn about it");
  throw Failure(FailureKind::mostly_rounding, origin,
                "to double precision the matrix is singular: " + where, better_conditioned);
}

/// K, which is assembled here where several processes have its rows.
SparseMatrix matrix_of(const StepMatrix& matrix, const Vector& gamma, const MatrixOf& of,
                       const Problem& problem, const Discretisation& d) {
  if (matrix.dealt() == nullptr) return matrix.k();
  return combine(assemble_operators(problem, d, of.formulation.layout(), 1, false), gamma);
}

/// The memory of a step within that step may subtract more stiffness than the body has: neither the
/// forms nor double precision are to blame.
void blame_memory(StepMatrix& matrix, const MatrixOf& of, const Problem& problem) {
  if (problem.histories.empty()) return;
  const double length = of.grid.length(of.step);
  try {
    matrix.factor(whole_coefficients(of.formulation.operators(), length, {}));
  } catch (const NotFactorable&) {
    return;
  }
  throw Failure(
      FailureKind::not_coercive, problem.histories.front().kernel.origin,
      fmt::format("step {} (t = {:.6g}, length {:.3g}) is not coercive: the integral of "
                  "the memory's kernel over the step itself subtracts more stiffness than "
                  "the forms without memory give",
                  of.step, of.grid.t(of.step), length),
      "smaller steps (graded where the kernel is large) have a smaller integral; check "
      "the sign and the size of the kernel");
}

/// The combinations of these motions that K does not resist.
DenseMatrix not_resisted(const SparseMatrix& k, const DenseMatrix& motions, const Space& space,
                         const StateLayout& layout) {
  return kernel(resistance(forces_of(k, motions), space, layout.dof_of), product_of_rounding);
}

} // namespace

std::vector<std::string> free_motions(const SparseMatrix& k, const Discretisation& d,
                                      const StateLayout& layout) {
  std::vector<std::string> out;
  if (layout.n_unknowns != d.dofs.n_unknowns()) return out; // modes of the interior have a factor
  for (int b = 0; b < n_unknowns(d.space); ++b) {
    const RigidMotions motions(d, b);
    if (motions.count() == 0) continue;
    const DenseMatrix all = motions.on(d.dofs.free);
    DenseMatrix left = not_resisted(k, all, d.space, layout);
    if (left.cols() == 0) left = not_resisted(k.transpose(), all, d.space, layout);
    for (Eigen::Index i = 0; i < left.cols(); ++i) out.push_back(motions.describe(left.col(i)));
  }
  return out;
}

void factor_or_explain(StepMatrix& matrix, const Vector& gamma, const MatrixOf& of,
                       const Problem& problem, const Discretisation& d) {
  try {
    matrix.factor(gamma);
  } catch (const NotFactorable& failure) {
    const Origin origin =
        problem.forms.empty() ? problem.space.origin : problem.forms.front().origin;
    if (const FreeBody* const body = matrix.free_body())
      refuse_free(unseen_motions(*body, of.formulation.contact()), "", origin);
    const SparseMatrix k = matrix_of(matrix, gamma, of, problem, d);
    const auto left = free_motions(k, d, of.formulation.layout());
    if (!left.empty())
      throw Failure(FailureKind::not_coercive, origin,
                    fmt::format("the forms and boundary values together leave rigid motions free: "
                                "{}",
                                joined(left, "; ")),
                    "clamp a part (`zero on ...`), or add a term that resists the motion");
    blame_memory(matrix, of, problem);
    explain(k, failure, origin, d.space, of.formulation);
  }
}

} // namespace hvi::solver
