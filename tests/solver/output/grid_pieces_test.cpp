// Grids in pieces, on their way to other processes, and the files that name them.
#include "solver/output/grid_pieces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <sstream>

namespace hvi::solver {
namespace {

/// Cells of random points, each value of its own, in random parts.
struct RandomGrid {
  VtuGrid grid;
  std::vector<std::int32_t> part;
  int parts;

  explicit RandomGrid(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    const std::size_t points = 4 + seed % 50, cells = seed % 80;
    grid.cell = seed % 2 == 0 ? VtkCell::tetra : VtkCell::quadratic_triangle;
    grid.time = number(random);
    for (std::size_t i = 0; i < points; ++i)
      grid.points.push_back({number(random), number(random), number(random)});
    for (std::size_t i = 0; i < cells * static_cast<std::size_t>(nodes_of(grid.cell)); ++i)
      grid.connectivity.push_back(static_cast<std::int64_t>(random() % points));
    const auto array = [&](const char* name, int components, std::size_t entries) {
      VtuArray out{name, components, {}, components == 1 ? "N/mm^2" : ""};
      for (std::size_t i = 0; i < entries * static_cast<std::size_t>(components); ++i)
        out.values.push_back(number(random));
      return out;
    };
    grid.point_data = {array("u", 3, points), array("p", 1, points)};
    grid.cell_data = {array("sigma", 9, cells)};
    parts = 1 + static_cast<int>(random() % 5);
    for (std::size_t c = 0; c < cells; ++c)
      part.push_back(static_cast<std::int32_t>(random() % static_cast<unsigned>(parts)));
  }
};

/// All that is known of a cell: its values, and the places and values of its corners.
std::vector<double> facts(const VtuGrid& grid, std::size_t cell) {
  std::vector<double> out;
  const auto add = [&](const VtuArray& array, std::size_t entry) {
    const auto n = static_cast<std::size_t>(array.components);
    out.insert(out.end(), array.values.begin() + static_cast<std::ptrdiff_t>(n * entry),
               array.values.begin() + static_cast<std::ptrdiff_t>(n * (entry + 1)));
  };
  for (const VtuArray& array : grid.cell_data) add(array, cell);
  const auto width = static_cast<std::size_t>(nodes_of(grid.cell));
  for (std::size_t k = 0; k < width; ++k) {
    const auto point = static_cast<std::size_t>(grid.connectivity[width * cell + k]);
    out.insert(out.end(), grid.points[point].begin(), grid.points[point].end());
    for (const VtuArray& array : grid.point_data) add(array, point);
  }
  return out;
}

std::size_t cells_of(const VtuGrid& grid) {
  return grid.connectivity.size() / static_cast<std::size_t>(nodes_of(grid.cell));
}

TEST(GridPieces, HaveEveryCellOnceWithAllThatIsKnownOfIt) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const RandomGrid random(seed);
    const GridPieces pieces(random.grid, random.part, random.parts);
    ASSERT_EQ(pieces.count(), random.parts);
    std::vector<std::size_t> next(static_cast<std::size_t>(random.parts), 0);
    std::vector<VtuGrid> grids;
    grids.reserve(static_cast<std::size_t>(pieces.count()));
    for (int p = 0; p < pieces.count(); ++p) grids.push_back(pieces.piece(random.grid, p));
    for (std::size_t c = 0; c < random.part.size(); ++c) {
      const auto p = static_cast<std::size_t>(random.part[c]);
      ASSERT_LT(next[p], cells_of(grids[p])) << seed;
      EXPECT_EQ(facts(grids[p], next[p]++), facts(random.grid, c)) << seed;
    }
    for (std::size_t p = 0; p < grids.size(); ++p) {
      EXPECT_EQ(next[p], cells_of(grids[p]));
      EXPECT_EQ(grids[p].time, random.grid.time);
      const std::set<std::int64_t> used(grids[p].connectivity.begin(), grids[p].connectivity.end());
      EXPECT_EQ(used.size(), grids[p].points.size()) << "a point of no cell";
    }
  }
}

TEST(GridPieces, ComeThroughAMessageBitForBit) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const RandomGrid random(seed);
    std::stringstream bytes;
    StateWriter w(bytes);
    put_grid(w, random.grid);
    StateReader r(bytes, {});
    EXPECT_EQ(vtu_bytes(get_grid(r), {"s", "mm"}), vtu_bytes(random.grid, {"s", "mm"})) << seed;
    EXPECT_EQ(bytes.peek(), std::stringstream::traits_type::eof());
    std::istringstream cut(bytes.str().substr(0, bytes.str().size() - 1));
    StateReader short_one(cut, {});
    EXPECT_THROW(get_grid(short_one), Failure);
  }
}

TEST(GridPieces, AreNamedWithTheirArrays) {
  const RandomGrid random(7);
  const std::string text =
      pvtu_bytes(random.grid, {"s", "mm"}, std::vector<std::string>{"a&b_0.vtu", "a&b_1.vtu"});
  for (const char* part :
       {"type=\"PUnstructuredGrid\"",
        "<Piece Source=\"a&amp;b_0.vtu\"/>\n<Piece Source=\"a&amp;b_1.vtu\"/>",
        "<PDataArray type=\"Float64\" Name=\"u\" NumberOfComponents=\"3\">",
        "<PDataArray type=\"Float64\" Name=\"p\"><InformationKey name=\"UNITS_LABEL\"",
        "<PDataArray type=\"Float64\" Name=\"sigma\" NumberOfComponents=\"9\">",
        ">mm</InformationKey>"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

} // namespace
} // namespace hvi::solver
