// Spaces, dof maps, imposed values and interpolation.
#include "solver/fem/geometry.hpp"
#include "solver/fem/space.hpp"
#include "tests/solver/fem/meshes.hpp"

#include <gtest/gtest.h>

#include <set>

namespace hvi::solver {
namespace {

using namespace test;

TEST(Space, CountsNodes) {
  // Structured n x n squares in two triangles: (2n+1)^2 nodes of P2. Kuhn's n^3 cubes: (2n+1)^3.
  EXPECT_EQ(make_space(box_mesh(1, {5, 0, 0}), 2, 1).nodes.size(), 11u);
  EXPECT_EQ(make_space(box_mesh(2, {4, 4, 0}), 2, 2).nodes.size(), 81u);
  EXPECT_EQ(make_space(box_mesh(3, {3, 3, 3}), 2, 3).nodes.size(), 343u);
  EXPECT_EQ(make_space(box_mesh(3, {3, 3, 3}), 1, 3).nodes.size(), 64u);
}

TEST(Space, EdgeNodesAreMidpointsAndShared) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 3);
    const Space space = make_space(mesh, 2, 1);
    std::set<std::array<double, 3>> places(space.nodes.begin(), space.nodes.end());
    EXPECT_EQ(places.size(), space.nodes.size()) << "a node was made twice";
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      const auto nodes = space.nodes_of_cell(static_cast<int>(c));
      int i = dim + 1;
      for (const auto& [a, b] : simplex_edges(dim)) {
        for (int j = 0; j < 3; ++j) {
          EXPECT_DOUBLE_EQ(space.nodes[nodes[i]][j],
                           0.5 * (space.nodes[nodes[a]][j] + space.nodes[nodes[b]][j]));
        }
        ++i;
      }
    }
  }
}

TEST(Space, FacetNodesBelongToTheCellBehind) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 2);
      const Space space = make_space(mesh, order, dim);
      for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const auto of_cell = space.nodes_of_cell(mesh.facets[f].cell);
        for (const auto node : space.nodes_of_facet(static_cast<int>(f))) {
          EXPECT_EQ(std::count(of_cell.begin(), of_cell.end(), node), 1);
        }
      }
    }
  }
}

TEST(Space, GraphHoldsExactlyTheNeighbours) {
  const Mesh mesh = skew_mesh(3, 2);
  const Space space = make_space(mesh, 2, 1);
  std::vector<std::set<std::int32_t>> expected(space.nodes.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto nodes = space.nodes_of_cell(static_cast<int>(c));
    for (const auto i : nodes) expected[i].insert(nodes.begin(), nodes.end());
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto& graph = *space.graph;
    const std::vector<std::int32_t> row(graph.neighbours.begin() + graph.offsets[i],
                                        graph.neighbours.begin() + graph.offsets[i + 1]);
    EXPECT_EQ(row, std::vector<std::int32_t>(expected[i].begin(), expected[i].end()));
  }
}

TEST(Space, NodesOnASide) {
  const Mesh mesh = box_mesh(2, {4, 3, 0});
  EXPECT_EQ(nodes_on(make_space(mesh, 1, 2), group(mesh, "bottom")).size(), 5u);
  EXPECT_EQ(nodes_on(make_space(mesh, 2, 2), group(mesh, "bottom")).size(), 9u);
  EXPECT_EQ(nodes_on(make_space(mesh, 2, 2), node_region(mesh, {1, 1, 0})).size(), 1u);
}

TEST(Space, RejectsOtherOrders) {
  const Mesh mesh = box_mesh(2, {1, 1, 0});
  EXPECT_THROW(make_space(mesh, 3, 2), std::invalid_argument);
  EXPECT_THROW(make_space(mesh, 1, 4), std::invalid_argument);
}

TEST(Space, DescribesDofs) {
  const Mesh mesh = box_mesh(2, {2, 1, 0});
  const Space space = make_space(mesh, 1, 2);
  const int node = node_region(mesh, {0.5, 1, 0}).entities[0];
  EXPECT_EQ(describe_dof(space, space.dof(node, 1)), "u_y at node (0.5, 1)");
  EXPECT_EQ(describe_dof(make_space(mesh, 1, 1), node), "u at node (0.5, 1)");
}

TEST(Geometry, GradientsSolveTheirDefinition) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      const CellGeometry g = cell_geometry(mesh, static_cast<int>(c));
      EXPECT_NEAR(g.measure, cell_measure(mesh, static_cast<int>(c)), 1e-15);
      for (int k = 0; k <= dim; ++k) {
        for (int l = 1; l <= dim; ++l) {
          double change = 0;
          for (int j = 0; j < dim; ++j) {
            const Point &a = mesh.nodes[mesh.cells[c][0]], &b = mesh.nodes[mesh.cells[c][l]];
            change += g.gradient[k][j] * (b[j] - a[j]);
          }
          EXPECT_NEAR(change, (k == l) - (k == 0), 1e-13);
        }
      }
    }
  }
}

/// Left clamped, bottom u_y = 0.1 t x.
struct DofCase : ::testing::Test {
  Mesh mesh = box_mesh(2, {4, 4, 0});
  Space space = make_space(mesh, 1, 2);
  std::vector<Region> parts{group(mesh, "left"), group(mesh, "bottom")};
  SpaceSpec spec;
  void SetUp() override {
    spec.dirichlet.push_back({Origin{1}, 0, -1, {}});
    spec.dirichlet.push_back({Origin{2}, 1, 1, {Expr(0.1) * t * x}});
  }
};

TEST_F(DofCase, SplitsDofsAndImposesValues) {
  const DofMap map = make_dof_map(space, spec, parts);
  EXPECT_EQ(map.eliminated.size(), 14u); // 5 nodes twice, 4 more once
  EXPECT_EQ(map.n_unknowns(), 50 - 14);
  EXPECT_FALSE(map.homogeneous);
  for (int k = 0; k < map.n_unknowns(); ++k) EXPECT_EQ(map.unknown_of[map.free[k]], k);
  Vector u = Vector::Constant(space.n_dofs(), 7);
  impose(space, spec, map, 3.0, u);
  for (const auto& e : map.eliminated) {
    const Point& p = space.nodes[e.dof / 2];
    EXPECT_NEAR(u[e.dof], e.dof % 2 == 1 && p[1] == 0 ? 0.3 * p[0] : 0, 1e-15);
    EXPECT_EQ(map.unknown_of[e.dof], -1);
  }
  EXPECT_EQ(u[map.free[0]], 7);
}

TEST_F(DofCase, DifferentValuesOnOneDofAreAnError) {
  spec.dirichlet[1].value = {Expr(0.1) * t};
  try {
    make_dof_map(space, spec, parts);
    FAIL();
  } catch (const Failure& f) {
    EXPECT_EQ(f.kind, FailureKind::overlapping_regions);
    EXPECT_EQ(f.origin.id, 2);
    EXPECT_NE(std::string(f.what()).find("u_y at node (0, 0)"), std::string::npos) << f.what();
  }
}

TEST_F(DofCase, AValueFillsInAZeroOfTheSamePart) {
  spec.dirichlet = {{Origin{1}, 1, -1, {}}, {Origin{2}, 1, 1, {Expr(2.0)}}};
  Vector u = Vector::Zero(space.n_dofs());
  const DofMap map = make_dof_map(space, spec, parts);
  impose(space, spec, map, 0, u);
  EXPECT_EQ(map.eliminated.size(), 10u);
  EXPECT_EQ(u.sum(), 10.0);
}

TEST_F(DofCase, ZerosAreHomogeneous) {
  spec.dirichlet[1].value = {Expr(0.0)};
  EXPECT_TRUE(make_dof_map(space, spec, parts).homogeneous);
}

TEST_F(DofCase, RejectsWrongComponentsAndSlots) {
  auto broken = spec;
  broken.dirichlet[1].component = 2;
  EXPECT_THROW(make_dof_map(space, broken, parts), Failure);
  broken = spec;
  broken.dirichlet[1].value = {x, y};
  EXPECT_THROW(make_dof_map(space, broken, parts), Failure);
  broken = spec;
  broken.dirichlet[1].value = {Expr::variable(slot::field(0, 0))};
  EXPECT_THROW(make_dof_map(space, broken, parts), Failure);
}

TEST_F(DofCase, ImposedNanNamesPointAndTime) {
  spec.dirichlet[1].value = {sqrt(t - x) * x};
  const DofMap map = make_dof_map(space, spec, parts);
  Vector u(space.n_dofs());
  try {
    impose(space, spec, map, 0.6, u);
    FAIL();
  } catch (const Failure& f) {
    EXPECT_EQ(f.kind, FailureKind::bad_value);
    EXPECT_NE(std::string(f.what()).find("(0.75, 0), t = 0.6"), std::string::npos) << f.what();
  }
}

TEST(Interpolate, TakesNodalValuesAndRejectsNan) {
  const Mesh mesh = skew_mesh(2, 3);
  const Space space = make_space(mesh, 2, 2);
  const std::vector<Expr> f{x * y, t * x};
  const Vector u = interpolate(space, f, 2.0, Origin{});
  for (std::size_t i = 0; i < space.nodes.size(); ++i) {
    const Point& p = space.nodes[i];
    EXPECT_NEAR(u[space.dof(static_cast<int>(i), 0)], p[0] * p[1], 1e-15);
    EXPECT_NEAR(u[space.dof(static_cast<int>(i), 1)], 2 * p[0], 1e-15);
  }
  const std::vector<Expr> bad{x, sqrt(Expr(-1.0) - x * x)};
  EXPECT_THROW(interpolate(space, bad, 0, Origin{}), Failure);
  EXPECT_THROW(interpolate(space, std::vector<Expr>{x}, 0, Origin{}), Failure);
}

} // namespace
} // namespace hvi::solver
