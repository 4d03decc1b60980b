// The norm of an unknown against sqrt(u^T G u) with the Gram matrix, on random spaces; and where
// the body all but moves rigidly, which that root cannot see.
#include "solver/results/space_norm.hpp"
#include "tests/solver/fem/meshes.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

struct Scene {
  std::mt19937 random;
  Discretisation d;
  int unknown = 0;
  bool held = false;
  double size = 1.0; ///< of the body

  int draw(int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); }
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random); }
  const SpaceBlock& block() const { return d.space.blocks[static_cast<std::size_t>(unknown)]; }

  explicit Scene(unsigned seed) : random(seed) {
    const int dim = 1 + draw(3);
    d.mesh = test::skew_mesh(dim, 1 + draw(dim == 3 ? 2 : 4), seed);
    d.mesh.axisymmetric = dim == 2 && draw(3) == 0;
    size = std::pow(10.0, draw(7) - 3);
    for (auto& node : d.mesh.nodes) {
      node[0] += 0.5; // off the axis
      for (double& x : node) x *= size;
    }
    d.parts.push_back(test::all_cells(d.mesh));
    std::erase_if(d.parts.front().entities, [&](int cell) { return cell > 0 && draw(2) == 0; });
    SpaceSpec spec;
    spec.vector = dim > 1 && draw(2) == 0;
    spec.order = 1 + draw(2);
    spec.domain = draw(3) == 0 ? 0 : -1;
    if (draw(2) == 0)
      spec.more.push_back(
          {"p", "W", {}, dim > 1 && draw(2) == 0, 1 + draw(2), draw(3) == 0 ? 0 : -1});
    d.space = make_space(d.mesh, spec, d.parts);
    unknown = draw(static_cast<int>(d.space.blocks.size()));
    held = draw(2) == 0;
    d.dofs.held_of.assign(d.space.blocks.size(), static_cast<char>(held));
  }

  /// Values of `f(node, component)` of the unknown; other unknowns have values of their own.
  template <class F>
  Vector field(F&& f) {
    Vector u = Vector::NullaryExpr(d.space.n_dofs(), [&] { return number(); });
    const std::size_t nodes =
        block().order < d.space.order ? d.mesh.nodes.size() : d.space.nodes.size();
    for (std::size_t node = 0; node < d.space.nodes.size(); ++node)
      for (int c = 0; c < block().components; ++c)
        u[d.space.dof(static_cast<int>(node), block().first + c)] =
            node < nodes ? f(d.space.nodes[node], c) : 0.0;
    return u;
  }

  double norm(const Vector& u) {
    const Vector* fields[] = {&u};
    return SpaceNorm(d, unknown).value(u, {fields, 0.0});
  }
  double by_matrix(const Vector& u) const {
    return std::sqrt(
        u.dot(gram_of_unknown(d.space, unknown, block().components == 1 && !held) * u));
  }
};

TEST(SpaceNorm, IsThatOfTheGramMatrixOnRandomSpaces) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Scene scene(seed);
    const Vector u = scene.field([&](const Point&, int) { return scene.number(); });
    const double expected = scene.by_matrix(u);
    EXPECT_NEAR(scene.norm(u), expected, 1e-12 * expected) << "seed " << seed;
  }
}

/// A motion of the size of the body without strains, and strains of 1e-7 on it.
TEST(SpaceNorm, SeesSmallStrainsUnderMotionsOfTheBody) {
  int seen = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Scene scene(seed);
    if (scene.block().components == 1 && !scene.held) continue; // u counts itself
    const int dim = scene.d.mesh.dim;
    const bool ring = scene.d.mesh.axisymmetric && scene.block().components > 1;
    std::array<double, 3> shift{}, turn{};
    for (int c = 0; c < 3; ++c) shift[c] = ring && c != 1 ? 0.0 : scene.size * scene.number();
    if (dim == 3) turn = {scene.number(), scene.number(), scene.number()};
    if (dim == 2 && !ring) turn[2] = scene.number();
    if (scene.block().components == 1) turn = {};
    const auto motion = [&](const Point& p, int c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      return shift[c] + turn[a] * p[b] - turn[b] * p[a];
    };
    const Vector strained =
        scene.field([&](const Point&, int) { return 1e-7 * scene.size * scene.number(); });
    const double expected = scene.by_matrix(strained);
    Scene same(seed);
    Vector u = strained;
    const Vector rigid = same.field(motion);
    const SpaceBlock& block = scene.block();
    for (std::size_t node = 0; node < scene.d.space.nodes.size(); ++node)
      for (int c = 0; c < block.components; ++c) {
        const int dof = scene.d.space.dof(static_cast<int>(node), block.first + c);
        u[dof] += rigid[dof];
      }
    EXPECT_NEAR(scene.norm(u), expected, 1e-7 * expected) << "seed " << seed;
    ++seen;
  }
  EXPECT_GT(seen, 150);
}

} // namespace
} // namespace hvi::solver
