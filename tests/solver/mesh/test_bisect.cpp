// Local bisection: conforming, nested, with bounded angles, groups inherited.
#include "helpers.hpp"
#include "solver/mesh/bisect.hpp"

#include <cmath>
#include <numeric>

namespace hvi::solver::test {
namespace {

std::vector<std::int32_t> at_corner(const Mesh& mesh) {
  std::vector<std::int32_t> out;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    for (int k = 0; k <= mesh.dim; ++k)
      if (const Point& p = mesh.nodes[mesh.cells[c][k]];
          std::hypot(p[0], p[1], p[2]) < 1e-12 && (out.empty() || out.back() != int(c)))
        out.push_back(static_cast<std::int32_t>(c));
  return out;
}

std::vector<std::int32_t> some_cells(const Mesh& mesh, unsigned seed, int one_in) {
  std::mt19937 random(seed);
  std::vector<std::int32_t> out;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    if (random() % static_cast<unsigned>(one_in) == 0) out.push_back(static_cast<std::int32_t>(c));
  return out;
}

TEST(Bisection, IsConformingAndInheritsGroups) {
  for (int dim = 1; dim <= 3; ++dim) {
    Mesh first = shaken_mesh(dim, 3, 7);
    first.groups["some"] = {Group::Kind::cells, {0, 2}};
    first.groups["pin"] = {Group::Kind::points, {1}};
    Bisection bisection(first);
    for (unsigned round = 0; round < 4; ++round) {
      bisection.bisect(some_cells(bisection.mesh(), round, 6), round % 2 ? 1 : dim);
      const Mesh mesh = bisection.mesh();
      check_mesh(mesh); // every facet on one or two cells: no node hangs
      EXPECT_NEAR(total_measure(mesh), total_measure(first), 1e-12);
      EXPECT_EQ(mesh.groups.at("pin").entities, first.groups.at("pin").entities);
      for (const auto& [name, group] : first.groups) {
        if (group.kind == Group::Kind::points) continue;
        EXPECT_NEAR(group_measure(mesh, name), group_measure(first, name), 1e-12) << name;
      }
    }
  }
}

TEST(Bisection, KeepsInteriorFacetsAndTheirSide) {
  Mesh mesh = unit_mesh(2, {2, 1, 0});
  mesh.groups["seam"] = {Group::Kind::facets, build_facets(mesh, {{4, 1, -1}})};
  Bisection bisection(mesh);
  std::vector<std::int32_t> all(mesh.cells.size());
  std::iota(all.begin(), all.end(), 0);
  bisection.bisect(all, 2);
  const Mesh fine = bisection.mesh();
  ASSERT_EQ(fine.groups.at("seam").entities.size(), 2U);
  for (const auto f : fine.groups.at("seam").entities) {
    EXPECT_GE(fine.facets[f].other, 0);
    EXPECT_EQ(facet_normal(fine, f)[0], -1);
  }
}

/// Angles stay bounded however deep a corner is refined, on meshes without any structure.
TEST(Bisection, ShapesStayBounded) {
  for (int dim = 2; dim <= 3; ++dim) {
    const Mesh first = shaken_mesh(dim, 2, 3);
    Bisection bisection(first);
    double worst = 0;
    for (int round = 0; round < 12; ++round) {
      bisection.bisect(at_corner(bisection.mesh()), dim);
      const auto quality = mesh_quality(bisection.mesh());
      if (round == 3) worst = quality.worst_aspect;
      if (round <= 3) continue;
      EXPECT_LE(quality.worst_aspect, worst * (1 + 1e-9)) << round;
    }
    EXPECT_LT(mesh_quality(bisection.mesh()).shortest_edge, 1e-3);
    // Each round halves the cells at the corner and adds a bounded number around it.
    EXPECT_LT(bisection.n_cells(), first.cells.size() + (dim == 2 ? 60U : 800U) * 12U);
  }
}

/// Few similarity classes of one tetrahedron, cut everywhere: Arnold, Mukherjee, Pouly, theorem 3.1
/// (at most 72).
TEST(Bisection, FewShapesOfATetrahedron) {
  Mesh mesh;
  mesh.dim = 3;
  mesh.nodes = {{0, 0, 0}, {1, 0.2, 0.1}, {0.3, 1.1, -0.1}, {0.4, 0.2, 0.9}};
  mesh.cells = {{0, 1, 2, 3}};
  build_facets(mesh, {});
  Bisection bisection(mesh);
  std::set<std::array<long, 6>> shapes;
  for (int round = 0; round < 12; ++round) {
    std::vector<std::int32_t> all(bisection.n_cells());
    std::iota(all.begin(), all.end(), 0);
    bisection.bisect(all);
    const Mesh fine = bisection.mesh();
    const std::size_t before = shapes.size();
    for (const auto& c : fine.cells) {
      std::array<double, 6> edges{};
      int n = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j)
          edges[n++] = std::hypot(fine.nodes[c[i]][0] - fine.nodes[c[j]][0],
                                  fine.nodes[c[i]][1] - fine.nodes[c[j]][1],
                                  fine.nodes[c[i]][2] - fine.nodes[c[j]][2]);
      std::sort(edges.begin(), edges.end());
      std::array<long, 6> shape{};
      for (int e = 0; e < 6; ++e) shape[e] = std::lround(1e6 * edges[e] / edges[5]);
      shapes.insert(shape);
    }
    if (round < 11) continue;
    EXPECT_EQ(shapes.size(), before) << "no new shapes any more";
  }
  EXPECT_LE(shapes.size(), 72U);
}

/// A subset of the cells gives a mesh that the larger set refines: its nodes are among the others.
TEST(Bisection, FewerCellsGiveACoarserMesh) {
  for (int dim = 2; dim <= 3; ++dim) {
    const Mesh first = shaken_mesh(dim, 3, 5);
    const auto many = some_cells(first, 1, 3);
    Bisection coarse(first), fine(first);
    coarse.bisect({many.data(), many.size() / 2}, dim);
    fine.bisect(many, dim);
    std::set<Point> nodes;
    for (const Point& p : fine.mesh().nodes) nodes.insert(p);
    for (const Point& p : coarse.mesh().nodes) EXPECT_TRUE(nodes.contains(p));
    EXPECT_LT(coarse.n_cells(), fine.n_cells());
  }
}

} // namespace
} // namespace hvi::solver::test
