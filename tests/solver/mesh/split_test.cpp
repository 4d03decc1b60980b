// Meshes cut along inner facets.
#include "solver/common/failure.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/split.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace hvi::solver {
namespace {

/// [0, 2] x [0, 2] (x [0, 2]), cut on y = 1 for x < end.
Mesh cracked(int dim, double end) {
  const auto lines = uniform_coordinates(0, 2, 4);
  Mesh mesh = structured_mesh(dim, {lines, lines, dim == 3 ? lines : std::vector<double>{}});
  std::vector<std::array<std::int32_t, 3>> named;
  for (const auto& cell : mesh.cells)
    for (int left_out = 0; left_out <= dim; ++left_out) {
      std::array<std::int32_t, 3> nodes{-1, -1, -1};
      bool on_it =
          mesh.nodes[static_cast<std::size_t>(cell[static_cast<std::size_t>(left_out)])][1] > 1;
      for (int k = 0, n = 0; k <= dim; ++k) {
        if (k == left_out) continue;
        nodes[static_cast<std::size_t>(n++)] = cell[static_cast<std::size_t>(k)];
        const Point& x = mesh.nodes[static_cast<std::size_t>(cell[static_cast<std::size_t>(k)])];
        on_it = on_it && x[1] == 1.0 && x[0] <= end;
      }
      if (on_it) named.push_back(nodes);
    }
  mesh.facets.clear();
  mesh.groups.clear();
  mesh.groups["crack"] = {Group::Kind::facets, build_facets(mesh, named)};
  return mesh;
}

TEST(Split, OpensWhereItEndsOnTheBoundary) {
  for (const int dim : {2, 3}) {
    const std::size_t across = dim == 3 ? 5 : 1; // nodes along the third axis
    for (const double end : {1.0, 2.0}) {
      Mesh mesh = cracked(dim, end);
      const auto nodes = mesh.nodes.size();
      const auto facets = mesh.groups.at("crack").entities.size();
      split(mesh, std::vector<std::string>{"crack"});
      // A tip inside stays one node, a cut through gives two bodies.
      EXPECT_EQ(mesh.nodes.size(), nodes + across * (end == 1.0 ? 2 : 5));
      EXPECT_EQ(mesh_quality(mesh).pieces, end == 1.0 ? 1 : 2);
      for (const char* side : {"crack.first", "crack.second"}) {
        const auto& group = mesh.groups.at(side).entities;
        EXPECT_EQ(group.size(), facets);
        for (const auto f : group) {
          const Facet& facet = mesh.facets[static_cast<std::size_t>(f)];
          EXPECT_EQ(facet.other, -1);
          const auto& cell = mesh.cells[static_cast<std::size_t>(facet.cell)];
          double middle = 0.0;
          for (int k = 0; k <= dim; ++k)
            middle += mesh.nodes[static_cast<std::size_t>(cell[static_cast<std::size_t>(k)])][1] /
                      (dim + 1);
          EXPECT_NEAR(facet_normal(mesh, f)[1], middle < 1 ? 1.0 : -1.0, 1e-14);
          for (int k = 0; k < dim; ++k)
            EXPECT_NE(std::find(cell.begin(), cell.end(), facet.nodes[static_cast<std::size_t>(k)]),
                      cell.end());
        }
      }
      for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        EXPECT_GT(cell_measure(mesh, static_cast<int>(c)), 0.0);
    }
  }
}

/// A cut whose ends both lie inside opens nothing: there are no facets of it, and no new nodes.
TEST(Split, OfOneFacetInsideOpensNothing) {
  Mesh mesh = cracked(2, 2.0);
  const auto& all = mesh.groups.at("crack").entities;
  const auto inside = std::ranges::find_if(all, [&](std::int32_t f) {
    const auto& nodes = mesh.facets[static_cast<std::size_t>(f)].nodes;
    return std::ranges::all_of(std::span(nodes).first(2), [&](std::int32_t n) {
      const double x = mesh.nodes[static_cast<std::size_t>(n)][0];
      return x > 0.0 && x < 2.0;
    });
  });
  ASSERT_NE(inside, all.end());
  mesh.groups["crack"].entities = {*inside};
  const auto nodes = mesh.nodes.size(), facets = mesh.facets.size();
  split(mesh, std::vector<std::string>{"crack"});
  EXPECT_EQ(mesh.nodes.size(), nodes);
  EXPECT_EQ(mesh.facets.size(), facets);
  EXPECT_TRUE(mesh.groups.at("crack.first").entities.empty());
  EXPECT_TRUE(mesh.groups.at("crack.second").entities.empty());
}

/// Of an interval the facets are points: each half has an end there, with its own normal.
TEST(Split, CutsAnIntervalAtAPoint) {
  Mesh mesh = structured_mesh(1, {uniform_coordinates(0, 2, 4)});
  mesh.groups.clear();
  mesh.groups["cut"] = {Group::Kind::facets, build_facets(mesh, {{2, -1, -1}})};
  split(mesh, std::vector<std::string>{"cut"});
  EXPECT_EQ(mesh.nodes.size(), 6);
  EXPECT_EQ(mesh_quality(mesh).pieces, 2);
  double normals = 0.0;
  for (const char* side : {"cut.first", "cut.second"}) {
    ASSERT_EQ(mesh.groups.at(side).entities.size(), 1U);
    const Facet& facet =
        mesh.facets[static_cast<std::size_t>(mesh.groups.at(side).entities.front())];
    EXPECT_EQ(facet.other, -1);
    const auto& cell = mesh.cells[static_cast<std::size_t>(facet.cell)];
    const bool left = mesh.nodes[static_cast<std::size_t>(cell[0])][0] < 1.0;
    EXPECT_EQ(mesh.nodes[static_cast<std::size_t>(facet.nodes[0])], (Point{1, 0, 0}));
    EXPECT_EQ(facet.nodes[0], cell[left ? 1 : 0]);
    const double normal = facet_normal(mesh, mesh.groups.at(side).entities.front())[0];
    EXPECT_EQ(normal, left ? 1.0 : -1.0);
    normals += normal;
  }
  EXPECT_EQ(normals, 0.0);
}

TEST(Split, RefusesWhatIsNoInnerGroup) {
  Mesh mesh = cracked(2, 1.0);
  EXPECT_THROW(split(mesh, std::vector<std::string>{"gap"}), Failure);
  mesh.groups["cells"] = {Group::Kind::cells, {0}};
  EXPECT_THROW(split(mesh, std::vector<std::string>{"cells"}), Failure);
  mesh.groups["again"] = mesh.groups.at("crack");
  EXPECT_THROW(split(mesh, std::vector<std::string>{"crack", "again"}), Failure);
}

} // namespace
} // namespace hvi::solver
