// Manufactured elasticity (analytic): orders of interpolation and of the Galerkin solution.
#include "tests/solver/assembly/reference.hpp"

#include <Eigen/SparseCholesky>
#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

using namespace test;

constexpr double lambda = 1.5, mu = 0.7;

Expr sine(const Expr& e) { return Expr::make(Op::sin, {e}); }

/// A smooth displacement that vanishes nowhere in particular.
std::vector<Expr> solution(int dim) {
  if (dim == 2) return {sine(Expr(2.0) * x + y), x * sine(y) + Expr(0.3) * exp(x)};
  return {sine(x + y) * z, x * sine(y + z), exp(Expr(0.5) * x) * sine(z) + y};
}

Expr strain(const std::vector<Expr>& w, int i, int j) {
  return Expr(0.5) * (derivative(w[i], j) + derivative(w[j], i));
}
Expr stress(const std::vector<Expr>& w, int i, int j) {
  Expr sigma = Expr(2 * mu) * strain(w, i, j);
  for (std::size_t k = 0; k < w.size() && i == j; ++k) {
    sigma = sigma + Expr(lambda) * derivative(w[k], static_cast<int>(k));
  }
  return sigma;
}

/// V norm of the difference between a discrete field and the solution, by a rule of high degree.
double error_in_v(const Space& space, const Vector& u, const std::vector<Expr>& w) {
  const int dim = space.mesh->dim;
  Expr square = 0.0;
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      const Expr discrete = Expr(0.5) * (Expr::variable(slot::field(0, slot::gradient(i, j))) +
                                         Expr::variable(slot::field(0, slot::gradient(j, i))));
      const Expr e = discrete - strain(w, i, j);
      square = square + e * e;
    }
  }
  const std::vector<const Vector*> vectors{&u};
  double out = 0;
  Integrator(space, all_cells(*space.mesh), Rule::exact, {square})
      .integrate({vectors, 0}, {&out, 1});
  return std::sqrt(out);
}

/// Clamped to the solution on the left, its traction on the rest.
Vector solve(const Space& space, const std::vector<Expr>& w) {
  const Mesh& mesh = *space.mesh;
  const int dim = mesh.dim;
  Region free_skin = skin(mesh);
  const auto& left = mesh.groups.at("left").entities;
  std::erase_if(free_skin.entities,
                [&](auto f) { return std::binary_search(left.begin(), left.end(), f); });
  const std::vector<Region> parts{all_cells(mesh), group(mesh, "left"), free_skin};
  LoadTerm body, traction;
  traction.part = 2;
  for (int i = 0; i < dim; ++i) {
    Expr force = 0.0, pull = 0.0;
    for (int j = 0; j < dim; ++j) {
      force = force - derivative(stress(w, i, j), j);
      pull = pull + stress(w, i, j) * Expr::variable(slot::normal(j));
    }
    body.entries.push_back({slot::value(i), force});
    traction.entries.push_back({slot::value(i), pull});
  }
  SpaceSpec spec;
  spec.dirichlet.push_back({Origin{}, 1, -1, w});
  const DofMap map = make_dof_map(space, spec, parts);
  Vector u = Vector::Zero(space.n_dofs()), f = Vector::Zero(space.n_dofs());
  impose(space, spec, map, 0, u);
  LoadAssembler(space, parts, std::vector{body, traction}).add(0, f);
  const SparseMatrix k = assemble_form(space, parts[0], elasticity(dim, lambda, mu));
  const Vector residual = f - k * u;
  std::vector<Eigen::Triplet<double>> triplets;
  for (Eigen::Index row = 0; row < k.outerSize(); ++row) {
    for (SparseMatrix::InnerIterator it(k, row); it; ++it) {
      const int i = map.unknown_of[row], j = map.unknown_of[it.col()];
      if (i >= 0 && j >= 0) triplets.emplace_back(i, j, it.value());
    }
  }
  Eigen::SparseMatrix<double> reduced(map.n_unknowns(), map.n_unknowns());
  reduced.setFromTriplets(triplets.begin(), triplets.end());
  const Vector d =
      Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(reduced).solve(Vector(residual(map.free)));
  for (int i = 0; i < map.n_unknowns(); ++i) u[map.free[i]] += d[i];
  return u;
}

struct Orders : ::testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(Orders, OfInterpolationAndSolution) {
  const auto [dim, order] = GetParam();
  const std::vector<Expr> w = solution(dim);
  const int coarse = dim == 2 ? 8 : (order == 1 ? 4 : 3);
  std::vector<double> interpolation, galerkin;
  for (const int n : {coarse, 2 * coarse}) {
    const Mesh mesh = box_mesh(dim, {n, n, n});
    const Space space = make_space(mesh, order, dim);
    interpolation.push_back(error_in_v(space, interpolate(space, w, 0, Origin{}), w));
    galerkin.push_back(error_in_v(space, solve(space, w), w));
  }
  EXPECT_NEAR(std::log2(interpolation[0] / interpolation[1]), order, 0.1);
  EXPECT_NEAR(std::log2(galerkin[0] / galerkin[1]), order, 0.1);
  // The best approximation in the energy norm is not far from the interpolant in V.
  EXPECT_LT(galerkin[1], 2 * interpolation[1]);
}

INSTANTIATE_TEST_SUITE_P(DimAndOrder, Orders,
                         ::testing::Combine(::testing::Values(2, 3), ::testing::Values(1, 2)));

TEST(Elasticity, SolutionsInTheSpaceAreFoundExactly) {
  for (int dim = 2; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 2);
      const Space space = make_space(mesh, order, dim);
      const Expr q = order == 1 ? Expr(0.3) : y;
      const std::vector<Expr> all{x * q + y, x - y * q * Expr(0.5), z + x * q};
      const std::vector<Expr> w(all.begin(), all.begin() + dim);
      const Vector exact = interpolate(space, w, 0, Origin{});
      EXPECT_LT((solve(space, w) - exact).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

} // namespace
} // namespace hvi::solver
