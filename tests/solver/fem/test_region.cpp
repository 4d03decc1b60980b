// Parts of meshes: trees of groups, unions, differences and predicates, and the mesh of a plan.
#include "solver/fem/region.hpp"
#include "solver/mesh/generate.hpp"
#include "tests/solver/fem/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace hvi::solver {
namespace {

using Kind = RegionSpec::Kind;
using test::measure_of;

Mesh square(int n) {
  return structured_mesh(2, {uniform_coordinates(0, 1, n), uniform_coordinates(0, 1, n), {}});
}

RegionSpec part(Kind kind, std::vector<RegionSpec> children = {}) {
  RegionSpec spec;
  spec.kind = kind;
  spec.origin = {42};
  spec.children = std::move(children);
  return spec;
}

RegionSpec group(const std::string& name) {
  RegionSpec spec = part(Kind::group);
  spec.name = name;
  return spec;
}

RegionSpec point(double x, double y, double z = 0) {
  RegionSpec spec = part(Kind::point);
  spec.point = {x, y, z};
  return spec;
}

RegionSpec where(RegionSpec of, Expr predicate) {
  RegionSpec spec = part(Kind::where, {std::move(of)});
  spec.predicate = std::move(predicate);
  return spec;
}

const Expr x = Expr::variable(slot::x(0)), y = Expr::variable(slot::x(1));

template <typename F>
Failure failure_of(F&& f) {
  try {
    f();
  } catch (const Failure& failure) {
    return failure;
  }
  ADD_FAILURE() << "no Failure was thrown";
  return Failure(FailureKind::interrupted, {}, "");
}

Failure resolve_failure(const Mesh& mesh, const RegionSpec& spec) {
  Failure failure = failure_of([&] { resolve(mesh, spec); });
  EXPECT_EQ(failure.origin.id, 42);
  return failure;
}

bool says(const Failure& failure, const std::string& text) {
  return std::string(failure.what()).find(text) != std::string::npos;
}

TEST(Region, CellsBoundaryAndGroups) {
  const Mesh mesh = square(4);
  const Region all = resolve(mesh, part(Kind::all_cells));
  EXPECT_EQ(all.kind, Group::Kind::cells);
  EXPECT_EQ(all.entities.size(), 32U);
  EXPECT_NEAR(measure_of(mesh, all), 1, 1e-14);
  EXPECT_EQ(nodes_of(mesh, all).size(), 25U);
  const Region boundary = resolve(mesh, part(Kind::boundary));
  EXPECT_EQ(boundary.kind, Group::Kind::facets);
  EXPECT_NEAR(measure_of(mesh, boundary), 4, 1e-14);
  EXPECT_EQ(nodes_of(mesh, boundary).size(), 16U);
  EXPECT_NEAR(measure_of(mesh, resolve(mesh, group("top"))), 1, 1e-14);
}

TEST(Region, TheBoundaryLeavesOutNamedFacetsInside) {
  Mesh mesh = square(2);
  mesh.groups.clear();
  mesh.groups["seam"] = {Group::Kind::facets, build_facets(mesh, {{1, 4, -1}, {4, 7, -1}})};
  EXPECT_EQ(resolve(mesh, part(Kind::boundary)).entities.size(), 8U);
  EXPECT_NEAR(measure_of(mesh, resolve(mesh, group("seam"))), 1, 1e-14);
}

TEST(Region, UnionsAndDifferences) {
  const Mesh mesh = square(3);
  const auto corner = part(Kind::unite, {group("left"), group("bottom")});
  EXPECT_NEAR(measure_of(mesh, resolve(mesh, corner)), 2, 1e-14);
  const auto rest = part(Kind::subtract, {part(Kind::boundary), corner});
  const Region region = resolve(mesh, rest);
  EXPECT_NEAR(measure_of(mesh, region), 2, 1e-14);
  EXPECT_TRUE(std::is_sorted(region.entities.begin(), region.entities.end()));
  EXPECT_EQ(resolve(mesh, part(Kind::unite, {corner, corner})).entities.size(), 6U);
  const auto pins = part(Kind::unite, {point(0, 0), point(1, 1)});
  EXPECT_EQ(resolve(mesh, pins).entities, (std::vector<std::int32_t>{0, 15}));
}

TEST(Region, DifferentKindsDoNotCombine) {
  const Mesh mesh = square(2);
  for (const Kind kind : {Kind::unite, Kind::subtract}) {
    const auto mixed = part(kind, {part(Kind::all_cells), group("left")});
    const Failure failure = resolve_failure(mesh, mixed);
    EXPECT_EQ(failure.kind, FailureKind::bad_value);
    EXPECT_TRUE(says(failure, "cells and facets")) << failure.what();
  }
}

TEST(Region, PredicatesSelectWholeEntities) {
  const Mesh mesh = square(4);
  const Region half = resolve(mesh, where(part(Kind::all_cells), less(x, 0.5)));
  EXPECT_NEAR(measure_of(mesh, half), 0.5, 1e-14) << "corners on the line do not matter";
  EXPECT_EQ(half.straddling, 0);
  EXPECT_EQ(half.cut.count, 0);
  const Region some = resolve(mesh, where(part(Kind::boundary), less(x, 0.3)));
  EXPECT_NEAR(measure_of(mesh, some), 1 + 2 * 0.25, 1e-14);
  EXPECT_EQ(some.straddling, 2) << "one edge at the top, one at the bottom";
  EXPECT_EQ(some.cut.count, 2);
  EXPECT_NEAR(some.cut.lost, 2 * 0.05, 1e-12);
  // A tiny disk in the middle of a cell touches neither centroid nor corners of others.
  const Region chain = resolve(mesh, where(where(group("top"), less(x, 0.5)), less(0.25, x)));
  EXPECT_NEAR(measure_of(mesh, chain), 0.25, 1e-14);
}

// More cells than one batch holds, against a loop over the corners.
TEST(Region, PredicatesAgreeWithBruteForce) {
  const Mesh mesh = square(40);
  const Expr disk = less(x * x + y * y, 0.4321);
  const Region region = resolve(mesh, where(part(Kind::all_cells), disk));
  std::vector<std::int32_t> inside;
  int cut = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    int n = 0;
    Point centre{};
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 2; ++a) centre[a] += mesh.nodes[mesh.cells[c][k]][a] / 3;
    const auto in = [](const Point& p) { return p[0] * p[0] + p[1] * p[1] < 0.4321; };
    for (int k = 0; k < 3; ++k) n += in(mesh.nodes[mesh.cells[c][k]]);
    n += in(centre);
    if (n == 4) inside.push_back(static_cast<std::int32_t>(c));
    if (n > 0 && n < 4) ++cut;
  }
  EXPECT_EQ(region.entities, inside);
  EXPECT_EQ(region.straddling, cut);
  EXPECT_GT(cut, 40);
}

TEST(Region, PredicatesOfTheNormalOnSides) {
  const Mesh mesh = square(3);
  const Expr up = less(0.5, Expr::variable(slot::normal(1)));
  EXPECT_EQ(resolve(mesh, where(part(Kind::boundary), up)).entities,
            resolve(mesh, group("top")).entities);
  const Failure cells = resolve_failure(mesh, where(part(Kind::all_cells), up));
  EXPECT_EQ(cells.kind, FailureKind::bad_value);
  const auto time = where(part(Kind::boundary), less(Expr::variable(slot::t), 1.0));
  EXPECT_EQ(resolve_failure(mesh, time).kind, FailureKind::bad_value);
}

TEST(Region, APredicateWithoutValueIsAnErrorWithThePlace) {
  const Mesh mesh = square(2);
  const Expr broken = sqrt(x - 0.9); // NaN left of .9
  const Failure failure = resolve_failure(mesh, where(group("left"), broken));
  EXPECT_EQ(failure.kind, FailureKind::bad_value);
  EXPECT_TRUE(says(failure, "NaN) at (0, 0.25)")) << failure.what();
}

TEST(Region, EmptyPartsAreErrors) {
  Mesh mesh = square(2);
  const Failure nothing = resolve_failure(mesh, where(group("left"), less(x, -1.0)));
  EXPECT_EQ(nothing.kind, FailureKind::empty_region);
  EXPECT_TRUE(nothing.help.empty());
  const Failure cut = resolve_failure(mesh, where(group("bottom"), less(x, 0.2)));
  EXPECT_EQ(cut.kind, FailureKind::empty_region);
  EXPECT_NE(cut.help.find("1 facets lie partly inside"), std::string::npos) << cut.help;
  mesh.groups["void"] = {Group::Kind::cells, {}};
  const Failure empty = resolve_failure(mesh, group("void"));
  EXPECT_EQ(empty.kind, FailureKind::empty_region);
  EXPECT_TRUE(says(empty, "`void` has no cells"));
  const auto self = part(Kind::subtract, {group("left"), group("left")});
  EXPECT_EQ(resolve_failure(mesh, self).kind, FailureKind::empty_region);
}

TEST(Region, UnknownGroupsListWhatThereIs) {
  const Failure typo = resolve_failure(square(2), group("botom"));
  EXPECT_EQ(typo.kind, FailureKind::unknown_group);
  EXPECT_TRUE(says(typo, "bottom, left, right, top")) << typo.what();
  EXPECT_EQ(typo.help, "did you mean `bottom`?");
  EXPECT_EQ(resolve_failure(square(2), group("roof of the house")).help, "");
}

TEST(Region, PointsAreNodes) {
  const Mesh mesh = square(4);
  EXPECT_EQ(resolve(mesh, point(0.25, 0.25)).entities, (std::vector<std::int32_t>{6}));
  EXPECT_EQ(resolve(mesh, point(0.25 + 1e-10, 0.25)).entities, (std::vector<std::int32_t>{6}));
  const Failure off = resolve_failure(mesh, point(0.26, 0.24));
  EXPECT_EQ(off.kind, FailureKind::bad_value);
  EXPECT_TRUE(says(off, "nearest is at (0.25, 0.25)")) << off.what();
  EXPECT_EQ(resolve_failure(mesh, point(0.25 + 1e-6, 0.25)).kind, FailureKind::bad_value);
  EXPECT_EQ(resolve_failure(mesh, point(std::nan(""), 0)).kind, FailureKind::bad_value);
}

TEST(Region, CommonEntities) {
  const Mesh mesh = square(2);
  const Region left = resolve(mesh, group("left")), boundary = resolve(mesh, part(Kind::boundary));
  EXPECT_EQ(common(left, boundary), left.entities);
  EXPECT_TRUE(common(left, resolve(mesh, group("top"))).empty()) << "a shared corner is no side";
  EXPECT_TRUE(common(left, resolve(mesh, part(Kind::all_cells))).empty());
}

TEST(MakeMesh, StructuredWithGradingAndRefinement) {
  MeshSpec spec;
  spec.kind = MeshSpec::Kind::box;
  spec.high = {2, 1, 3};
  spec.cells = {2, 1, 1};
  spec.grading[2] = {0, 0.5, 3};
  spec.refinements = 1;
  const Mesh mesh = make_mesh(spec);
  EXPECT_EQ(mesh.dim, 3);
  EXPECT_EQ(mesh.cells.size(), 6U * 2 * 2 * 8);
  EXPECT_NEAR(mesh_quality(mesh).measure, 6, 1e-13);
  spec.kind = MeshSpec::Kind::interval;
  EXPECT_EQ(make_mesh(spec).cells.size(), 4U);
}

TEST(MakeMesh, FailuresPointToTheMeshStatement) {
  const auto kind_of = [](MeshSpec spec) {
    spec.origin = {7};
    const Failure failure = failure_of([&] { make_mesh(spec); });
    EXPECT_EQ(failure.origin.id, 7);
    return failure.kind;
  };
  MeshSpec spec;
  spec.cells = {0, 1, 1};
  EXPECT_EQ(kind_of(spec), FailureKind::bad_value);
  spec.cells = {1, 1, 1};
  spec.high = {0, 1, 1};
  EXPECT_EQ(kind_of(spec), FailureKind::bad_value);
  spec.high = {1, 1, 1};
  spec.refinements = -1;
  EXPECT_EQ(kind_of(spec), FailureKind::bad_value);
  spec.refinements = 20;
  EXPECT_EQ(kind_of(spec), FailureKind::limit);
  spec.refinements = 0;
  spec.grading[0] = {0, 1, 0.5};
  EXPECT_EQ(kind_of(spec), FailureKind::bad_value);
  spec.kind = MeshSpec::Kind::file;
  spec.path = "/nowhere/a.msh";
  EXPECT_EQ(kind_of(spec), FailureKind::missing_file);
}

TEST(MakeMesh, AGeoFileNeedsPermission) {
  const auto folder = std::filesystem::temp_directory_path();
  MeshSpec spec;
  spec.kind = MeshSpec::Kind::file;
  spec.path = folder / "hvi_region_test.geo";
  const auto ran = folder / "hvi_region_test_ran";
  std::filesystem::remove(ran);
  std::ofstream(spec.path)
      << "SystemCall \"touch " << ran.string()
      << "\";\nSetFactory(\"OpenCASCADE\");\nRectangle(1) = {0, 0, 0, 1, 1};\n";
  const Failure failure = failure_of([&] { make_mesh(spec); });
  EXPECT_EQ(failure.kind, FailureKind::unasked_geometry);
  EXPECT_FALSE(std::filesystem::exists(ran));
  spec.allow_geo = true;
  EXPECT_NEAR(mesh_quality(make_mesh(spec)).measure, 1, 1e-12);
  EXPECT_TRUE(std::filesystem::exists(ran)) << "it does run programs";
  std::filesystem::remove(spec.path);
  std::filesystem::remove(ran);
}

TEST(MakeMesh, GeometriesAndFiles) {
  MeshSpec spec;
  spec.kind = MeshSpec::Kind::geometry;
  spec.geometry = "annulus";
  spec.numbers = {1, 2, 0.3};
  EXPECT_NEAR(mesh_quality(make_mesh(spec)).measure, 3 * 3.14159, 0.1);
  spec.kind = MeshSpec::Kind::file;
  spec.path = std::string(HVI_SOURCE_DIR) + "/tests/data/cross_5x2.msh";
  spec.refinements = 1;
  const Mesh mesh = make_mesh(spec);
  EXPECT_EQ(mesh.cells.size(), 160U);
  EXPECT_NEAR(measure_of(mesh, resolve(mesh, group("bottom"))), 2.5, 1e-14);
}

} // namespace
} // namespace hvi::solver
