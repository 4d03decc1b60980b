// Meshes in parts for as many processes.
#include "solver/mesh/cell_parts.hpp"
#include "tests/solver/mesh/helpers.hpp"

#include <cmath>
#include <map>

namespace hvi::solver {
namespace {

using namespace test;

/// Facets between cells of different parts.
int cut_of(const Mesh& mesh, const std::vector<std::int32_t>& part) {
  std::map<std::set<std::int32_t>, std::vector<std::int32_t>> sides;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    for (int left_out = 0; left_out <= mesh.dim; ++left_out) {
      std::set<std::int32_t> nodes;
      for (int k = 0; k <= mesh.dim; ++k)
        if (k != left_out) nodes.insert(mesh.cells[c][static_cast<std::size_t>(k)]);
      sides[nodes].push_back(part[c]);
    }
  int out = 0;
  for (const auto& [nodes, parts] : sides) out += parts.size() == 2 && parts[0] != parts[1];
  return out;
}

TEST(CellParts, AreOfAlikeSizeWithShortBoundaries) {
  for (const int dim : {1, 2, 3})
    for (const int parts : {2, 3, 4, 8}) {
      const int cells = dim == 1 ? 400 : dim == 2 ? 16 : 8;
      const Mesh mesh = shaken_mesh(dim, cells, static_cast<unsigned>(dim + 10 * parts));
      const auto part = parts_of_cells(mesh, parts);
      ASSERT_EQ(part.size(), mesh.cells.size());
      std::vector<int> sizes(static_cast<std::size_t>(parts), 0);
      for (const auto p : part) ++sizes.at(static_cast<std::size_t>(p));
      const double mean = static_cast<double>(part.size()) / parts;
      EXPECT_LE(*std::ranges::max_element(sizes), 1.06 * mean + 1) << dim << "D, " << parts;
      EXPECT_GE(*std::ranges::min_element(sizes), 0.85 * mean - 1) << dim << "D, " << parts;
      // So many slices have (parts - 1) boundaries of the whole width, of two triangles in 3D.
      const double slices = (parts - 1) * std::pow(cells, dim - 1) * (dim == 3 ? 2 : 1);
      EXPECT_LE(cut_of(mesh, part), 1.6 * slices) << dim << "D, " << parts;
      EXPECT_EQ(parts_of_cells(mesh, parts), part);
    }
}

TEST(CellParts, OfFewCellsAreEmptyOrOneCell) {
  const Mesh two = unit_mesh(2, {1, 1, 0});
  EXPECT_EQ(parts_of_cells(two, 1), (std::vector<std::int32_t>{0, 0}));
  EXPECT_EQ(parts_of_cells(two, 2), (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(parts_of_cells(two, 5), (std::vector<std::int32_t>{0, 1}));
  const auto nine = parts_of_cells(unit_mesh(2, {3, 3, 0}), 17);
  EXPECT_EQ(nine.size(), 18u);
  for (const auto p : nine) EXPECT_TRUE(p >= 0 && p < 17);
}

} // namespace
} // namespace hvi::solver
