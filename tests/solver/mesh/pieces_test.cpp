// Meshes put together: numbers, groups, and where points of two pieces are found.
#include "solver/common/failure.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/pieces.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

Mesh block(double x, double y, int cells) {
  return structured_mesh(
      2, {uniform_coordinates(x, x + 1, cells), uniform_coordinates(y, y + 1, cells)});
}

TEST(Pieces, KeepTheirGroups) {
  const std::vector<Mesh> meshes{block(0, 1, 3), block(0, 0, 2)};
  const std::vector<std::string> names{"upper", "lower"};
  const Mesh mesh = side_by_side(meshes, names);
  EXPECT_EQ(mesh.nodes.size(), 16u + 9u);
  EXPECT_EQ(mesh.cells.size(), 18u + 8u);
  EXPECT_EQ(mesh.groups.size(), 2u * (4 + 2));
  EXPECT_EQ(mesh.groups.at("lower").entities.front(), 18);
  EXPECT_EQ(mesh.groups.at("upper.boundary").entities.size(), 12u);
  for (const char* side : {"upper.bottom", "lower.top"})
    for (const auto f : mesh.groups.at(side).entities) {
      EXPECT_DOUBLE_EQ(mesh.nodes[static_cast<std::size_t>(
                           mesh.facets[static_cast<std::size_t>(f)].nodes[0])][1],
                       1.0);
      EXPECT_NEAR(facet_normal(mesh, f)[1], side[0] == 'u' ? -1.0 : 1.0, 1e-15);
    }
  EXPECT_EQ(mesh_quality(mesh).pieces, 2);
  EXPECT_EQ(mesh.piece_of_cell(17), 0);
  EXPECT_EQ(mesh.piece_of_cell(18), 1);
}

TEST(Pieces, AreAskedInTheirOrder) {
  for (const bool swapped : {false, true}) {
    std::vector<Mesh> meshes{block(0, 1, 3), block(0, 0, 7)};
    const std::vector<std::string> names{"first", "second"};
    if (swapped) std::swap(meshes[0], meshes[1]);
    const Mesh mesh = side_by_side(meshes, names);
    for (const std::size_t points : {1u, 100000u})
      for (int i = 0; i <= 50; ++i) {
        std::array<double, 4> at{};
        const int cell = CellLocator(mesh, points).find({i / 50.0, 1.0, 0.0}, at);
        ASSERT_GE(cell, 0);
        EXPECT_EQ(mesh.piece_of_cell(cell), 0);
      }
  }
}

TEST(Pieces, HaveNamesOfTheirOwn) {
  std::vector<Mesh> meshes{block(0, 1, 1), block(0, 0, 1)};
  meshes[0].groups["b.left"] = {};
  const std::vector<std::string> names{"a", "a.b"};
  EXPECT_THROW(side_by_side(meshes, names), Failure);
}

} // namespace
} // namespace hvi::solver
