// Structured meshes, facets, refinement, locator, quality.
#include "solver/mesh/facet_table.hpp"
#include "tests/solver/mesh/helpers.hpp"

#include <cmath>

namespace hvi::solver::test {
namespace {

TEST(Structured, CountsMeasuresAndSides) {
  const Mesh line = unit_mesh(1, {5, 0, 0});
  const Mesh square = unit_mesh(2, {3, 4, 0});
  const Mesh cube = unit_mesh(3, {2, 3, 4});
  EXPECT_EQ(line.cells.size(), 5U);
  EXPECT_EQ(square.cells.size(), 2U * 3 * 4);
  EXPECT_EQ(cube.cells.size(), 6U * 2 * 3 * 4);
  EXPECT_EQ(line.facets.size(), 2U);
  EXPECT_EQ(square.facets.size(), 2U * (3 + 4));
  EXPECT_EQ(cube.facets.size(), 2U * 2 * (2 * 3 + 3 * 4 + 2 * 4));
  for (const Mesh* mesh : {&line, &square, &cube}) {
    check_mesh(*mesh);
    EXPECT_EQ(euler_characteristic(*mesh), 1) << "a ball has Euler characteristic 1";
    EXPECT_NEAR(total_measure(*mesh), 1, 1e-14);
    EXPECT_EQ(mesh->groups.size(), 2U * mesh->dim);
  }
}

TEST(FacetTable, FindsBothSidesOfEachFacetAndNoMore) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = unit_mesh(dim, {3, 2, 2});
    const FacetTable table(mesh);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      for (int local = 0; local <= dim; ++local) {
        const FacetKey key = facet_key(dim, local_facet(dim, mesh.cells[c], local));
        std::set<std::size_t> cells; // that have all of its nodes
        for (std::size_t other = 0; other < mesh.cells.size(); ++other) {
          const auto& nodes = mesh.cells[other];
          if (std::all_of(key.nodes.begin(), key.nodes.begin() + dim, [&](std::int32_t n) {
                return std::find(nodes.begin(), nodes.begin() + dim + 1, n) !=
                       nodes.begin() + dim + 1;
              }))
            cells.insert(other);
        }
        const auto run = table.find(key);
        std::set<std::size_t> found;
        for (std::size_t i = run.begin; i < run.end; ++i)
          found.insert(static_cast<std::size_t>(table.sides()[i].cell));
        EXPECT_EQ(run.end - run.begin, cells.size());
        EXPECT_EQ(found, cells);
      }
  }
}

TEST(Structured, SidesLieWhereTheirNamesSay) {
  const std::array<std::vector<double>, 3> lines{{{-1, 0, 2.5}, {3, 4, 4.5, 7}, {-2, -1.5, 8}}};
  const std::map<std::string, std::pair<int, int>> sides{{"left", {0, 0}},   {"right", {0, 1}},
                                                         {"bottom", {1, 0}}, {"top", {1, 1}},
                                                         {"back", {2, 0}},   {"front", {2, 1}}};
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = structured_mesh(dim, lines);
    for (const auto& [name, place] : sides) {
      const auto [axis, end] = place;
      ASSERT_EQ(mesh.groups.contains(name), axis < dim) << name;
      if (axis >= dim) continue;
      double wanted = 1;
      for (int a = 0; a < dim; ++a)
        if (a != axis) wanted *= lines[a].back() - lines[a].front();
      EXPECT_NEAR(group_measure(mesh, name), wanted, 1e-13) << name;
      for (const auto f : mesh.groups.at(name).entities) {
        EXPECT_EQ(facet_normal(mesh, f)[axis], end ? 1 : -1) << name;
        for (int k = 0; k < dim; ++k)
          EXPECT_EQ(mesh.nodes[mesh.facets[f].nodes[k]][axis],
                    end ? lines[axis].back() : lines[axis].front());
      }
    }
  }
}

TEST(Structured, RectanglesAreCutFromLowerLeftToUpperRight) {
  const Mesh mesh = unit_mesh(2, {1, 1, 0});
  ASSERT_EQ(mesh.cells.size(), 2U);
  for (const auto& c : mesh.cells) { // nodes 0 and 3 are the ends of the diagonal
    EXPECT_TRUE(std::count(c.begin(), c.begin() + 3, 0));
    EXPECT_TRUE(std::count(c.begin(), c.begin() + 3, 3));
  }
}

TEST(Structured, BoxesAreKuhns) {
  const Mesh mesh = unit_mesh(3, {1, 1, 1});
  std::set<std::set<std::int32_t>> cells, wanted;
  for (const auto& c : mesh.cells) cells.insert({c.begin(), c.end()});
  std::array<int, 3> axes{0, 1, 2};
  do { // node index = x + 2 y + 4 z
    const int a = 1 << axes[0], b = a + (1 << axes[1]);
    wanted.insert({0, a, b, 7});
  } while (std::next_permutation(axes.begin(), axes.end()));
  EXPECT_EQ(cells, wanted);
}

TEST(Structured, NodesAreLexicographic) {
  const Mesh mesh = unit_mesh(3, {2, 3, 4});
  EXPECT_TRUE(
      std::is_sorted(mesh.nodes.begin(), mesh.nodes.end(), [](const Point& a, const Point& b) {
        return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
      }));
}

TEST(Structured, FacetsAreThoseOfAnyMesh) {
  const std::vector<double> x{0, 1, 2.5, 3}, y{0, 1, 4}, z{0, 2, 3};
  for (int dim = 1; dim <= 3; ++dim)
    for (const bool crossed : {false, true}) {
      const Mesh mesh = structured_mesh(dim, {x, y, z}, crossed);
      Mesh same = mesh;
      build_facets(same, {}); // from all sides of all cells
      ASSERT_EQ(mesh.facets.size(), same.facets.size());
      for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        EXPECT_EQ(mesh.facets[f].nodes, same.facets[f].nodes);
        EXPECT_EQ(mesh.facets[f].cell, same.facets[f].cell);
        EXPECT_EQ(mesh.facets[f].other, -1);
      }
    }
}

TEST(Structured, RefusesWhatCannotBeMeshed) {
  const auto kind = [](int dim, std::array<std::vector<double>, 3> lines) {
    return failure_of([&] { structured_mesh(dim, lines); }).kind;
  };
  EXPECT_EQ(kind(4, {}), FailureKind::bad_value);
  EXPECT_EQ(kind(1, {{{0}, {}, {}}}), FailureKind::bad_value);
  EXPECT_EQ(kind(1, {{{0, 1, 1}, {}, {}}}), FailureKind::bad_value);
  EXPECT_EQ(kind(1, {{{0, std::nan("")}, {}, {}}}), FailureKind::bad_value);
  EXPECT_EQ(failure_of([] { uniform_coordinates(0, 1, 0); }).kind, FailureKind::bad_value);
  const auto many = uniform_coordinates(0, 1, 1000);
  EXPECT_EQ(kind(3, {many, many, many}), FailureKind::limit);
}

TEST(Facets, NamedInteriorFacetsPointOutOfTheSideTheirOrderChooses) {
  Mesh mesh = unit_mesh(2, {2, 1, 0}); // nodes 0 1 2 / 3 4 5; the middle line is 1-4
  const auto index = build_facets(mesh, {{1, 4, -1}, {4, 1, -1}, {0, 1, -1}});
  EXPECT_EQ(index[0], index[1]) << "one facet, named twice";
  EXPECT_EQ(mesh.facets.size(), 7U);
  EXPECT_EQ(index[0], 6) << "after the boundary";
  EXPECT_LT(index[2], 6) << "a boundary facet that has a name";
  EXPECT_EQ(facet_normal(mesh, index[0])[0], 1) << "to the right of 1 -> 4 (upwards)";
  EXPECT_GE(mesh.facets[index[0]].other, 0);
  const auto reversed = build_facets(mesh, {{4, 1, -1}});
  EXPECT_EQ(facet_normal(mesh, reversed[0])[0], -1);
  check_mesh(mesh);
}

TEST(Facets, NamedInteriorFacetsInSpaceAndOnALine) {
  Mesh cube = unit_mesh(3, {1, 1, 1});
  for (const auto& nodes : {std::array{0, 1, 7}, std::array{1, 0, 7}}) {
    const auto f = build_facets(cube, {{nodes[0], nodes[1], nodes[2]}})[0];
    // The right-hand normal of (0,0,0), (1,0,0), (1,1,1) is (0, -1, 1)/sqrt 2.
    EXPECT_NEAR(facet_normal(cube, f)[2], (nodes[0] == 0 ? 1 : -1) / std::sqrt(2.0), 1e-15);
    check_mesh(cube);
  }
  Mesh line = unit_mesh(1, {2, 0, 0});
  const auto f = build_facets(line, {{1, -1, -1}})[0];
  EXPECT_EQ(facet_normal(line, f)[0], 1);
  EXPECT_EQ(line.facets[f].cell, 0);
  check_mesh(line);
}

TEST(Facets, RefusesFacetsOfNoCellAndOverlaps) {
  Mesh mesh = unit_mesh(2, {1, 1, 0});
  EXPECT_EQ(failure_of([&] { build_facets(mesh, {{1, 2, -1}}); }).kind, FailureKind::bad_mesh);
  Mesh folded;
  folded.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  folded.cells = {{0, 1, 2, -1}, {0, 1, 3, -1}};
  const Failure overlap = failure_of([&] { build_facets(folded, {}); });
  EXPECT_EQ(overlap.kind, FailureKind::bad_mesh);
  EXPECT_NE(std::string(overlap.what()).find("(0, 0), (1, 0)"), std::string::npos)
      << overlap.what();
  folded.cells.push_back({1, 0, 2, -1});
  EXPECT_EQ(failure_of([&] { build_facets(folded, {}); }).kind, FailureKind::bad_mesh);
}

TEST(Refine, IsConformingAndInheritsGroups) {
  for (int dim = 1; dim <= 3; ++dim) {
    Mesh coarse = shaken_mesh(dim, 3, 7);
    coarse.groups["some"] = {Group::Kind::cells, {0, 2}};
    coarse.groups["pin"] = {Group::Kind::points, {1}};
    const Mesh fine = refine(coarse);
    check_mesh(fine);
    EXPECT_EQ(euler_characteristic(fine), 1);
    EXPECT_EQ(fine.cells.size(), coarse.cells.size() << dim);
    EXPECT_NEAR(total_measure(fine), total_measure(coarse), 1e-13);
    EXPECT_EQ(fine.groups.size(), coarse.groups.size());
    EXPECT_EQ(fine.groups.at("pin").entities, coarse.groups.at("pin").entities);
    for (const auto& [name, group] : coarse.groups) {
      if (group.kind == Group::Kind::points) continue;
      EXPECT_EQ(fine.groups.at(name).kind, group.kind);
      EXPECT_NEAR(group_measure(fine, name), group_measure(coarse, name), 1e-13) << name;
    }
  }
}

TEST(Refine, KeepsInteriorFacetsAndTheirSide) {
  Mesh mesh = unit_mesh(2, {2, 1, 0});
  mesh.groups["seam"] = {Group::Kind::facets, build_facets(mesh, {{4, 1, -1}})};
  const Mesh fine = refine(mesh);
  ASSERT_EQ(fine.groups.at("seam").entities.size(), 2U);
  for (const auto f : fine.groups.at("seam").entities) {
    EXPECT_GE(fine.facets[f].other, 0);
    EXPECT_EQ(facet_normal(fine, f)[0], -1);
  }
}

/// Children belong to the piece of their parent, in whose order they stand; a section stays one.
TEST(Refine, KeepsPiecesAndAxes) {
  for (int dim = 1; dim <= 3; ++dim) {
    Mesh mesh = shaken_mesh(dim, 3, 7);
    mesh.pieces = {0, 2};
    mesh.axisymmetric = dim == 2;
    const Mesh fine = refine(mesh);
    EXPECT_EQ(fine.axisymmetric, mesh.axisymmetric);
    for (std::size_t c = 0; c < fine.cells.size(); ++c)
      EXPECT_EQ(fine.piece_of_cell(static_cast<std::int32_t>(c)),
                mesh.piece_of_cell(static_cast<std::int32_t>(c >> dim)));
  }
}

using Corners = std::set<std::array<long, 3>>;
std::set<Corners> cells_as_points(const Mesh& mesh, double unit) {
  std::set<Corners> cells;
  for (const auto& c : mesh.cells) {
    Corners corners;
    for (int k = 0; k <= mesh.dim; ++k) {
      std::array<long, 3> p;
      for (int a = 0; a < 3; ++a) p[a] = std::lround(mesh.nodes[c[k]][a] / unit);
      corners.insert(p);
    }
    cells.insert(corners);
  }
  return cells;
}

// Red and Bey refinement of a structured mesh is the structured mesh with twice the cells.
TEST(Refine, OfAStructuredMeshIsTheFinerStructuredMesh) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh fine = refine(refine(unit_mesh(dim, {1, 2, 1})));
    const Mesh direct = unit_mesh(dim, {4, 8, 4});
    EXPECT_EQ(cells_as_points(fine, 1.0 / 64), cells_as_points(direct, 1.0 / 64)) << dim;
  }
}

// Bey 1995: at most three shapes up to similarity, whatever the tetrahedron.
TEST(Refine, MakesAtMostThreeShapesOfATetrahedron) {
  Mesh mesh;
  mesh.dim = 3;
  mesh.nodes = {{0, 0, 0}, {1, 0.2, 0.1}, {0.3, 1.1, -0.1}, {0.4, 0.2, 0.9}};
  for (const std::array<std::int32_t, 4>& start :
       {std::array{0, 1, 2, 3}, std::array{3, 1, 0, 2}, std::array{2, 0, 1, 3}}) {
    mesh.cells = {start};
    ASSERT_GT(cell_measure(mesh, 0), 0);
    build_facets(mesh, {});
    const Mesh fine = refine(refine(refine(refine(mesh))));
    std::set<std::array<long, 6>> shapes;
    for (const auto& c : fine.cells) {
      std::array<long, 6> edges;
      int n = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j)
          edges[n++] = std::lround(1e6 * 16 *
                                   std::hypot(fine.nodes[c[i]][0] - fine.nodes[c[j]][0],
                                              fine.nodes[c[i]][1] - fine.nodes[c[j]][1],
                                              fine.nodes[c[i]][2] - fine.nodes[c[j]][2]));
      std::sort(edges.begin(), edges.end());
      shapes.insert(edges);
    }
    EXPECT_LE(shapes.size(), 3U);
  }
}

TEST(Refine, StopsAtTheLimit) {
  Mesh mesh;
  mesh.dim = 3;
  mesh.cells.resize(50'000'000 / 8 + 1); // refused by their number, before they are looked at
  EXPECT_EQ(failure_of([&] { refine(mesh); }).kind, FailureKind::limit);
}

/// The cell found by trying all, with its barycentric coordinates by solving for them.
bool cell_holds(const Mesh& mesh, int cell, const Point& p, double slack) {
  Mesh part;
  part.dim = mesh.dim;
  for (int k = 0; k <= mesh.dim; ++k) part.nodes.push_back(mesh.nodes[mesh.cells[cell][k]]);
  part.cells = {{0, 1, 2, 3}};
  const double whole = cell_measure(part, 0);
  for (int k = 0; k <= mesh.dim; ++k) {
    const Point kept = part.nodes[k];
    part.nodes[k] = p;
    if (cell_measure(part, 0) < -slack * whole) return false;
    part.nodes[k] = kept;
  }
  return true;
}

TEST(Locator, AgreesWithBruteForce) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = shaken_mesh(dim, 5, 3);
    const CellLocator locator(mesh), without_tree(mesh, 3);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> at(-0.1, 1.4);
    int inside = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      Point p{};
      for (int a = 0; a < dim; ++a) p[a] = at(random);
      std::array<double, 4> lambda{};
      const int found = locator.find(p, lambda);
      std::array<double, 4> same{};
      ASSERT_EQ(without_tree.find(p, same), found);
      ASSERT_EQ(same, lambda);
      bool any = false;
      for (std::size_t c = 0; c < mesh.cells.size() && !any; ++c)
        any = cell_holds(mesh, static_cast<int>(c), p, 1e-9);
      ASSERT_EQ(found >= 0, any);
      if (found < 0) continue;
      ++inside;
      ASSERT_TRUE(cell_holds(mesh, found, p, 1e-9));
      Point back{};
      double sum = 0;
      for (int k = 0; k <= dim; ++k) {
        sum += lambda[k];
        for (int a = 0; a < 3; ++a) back[a] += lambda[k] * mesh.nodes[mesh.cells[found][k]][a];
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      for (int a = 0; a < 3; ++a) EXPECT_NEAR(back[a], p[a], 1e-13);
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(Locator, FindsNodesEdgesAndRefusesJustOutside) {
  const Mesh mesh = unit_mesh(2, {4, 4, 0});
  std::array<double, 4> lambda{};
  for (const std::size_t points : {2, 1000}) { // without and with a tree
    const CellLocator locator(mesh, points);
    for (const auto& p : mesh.nodes) EXPECT_GE(locator.find(p, lambda), 0);
    EXPECT_GE(locator.find({1 + 1e-11, 0.5, 0}, lambda), 0) << "rounding is forgiven";
    EXPECT_EQ(locator.find({1 + 1e-8, 0.5, 0}, lambda), -1);
    EXPECT_EQ(locator.find({std::nan(""), 0.5, 0}, lambda), -1);
    EXPECT_EQ(locator.find({0.5, 0.5, 1e-3}, lambda), -1) << "above the plane of the mesh";
  }
  EXPECT_EQ(CellLocator(Mesh{}).find({0, 0, 0}, lambda), -1);
}

TEST(Locator, LooksAtFewCellsOfAStretchedAndTurnedMesh) {
  Mesh mesh = unit_mesh(2, {400, 400, 0});
  for (auto& p : mesh.nodes) p = {p[0] + 1e-3 * p[1], p[0] - 1e-3 * p[1], 0};
  for (auto& c : mesh.cells) std::swap(c[1], c[2]);
  const CellLocator locator(mesh);
  std::array<double, 4> lambda{};
  std::size_t looked_at = 0, points = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); c += 16, ++points) {
    Point centre{};
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 2; ++a) centre[a] += mesh.nodes[mesh.cells[c][k]][a] / 3;
    ASSERT_EQ(locator.find(centre, lambda, &looked_at), static_cast<int>(c));
  }
  // Turned by 45 degrees, the boxes of a leaf and of its neighbours along the diagonal overlap.
  EXPECT_LE(looked_at, 1500 * points) << "of 320,000 cells";
}

TEST(Quality, KnownShapes) {
  Mesh regular;
  regular.dim = 3;
  regular.nodes = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  regular.cells = {{0, 1, 2, 3}};
  if (cell_measure(regular, 0) < 0) std::swap(regular.cells[0][0], regular.cells[0][1]);
  EXPECT_NEAR(mesh_quality(regular).worst_aspect, 1, 1e-14);
  EXPECT_NEAR(mesh_quality(regular).h, std::sqrt(8.0), 1e-14);
  EXPECT_NEAR(mesh_quality(regular).measure, 8.0 / 3, 1e-14);

  const MeshQuality q = mesh_quality(unit_mesh(2, {2, 2, 0}));
  EXPECT_NEAR(q.shortest_edge, 0.5, 1e-15);
  EXPECT_NEAR(q.longest_edge, std::sqrt(0.5), 1e-15);
  // Right isosceles triangle with legs 1: r = (2 - sqrt 2)/2, longest sqrt 2.
  EXPECT_NEAR(q.worst_aspect, std::sqrt(2.0) / (2 - std::sqrt(2.0)) / std::sqrt(3.0), 1e-14);
  EXPECT_EQ(q.pieces, 1);
}

TEST(Quality, CountsPiecesThatShareFacets) {
  Mesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0},
                {2, 2, 0}, {9, 9, 0}, {8, 9, 0}, {9, 8, 0}};
  // Two triangles along an edge; one that touches them in a node; one apart.
  mesh.cells = {{0, 1, 2, -1}, {3, 4, 5, -1}, {1, 3, 2, -1}, {6, 7, 8, -1}};
  EXPECT_EQ(pieces_of(mesh), (std::vector<std::int32_t>{0, 1, 0, 2}));
  EXPECT_EQ(mesh_quality(mesh).pieces, 3);
}

TEST(Describe, NamesGroupsWithCountsAndMeasures) {
  Mesh mesh = unit_mesh(2, {2, 2, 0});
  mesh.groups["pin"] = {Group::Kind::points, {0}};
  mesh.groups["body"] = {Group::Kind::cells, {0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.groups.erase("top");
  const std::string text = describe_mesh(mesh);
  for (const char* part :
       {"dimension 2, 9 nodes, 8 triangles, 8 boundary facets", "[0, 1] x [0, 1]",
        "area 1, 1 connected piece", "pin", "1 points", "8 cells   area 1", "2 facets  length 1",
        "2 boundary facets are in no group"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

} // namespace
} // namespace hvi::solver::test
