// Why a matrix has no factor, in the user's words; see rigid.hpp.
#include "solver/time/rigid.hpp"

#include "solver/fem/geometry.hpp"
#include "solver/linear/dense.hpp"
#include "solver/time/rounding.hpp"
#include "solver/time/run.hpp"
#include "solver/time/strain.hpp"
#include "solver/time/whole_time.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

namespace hvi::solver {
namespace {

struct Motion {
  std::string name;
  Vector values; ///< on all dofs
};

constexpr const char* axis_names[] = {"x", "y", "z"};

/// Has the unknown a function at this node?
int nodes_of(const Space& space, const SpaceBlock& block) {
  return static_cast<int>(block.order == space.order ? space.nodes.size()
                                                     : space.mesh->nodes.size());
}

/// Scalar: the constant. Vector: translations and infinitesimal rotations about the centre;
/// axisymmetric: the translation along the axis only.
std::vector<Motion> motions(const Space& space, const SpaceBlock& block) {
  std::vector<Motion> out;
  const int n = block.components, n_nodes = nodes_of(space, block);
  if (n == 1) {
    out.push_back({"a constant", Vector::Zero(space.n_dofs())});
    for (int p = 0; p < n_nodes; ++p) out.back().values[space.dof(p, block.first)] = 1.0;
    return out;
  }
  Point centre{};
  for (int p = 0; p < n_nodes; ++p)
    for (int i = 0; i < 3; ++i) centre[i] += space.nodes[p][i] / n_nodes;
  const bool ring = has_hoop(space, block);
  for (int i = ring ? 1 : 0; i < n; ++i) {
    out.push_back(
        {std::string("translation along ") + axis_names[i], Vector::Zero(space.n_dofs())});
    for (int p = 0; p < n_nodes; ++p) out.back().values[space.dof(p, block.first + i)] = 1.0;
  }
  for (int i = 0; i < n && !ring; ++i)
    for (int j = i + 1; j < n; ++j) {
      const auto name =
          n == 2 ? std::string("rotation") : std::string("rotation about ") + axis_names[3 - i - j];
      out.push_back({name, Vector::Zero(space.n_dofs())});
      for (int p = 0; p < n_nodes; ++p) {
        out.back().values[space.dof(p, block.first + i)] = -(space.nodes[p][j] - centre[j]);
        out.back().values[space.dof(p, block.first + j)] = space.nodes[p][i] - centre[i];
      }
    }
  for (auto& motion : out) motion.values.normalize();
  return out;
}

/// Of every unknown.
std::vector<Motion> motions(const Space& space) {
  if (!space.is_product()) return motions(space, space.blocks.front());
  std::vector<Motion> out;
  for (const SpaceBlock& block : space.blocks)
    for (Motion& motion : motions(space, block))
      out.push_back({fmt::format("{} of `{}`", motion.name, block.name), std::move(motion.values)});
  return out;
}

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

/// Do the imposed values alone prevent every rigid motion? Motions are measured where values are
/// imposed: measured by the length of the body, a short clamp would seem to leave a rotation free.
bool held_by_values(const Discretisation& d) {
  const auto all = motions(d.space);
  const auto& imposed = d.dofs.eliminated;
  DenseMatrix at(static_cast<Eigen::Index>(imposed.size()), static_cast<Eigen::Index>(all.size()));
  for (Eigen::Index i = 0; i < at.rows(); ++i)
    for (Eigen::Index a = 0; a < at.cols(); ++a)
      at(i, a) = all[static_cast<std::size_t>(a)].values[imposed[static_cast<std::size_t>(i)].dof];
  // Rotations about the centre of the imposed values, which they prevent without the translations.
  for (Eigen::Index a = 0; a < at.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b)
      if (const double square = at.col(b).squaredNorm(); square > 0.0)
        for (int twice = 0; twice < 2; ++twice)
          at.col(a) -= at.col(b).dot(at.col(a)) / square * at.col(b);
    constexpr double smallest = 1e-10; // of the motion at the imposed values before: else rounding
    const double left = at.col(a).norm();
    double before = 0.0;
    for (const auto& e : imposed)
      before = std::max(before, std::abs(all[static_cast<std::size_t>(a)].values[e.dof]));
    if (!(left > smallest * before)) return false;
  }
  return at.cols() > 0 && at.rows() > 0;
}

} // namespace

std::vector<std::string> free_motions(const SparseMatrix& k, const Discretisation& d,
                                      const StateLayout& layout) {
  const auto all = motions(d.space);
  const auto m = static_cast<Eigen::Index>(all.size());
  // Minimise (energy on the unknowns + size on the imposed dofs): zero for a motion left free.
  DenseMatrix energy = DenseMatrix::Zero(m, m);
  DenseMatrix inside(k.rows(), m);
  const Vector diagonal = k.diagonal().cwiseAbs();
  const double stiffness = diagonal.maxCoeff();
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index i = 0; i < k.rows(); ++i) {
      const auto dof = layout.dof_of[i]; // a mode of the interior has none
      inside(i, a) = dof >= 0 ? all[a].values[dof] : 0.0;
    }
  const DenseMatrix forces = k * inside;
  // Of several unknowns a pressure has no energy: what is free has no forces.
  energy = d.space.is_product() ? DenseMatrix(forces.transpose() * forces) / stiffness
                                : DenseMatrix(inside.transpose() * forces);
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index b = 0; b < m; ++b)
      for (const auto& e : d.dofs.eliminated)
        energy(a, b) += stiffness * all[a].values[e.dof] * all[b].values[e.dof];
  const DenseMatrix symmetric = (energy + energy.transpose()) / 2;
  const double small = 1e-11 * stiffness;
  auto left = (symmetric_eigenvalues(symmetric).array() <= small).count();
  std::vector<std::string> out;
  for (Eigen::Index a = 0; a < m; ++a)
    if (symmetric(a, a) <= small) out.push_back(all[a].name);
  // A body held at one point rotates about that point: a combination of these motions.
  for (left -= static_cast<Eigen::Index>(out.size()); left > 0; --left)
    out.emplace_back("a combination of translation and rotation");
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
    const auto left = held_by_values(d) ? std::vector<std::string>()
                                        : free_motions(matrix.k(), d, of.formulation.layout());
    if (!left.empty())
      throw Failure(FailureKind::not_coercive, origin,
                    fmt::format("the forms and boundary values together leave rigid motions free: "
                                "{}",
                                fmt::join(left, ", ")),
                    "clamp a part (`zero on ...`), or add a term that resists the motion");
    const SparseMatrix k = matrix.k();
    blame_memory(matrix, of, problem);
    explain(k, failure, origin, d.space, of.formulation);
  }
}

} // namespace hvi::solver
