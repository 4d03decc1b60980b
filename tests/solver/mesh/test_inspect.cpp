// Seams, overlaps, pieces, cells of second order and the limit of degenerate cells, on small meshes
// whose faults are known by construction. tests/families/meshes.py makes many more.
#include "solver/mesh/boundary_distance.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/inspect.hpp"
#include "solver/mesh/read_msh.hpp"
#include "tests/solver/mesh/helpers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

using test::data_file;
using test::failure_of;

/// Two unit squares of two triangles each; the second one's corners at `second`.
Mesh two_squares(const std::array<Point, 4>& second) {
  Mesh mesh;
  mesh.dim = 2;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.nodes.insert(mesh.nodes.end(), second.begin(), second.end());
  mesh.cells = {{0, 1, 2, -1}, {0, 2, 3, -1}, {4, 5, 6, -1}, {4, 6, 7, -1}};
  build_facets(mesh, {});
  return mesh;
}

Mesh squares_apart(double gap) {
  return two_squares({{{1 + gap, 0, 0}, {2 + gap, 0, 0}, {2 + gap, 1, 0}, {1 + gap, 1, 0}}});
}

TEST(Inspect, NodesAtOnePlaceAreASeam) {
  const auto seam = find_seam(squares_apart(0.0));
  ASSERT_TRUE(seam);
  EXPECT_EQ(seam->doubled, 2U);
  EXPECT_EQ(seam->hanging, 0U);
  EXPECT_EQ(seam->at[0], 1.0);
  EXPECT_TRUE(find_seam(squares_apart(1e-9))) << "within 1e-8 of the body";
  EXPECT_FALSE(find_seam(squares_apart(1e-7)));
}

TEST(Inspect, ANodeInsideASideIsASeam) {
  const auto seam = find_seam(two_squares({{{1, 0.5, 0}, {2, 0.5, 0}, {2, 1.5, 0}, {1, 1.5, 0}}}));
  ASSERT_TRUE(seam);
  EXPECT_EQ(seam->doubled, 0U);
  EXPECT_EQ(seam->hanging, 2U) << "(1, 0.5) in the first square's side, (1, 1) in the second's";
}

/// Its two sides are closer than 1e-8 of its length, and that is no seam.
TEST(Inspect, AThinBodyIsNoSeam) {
  Mesh mesh = test::unit_mesh(2, {8, 1, 1});
  for (auto& p : mesh.nodes) p[1] *= 1e-10;
  EXPECT_FALSE(find_seam(mesh));
  EXPECT_FALSE(find_overlap(mesh));
}

TEST(Inspect, OverlapsWithTheirDepth) {
  for (const double depth : {1e-4, 0.1, 0.9, 1.0}) {
    const auto overlap = find_overlap(squares_apart(-depth));
    ASSERT_TRUE(overlap) << depth;
    EXPECT_LE(overlap->depth, depth * (1 + 1e-12));
    EXPECT_GT(overlap->depth, 0.2 * depth);
  }
  EXPECT_FALSE(find_overlap(squares_apart(0.0)));
  EXPECT_FALSE(find_overlap(squares_apart(-1e-7))) << "not seen, as inspect.hpp says";
}

/// The one square inside the other, without a node of the boundary near the other's boundary.
TEST(Inspect, ABodyInsideAnother) {
  const auto inside = two_squares({{{0.2, 0.3, 0}, {0.4, 0.3, 0}, {0.4, 0.5, 0}, {0.2, 0.5, 0}}});
  EXPECT_TRUE(find_overlap(inside));
}

/// A fan of triangles around one node that goes round twice: each pair of neighbours is right.
TEST(Inspect, AFanThatGoesRoundTwice) {
  Mesh mesh;
  mesh.dim = 2;
  mesh.nodes = {{0, 0, 0}};
  constexpr int n = 9;
  for (int i = 0; i < n; ++i) {
    const double angle = 4 * 3.14159265358979323846 * i / n;
    mesh.nodes.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.cells.push_back({0, 1 + i, 1 + (i + 1) % n, -1});
  }
  build_facets(mesh, {});
  EXPECT_TRUE(find_overlap(mesh));
}

TEST(Inspect, PiecesAreCountedByCommonFacets) {
  Mesh mesh = squares_apart(0.5);
  const auto pieces = measure_pieces(mesh, pieces_of(mesh));
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[1].cells, 2U);
  EXPECT_NEAR(pieces[1].measure, 1.0, 1e-15);
  EXPECT_GT(pieces[1].at[0], 1.5);
}

/// ---- second order ------------------------------------------------------------------------------

Straightening lost_of(const std::string& nodes, const std::string& elements) {
  const auto lines = [](const std::string& s) { return std::count(s.begin(), s.end(), '\n'); };
  Straightening lost;
  parse_msh(fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}$EndNodes\n$Elements\n"
                        "{}\n{}$EndElements\n",
                        lines(nodes), nodes, lines(elements), elements),
            "curved.msh", &lost);
  return lost;
}

/// One side is the parabola y = -4 h x (1 - x): the area between it and its chord is 2 h / 3.
TEST(Straightening, OfATriangleWithAParabola) {
  const auto lost = [](double h) {
    return lost_of(
        fmt::format("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0.5 {} 0\n5 0.5 0.5 0\n6 0 0.5 0\n", -h),
        "1 9 2 0 1 1 2 3 4 5 6\n");
  };
  const auto curved = lost(0.125);
  EXPECT_EQ(curved.edges, 3U);
  EXPECT_EQ(curved.curved, 1U);
  EXPECT_EQ(curved.offset, 0.125);
  EXPECT_EQ(curved.relative, 0.125);
  EXPECT_NEAR(curved.gain, -2 * 0.125 / 3, 1e-16);
  EXPECT_NEAR(lost(-0.125).gain, 2 * 0.125 / 3, 1e-16);
  EXPECT_EQ(lost(0).curved, 0U);
  EXPECT_EQ(lost(0.9e-9).curved, 0U) << "rounding";
  EXPECT_EQ(lost(1.1e-9).curved, 1U);
}

/// The middle of the edge along x of the unit tetrahedron, moved by h along z: x(l) = (l1, l2, l3 +
/// 4 l0 l1 h) with l0 = 1 - l1 - l2 - l3, so the determinant is 1 - 4 h l1.
TEST(Straightening, OfATetrahedron) {
  const auto lost = lost_of("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.5 0 0.125\n6 0.5 0.5 0\n"
                            "7 0 0.5 0\n8 0 0 0.5\n9 0 0.5 0.5\n10 0.5 0 0.5\n",
                            "1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n");
  EXPECT_EQ(lost.edges, 6U);
  EXPECT_EQ(lost.curved, 1U);
  // The integral of l1 over the unit tetrahedron is 1/24.
  EXPECT_NEAR(lost.gain, 4 * 0.125 / 24, 1e-16);
}

TEST(Straightening, FilesOfGmshAreStraight) {
  for (const char* name : {"plate_41_second_order.msh", "block_41_second_order.msh"}) {
    Straightening lost;
    read_msh(data_file(name), &lost);
    EXPECT_GT(lost.edges, 50U);
    EXPECT_EQ(lost.curved, 0U) << name;
  }
}

/// ---- degenerate cells --------------------------------------------------------------------------

/// The limit is a measure of 1e-14 of the longest edge to the power of the dimension.
TEST(Degenerate, CellsOnBothSidesOfTheLimit) {
  const auto parse = [](int dim, double height) {
    const std::string nodes =
        dim == 2 ? fmt::format("1 0 0 0\n2 1 0 0\n3 0.5 {} 0\n", 2 * height)
                 : fmt::format("1 0 0 0\n2 1 0 0\n3 0.5 0.5 0\n4 0.5 0.25 {}\n", 12 * height);
    const std::string elements = dim == 2 ? "1 2 2 0 1 1 2 3\n" : "1 4 2 0 1 1 2 3 4\n";
    const auto lines = [](const std::string& s) { return std::count(s.begin(), s.end(), '\n'); };
    return parse_msh(fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}$EndNodes\n"
                                 "$Elements\n{}\n{}$EndElements\n",
                                 lines(nodes), nodes, lines(elements), elements),
                     "flat.msh");
  };
  for (const int dim : {2, 3}) {
    EXPECT_NEAR(cell_measure(parse(dim, 1.1e-14), 0), 1.1e-14, 1e-19);
    EXPECT_EQ(failure_of([&] { parse(dim, 0.9e-14); }).kind, FailureKind::bad_mesh);
  }
}

/// Outside a cube it is the place with each coordinate cut to [0, 1]: on faces, edges and corners.
TEST(NearestOnBoundary, OfACubeIsTheCutPoint) {
  const std::vector<double> whole{0.0, 1.0};
  const Mesh mesh = structured_mesh(3, {whole, whole, whole});
  for (int k = 0; k < 125; ++k) {
    Point p{}, cut{};
    for (int i = 0, rest = k; i < 3; ++i, rest /= 5) {
      p[i] = std::array{-0.7, 0.2, 0.45, 0.8, 1.6}[static_cast<std::size_t>(rest % 5)];
      cut[i] = std::clamp(p[i], 0.0, 1.0);
    }
    if (p == cut) continue; // inside
    const NearestOnBoundary found = nearest_on_boundary(mesh, p);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.at[i], cut[i], 1e-14) << k;
  }
}

/// Against the nearest of many places on the facets.
TEST(NearestOnBoundary, IsAsNearAsAnyPlaceOfIt) {
  constexpr int n = 40;
  for (const int dim : {1, 2, 3}) {
    const Mesh mesh = test::shaken_mesh(dim, 3, 5);
    for (int trial = 0; trial < 40; ++trial) {
      Point p{};
      for (int i = 0; i < dim; ++i) p[i] = 0.5 + 2 * std::sin(1.7 * trial + 2.9 * i);
      const auto away = [&](const Point& x) {
        return std::hypot(x[0] - p[0], x[1] - p[1], x[2] - p[2]);
      };
      const NearestOnBoundary found = nearest_on_boundary(mesh, p);
      double best = 1e300;
      for (const Facet& f : mesh.facets)
        for (int a = 0; f.other < 0 && a <= (dim > 1 ? n : 0); ++a)
          for (int b = 0; b <= (dim > 2 ? n - a : 0); ++b) {
            const double parts[3] = {1.0 - double(a + b) / n, double(a) / n, double(b) / n};
            Point x{};
            for (int k = 0; k < dim; ++k)
              for (int i = 0; i < dim; ++i) x[i] += parts[k] * mesh.nodes[f.nodes[k]][i];
            best = std::min(best, away(x));
          }
      EXPECT_LE(found.distance, best + 1e-12);
      EXPECT_GE(found.distance, best - 0.02);
      EXPECT_NEAR(away(found.at), found.distance, 1e-12);
    }
  }
}

} // namespace
} // namespace hvi::solver
