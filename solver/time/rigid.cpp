// Why a matrix has no factor, in the user's words; see rigid.hpp.
#include "solver/time/rigid.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace hvi::solver {
namespace {

struct Motion {
  std::string name;
  Vector values; ///< on all dofs
};

constexpr const char* axis_names[] = {"x", "y", "z"};

/// Scalar: the constant. Vector: translations and infinitesimal rotations about the centre.
std::vector<Motion> motions(const Space& space) {
  std::vector<Motion> out;
  const int n = space.components;
  if (n == 1) return {{"a constant", Vector::Ones(space.n_dofs())}};
  const auto n_nodes = static_cast<int>(space.nodes.size());
  Point centre{};
  for (const auto& node : space.nodes)
    for (int i = 0; i < 3; ++i) centre[i] += node[i] / n_nodes;
  for (int i = 0; i < n; ++i) {
    out.push_back(
        {std::string("translation along ") + axis_names[i], Vector::Zero(space.n_dofs())});
    for (int p = 0; p < n_nodes; ++p) out.back().values[space.dof(p, i)] = 1.0;
  }
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) {
      const auto name =
          n == 2 ? std::string("rotation") : std::string("rotation about ") + axis_names[3 - i - j];
      out.push_back({name, Vector::Zero(space.n_dofs())});
      for (int p = 0; p < n_nodes; ++p) {
        out.back().values[space.dof(p, i)] = -(space.nodes[p][j] - centre[j]);
        out.back().values[space.dof(p, j)] = space.nodes[p][i] - centre[i];
      }
    }
  for (auto& motion : out) motion.values.normalize();
  return out;
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
    for (Eigen::Index i = 0; i < k.rows(); ++i) inside(i, a) = all[a].values[layout.dof_of[i]];
  energy = inside.transpose() * (k * inside);
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index b = 0; b < m; ++b)
      for (const auto& e : d.dofs.eliminated)
        energy(a, b) += stiffness * all[a].values[e.dof] * all[b].values[e.dof];
  const DenseMatrix symmetric = (energy + energy.transpose()) / 2;
  const Eigen::SelfAdjointEigenSolver<DenseMatrix> modes(symmetric, Eigen::EigenvaluesOnly);
  const double small = 1e-11 * stiffness;
  auto left = (modes.eigenvalues().array() <= small).count();
  std::vector<std::string> out;
  for (Eigen::Index a = 0; a < m; ++a)
    if (symmetric(a, a) <= small) out.push_back(all[a].name);
  // A body held at one point turns about that point: a combination of ours.
  for (left -= static_cast<Eigen::Index>(out.size()); left > 0; --left)
    out.emplace_back("a combination of translation and rotation");
  return out;
}

void factor_or_explain(StepMatrix& matrix, const Vector& gamma, const Plan& plan,
                       const Discretisation& d, const StateLayout& layout) {
  try {
    matrix.factor(gamma);
  } catch (const NotFactorable& failure) {
    const Origin origin = plan.forms.empty() ? plan.space.origin : plan.forms.front().origin;
    const auto left = free_motions(matrix.k(), d, layout);
    if (!left.empty())
      throw Failure(FailureKind::not_coercive, origin,
                    fmt::format("the forms and boundary values together leave rigid motions free: "
                                "{}",
                                fmt::join(left, ", ")),
                    "clamp a part (`zero on ...`), or add a term that resists the motion");
    const auto place = failure.unknown >= 0 && failure.unknown < layout.n_unknowns
                           ? describe_dof(d.space, layout.dof_of[failure.unknown])
                           : std::string("an unknown that is not known");
    throw Failure(FailureKind::not_coercive, origin,
                  fmt::format("the bilinear forms are not coercive: elimination breaks down at {} "
                              "(relative pivot {:.3g})",
                              place, failure.pivot),
                  "check the signs of the forms, that every part of the body has a stiffness, and "
                  "that each piece of the mesh is held; a body much longer than thick, nearly "
                  "incompressible or of very unequal stiffnesses can be lost in rounding, too");
  }
}

} // namespace hvi::solver
