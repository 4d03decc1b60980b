// Meshes made by gmsh: every geometry against the closed form of its measures.
#include "solver/mesh/gmsh_module.hpp"
#include "tests/solver/mesh/helpers.hpp"

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

namespace hvi::solver::test {
namespace {

constexpr double pi = std::numbers::pi;

const GeometryInfo& info(const std::string& name) {
  const auto& all = geometries();
  return *std::find_if(all.begin(), all.end(), [&](const auto& g) { return g.name == name; });
}

TEST(Geometry, EveryOneHasItsGroupsAndIsSound) {
  for (const auto& geometry : geometries()) {
    SCOPED_TRACE(geometry.name);
    const Mesh mesh = generate_geometry(geometry.name, {});
    check_mesh(mesh);
    EXPECT_EQ(mesh.dim, geometry.dim);
    EXPECT_EQ(mesh_quality(mesh).pieces, 1);
    EXPECT_LT(mesh_quality(mesh).worst_aspect, geometry.dim == 2 ? 3 : 8);
    std::set<std::string> found, wanted(geometry.groups.begin(), geometry.groups.end());
    std::set<std::int32_t> sides;
    std::size_t named = 0;
    for (const auto& [name, group] : mesh.groups) {
      found.insert(name);
      EXPECT_FALSE(group.entities.empty()) << name;
      if (group.kind != Group::Kind::facets) continue;
      named += group.entities.size();
      sides.insert(group.entities.begin(), group.entities.end());
    }
    EXPECT_EQ(found, wanted);
    EXPECT_EQ(sides.size(), named) << "sides do not overlap";
    EXPECT_EQ(mesh.groups.at("body").entities.size(), mesh.cells.size());
    if (geometry.name == "bracket") continue; // its flanks have no name
    EXPECT_EQ(sides.size(), mesh.facets.size()) << "the sides cover the boundary";
  }
}

/// Polygons in circles miss them by a relative (h/r)^2/24 at most.
void expect_measures(const std::string& name, const std::vector<double>& numbers, double body,
                     const std::map<std::string, double>& sides, double relative) {
  SCOPED_TRACE(name);
  const Mesh mesh = generate_geometry(name, numbers);
  EXPECT_NEAR(total_measure(mesh), body, relative * body);
  for (const auto& [side, measure] : sides)
    EXPECT_NEAR(group_measure(mesh, side), measure, relative * measure) << side;
}

TEST(Geometry, PlaneMeasures) {
  expect_measures("disk", {3, -2, 0.5, 0.03}, pi / 4, {{"rim", pi}}, 1e-3);
  expect_measures("annulus", {1, 3, 0.1}, 8 * pi, {{"inner", 2 * pi}, {"outer", 6 * pi}}, 1e-3);
  expect_measures("plate_with_hole", {4, 2, 0.5, 0.2, 0.03}, 8 - pi / 4,
                  {{"left", 2}, {"right", 2}, {"bottom", 4}, {"top", 4}, {"hole", pi}}, 1e-3);
  expect_measures("half_disk", {2, 0.1}, 2 * pi, {{"top", 4}, {"bottom", 2 * pi}}, 1e-3);
  expect_measures("quarter_disk", {2, 0.1}, pi, {{"top", 2}, {"left", 2}, {"bottom", pi}}, 1e-3);
  expect_measures("graded_rectangle", {3, 1, 0.2, 0.01}, 3,
                  {{"left", 1}, {"right", 1}, {"bottom", 3}, {"top", 3}}, 1e-12);
  expect_measures("l_shape", {2, 0.2}, 3,
                  {{"left", 2}, {"right", 1}, {"bottom", 2}, {"top", 1}, {"notch", 2}}, 1e-12);
  // Two circular segments of depth .2 are cut off: r = .5, half angle acos(.6).
  const double angle = 2 * std::acos(0.6);
  expect_measures("dogbone", {4, 1, 0.6, 0.5, 0.1, 0.02}, 4 - 0.25 * (angle - std::sin(angle)),
                  {{"left", 1}, {"right", 1}, {"bottom", 4 - 0.8}, {"notch", angle}}, 1e-3);
}

TEST(Geometry, SolidMeasures) {
  expect_measures("ball", {1, 0.12}, 4 * pi / 3, {{"surface", 4 * pi}}, 1e-2);
  expect_measures("half_ball", {2, 0.3}, 16 * pi / 3, {{"top", 4 * pi}, {"bottom", 8 * pi}},
                  1.5e-2);
  expect_measures("cylinder", {1, 3, 0.2}, 3 * pi, {{"bottom", pi}, {"top", pi}, {"side", 6 * pi}},
                  1e-2);
  const double fillet = 0.25 * (1 - pi / 4), r = 0.8;
  const double body = 4 * (8 + 5 + fillet) - 2 * pi * r * r;
  expect_measures("bracket", {8, 6, 4, 1, 0.8, 0.4, 0.2}, body,
                  {{"seat", 32 - pi * r * r},
                   {"load", 4},
                   {"tip", 4},
                   {"back", 24 - pi * r * r},
                   {"bolt", 2 * pi * r},
                   {"pin", 2 * pi * r}},
                  1e-2);
}

TEST(Geometry, SmallAndLargeBodiesHaveTheSameMesh) {
  const Mesh one = generate_geometry("half_disk", {1, 0.2, 0.05});
  for (const double scale : {std::exp2(-40), std::exp2(30)}) {
    const Mesh other = generate_geometry("half_disk", {scale, 0.2 * scale, 0.05 * scale});
    ASSERT_EQ(other.cells, one.cells);
    for (std::size_t n = 0; n < one.nodes.size(); ++n)
      for (int a = 0; a < 2; ++a) ASSERT_EQ(other.nodes[n][a], one.nodes[n][a] * scale);
  }
}

TEST(Geometry, LeavesTheLocaleAlone) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  generate_geometry("disk", {});
  EXPECT_EQ(std::setlocale(LC_ALL, nullptr), before);
}

TEST(Geometry, IsDeterministic) {
  const Mesh a = generate_geometry("bracket", {}), b = generate_geometry("bracket", {});
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.cells, b.cells);
}

/// The longest edge of the boundary that ends at a point (inside, gmsh lets cells grow faster).
double size_at(const Mesh& mesh, const Point& p) {
  const auto distance = [](const Point& a, const Point& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  };
  double size = 0;
  for (const auto& f : mesh.facets)
    for (int i = 0; i < mesh.dim; ++i)
      for (int j = 0; j < mesh.dim && distance(mesh.nodes[f.nodes[i]], p) < 1e-9; ++j)
        size = std::max(size, distance(mesh.nodes[f.nodes[j]], p));
  return size;
}

TEST(Geometry, FineSizeActsAtItsPlace) {
  const Mesh corners = generate_geometry("graded_rectangle", {2, 1, 0.2, 0.005});
  for (const Point& p : {Point{0, 0, 0}, Point{2, 0, 0}, Point{0, 1, 0}, Point{2, 1, 0}}) {
    EXPECT_GT(size_at(corners, p), 0.001);
    EXPECT_LT(size_at(corners, p), 0.01);
  }
  EXPECT_GT(mesh_quality(corners).h, 0.1);
  const Mesh pole = generate_geometry("half_ball", {1, 0.4, 0.03});
  EXPECT_LT(size_at(pole, {0, 0, 0}), 0.045);
  EXPECT_GT(size_at(pole, {0, 0, 0}), 0) << "the pole is a node";
  ASSERT_EQ(pole.groups.at("pole").entities.size(), 1U);
  const Point& at = pole.nodes[pole.groups.at("pole").entities[0]];
  EXPECT_NEAR(std::hypot(at[0], at[1], at[2]), 0, 1e-12);
}

TEST(Geometry, RefusesImpossibleNumbers) {
  const auto kind = [](const char* name, std::vector<double> numbers) {
    return failure_of([&] { generate_geometry(name, numbers); }).kind;
  };
  const auto bad = FailureKind::bad_value;
  EXPECT_EQ(kind("dsk", {}), bad);
  EXPECT_EQ(kind("disk", {1, 2}), bad);
  EXPECT_EQ(kind("disk", {0, 0, -1, 0.1}), bad);
  EXPECT_EQ(kind("disk", {0, 0, 1, std::nan("")}), bad);
  EXPECT_EQ(kind("disk", {0, 0, 1, 5}), bad);
  EXPECT_EQ(kind("annulus", {2, 1, 0.1}), bad);
  EXPECT_EQ(kind("plate_with_hole", {1, 1, 0.5, 0.1}), bad);
  EXPECT_EQ(kind("dogbone", {4, 1, 1.2, 0.5, 0.1}), bad);
  EXPECT_EQ(kind("bracket", {8, 6, 4, 1, 2.5, 0.5}), bad);
  EXPECT_EQ(kind("ball", {1, 1e-4}), FailureKind::limit);
  const Failure unknown = failure_of([] { generate_geometry("dsk", {}); });
  for (const auto& g : geometries())
    EXPECT_NE(std::string(unknown.what()).find(g.name), std::string::npos) << g.name;
  EXPECT_EQ(info("disk").groups.front(), "rim");
}

TEST(Geometry, AMissingModuleIsSaidWithTheFile) {
  ASSERT_EQ(setenv("HVI_GMSH_MODULE", "/nowhere/libhvi_gmsh.so", 1), 0);
  const Failure missing = failure_of([] { generate_geometry("disk", {}); });
  ASSERT_EQ(unsetenv("HVI_GMSH_MODULE"), 0);
  EXPECT_EQ(missing.kind, FailureKind::missing_file);
  EXPECT_NE(std::string(missing.what()).find("/nowhere/libhvi_gmsh.so"), std::string::npos);
}

TEST(GeoFile, IsMeshedWithItsGroups) {
  const auto path = std::filesystem::temp_directory_path() / "hvi_test_square.geo";
  std::ofstream(path) << "Point(1) = {0, 0, 0, .2}; Point(2) = {1, 0, 0, .2};\n"
                         "Point(3) = {1, 1, 0, .2}; Point(4) = {0, 1, 0, .2};\n"
                         "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};\n"
                         "Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};\n"
                         "Physical Curve(\"ground\") = {1}; Physical Surface(\"block\") = {1};\n";
  const Mesh mesh = mesh_geo_file(path);
  check_mesh(mesh);
  EXPECT_NEAR(group_measure(mesh, "ground"), 1, 1e-12);
  EXPECT_NEAR(group_measure(mesh, "block"), 1, 1e-12);
  EXPECT_EQ(mesh.groups.size(), 2U);
  std::ofstream(path) << "Point(1) = {0, 0 this is no geometry";
  EXPECT_EQ(failure_of([&] { mesh_geo_file(path); }).kind, FailureKind::broken_file);
  std::filesystem::remove(path);
  EXPECT_EQ(failure_of([&] { mesh_geo_file(path); }).kind, FailureKind::missing_file);
}

TEST(GeoFile, AMinusTurnsACurveInItsGroup) {
  const auto path = std::filesystem::temp_directory_path() / "hvi_test_seam.geo";
  for (const bool minus : {false, true}) {
    std::ofstream(path)
        << "Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {1, 2, 0, 1};\n"
           "Point(4) = {0, 2, 0, 1}; Point(5) = {0, 1, 0, 1}; Point(6) = {-1, 1, 0, 1};\n"
           "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {1, 5};\n"
           "Line(5) = {4, 5}; Line(6) = {4, 6}; Line(7) = {6, 1};\n"
           "Curve Loop(1) = {1, 2, 3, 5, -4}; Plane Surface(1) = {1};\n"
           "Curve Loop(2) = {4, -5, 6, 7}; Plane Surface(2) = {2};\n"
           "Physical Surface(\"body\") = {1, 2};\n"
        << "Physical Curve(\"seam\") = {4, " << (minus ? "-" : "") << "5};\n";
    const Mesh mesh = mesh_geo_file(path);
    EXPECT_NEAR(group_measure(mesh, "seam"), 2, 1e-12);
    double sum = 0;
    for (const auto f : mesh.groups.at("seam").entities)
      sum += facet_measure(mesh, f) * facet_normal(mesh, f)[0];
    EXPECT_NEAR(std::abs(sum), minus ? 2 : 0, 1e-12);
  }
  std::filesystem::remove(path);
}

/// gmsh keeps what it has not read of a file with a mistake for the next one.
TEST(GeoFile, AMistakeIsThatOfItsFileOnly) {
  const auto path = std::filesystem::temp_directory_path() / "hvi_test_mistakes.geo";
  const std::string right = "w = 2; Point(1) = {0, 0, 0, .5}; Point(2) = {w, 0, 0, .5};\n"
                            "Point(3) = {w, 1, 0, .5}; Point(4) = {0, 1, 0, .5};\n"
                            "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4};\n"
                            "Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4};\n"
                            "Plane Surface(1) = {1}; Physical Surface(\"block\") = {1};\n";
  for (const std::string mistake : {"Point(1) = {0, 0 this is no geometry",
                                    "a = ",
                                    "a = (1 + 2",
                                    "b = \"not closed",
                                    "/* no end",
                                    "If (1)\nc = 1;",
                                    "If (0)\nc = 1;",
                                    "For i In {1:3}\n",
                                    "Macro m\n",
                                    "Point(1) = {0, 0, 0};;;",
                                    "= = = = = = = = = =",
                                    "a b c d e f g\nh i j k l m\nn o p",
                                    "Error(\"stop\");",
                                    "Line(1) = {7, 8};",
                                    "Merge \"nowhere.geo\";",
                                    "Abort;",
                                    "Return\n",
                                    "EndIf\n",
                                    "}}}}",
                                    "DefineConstant[ r = ];"}) {
    std::ofstream(path) << mistake;
    try {
      mesh_geo_file(path);
    } catch (const Failure&) { // some mistakes are none
    }
    std::ofstream(path) << right;
    for (int twice = 0; twice < 2; ++twice)
      EXPECT_NEAR(group_measure(mesh_geo_file(path), "block"), 2, 1e-12) << mistake;
    std::ofstream(path) << "DefineConstant[ w = 1 ];\n" << right.substr(right.find("Point"));
    EXPECT_NEAR(group_measure(mesh_geo_file(path, nullptr, {{"w", 3.0}}), "block"), 3, 1e-12)
        << mistake;
  }
  std::filesystem::remove(path);
}

TEST(GeoFile, ConstantsAreSetForOneMeshOnly) {
  const auto path = std::filesystem::temp_directory_path() / "hvi_test_constants.geo";
  std::ofstream(path) << "// DefineConstant[ old = 1 ];\n"
                         "DefineConstant[ r = 1, h = {0.2, Name \"Parameters/h, w = 3\"} ];\n"
                         "w = 2; Point(1) = {0, 0, 0, h}; Point(2) = {w, 0, 0, h};\n"
                         "Point(3) = {w, r, 0, h}; Point(4) = {0, r, 0, h};\n"
                         "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};\n"
                         "Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};\n"
                         "Physical Surface(\"block\") = {1};\n";
  const auto area = [&](const GeoConstants& constants) {
    return group_measure(mesh_geo_file(path, nullptr, constants), "block");
  };
  EXPECT_NEAR(area({{"r", 0.75}, {"h", 0.3}}), 1.5, 1e-12);
  EXPECT_NEAR(area({}), 2, 1e-12); // nothing is left of the mesh before
  EXPECT_NEAR(area({{"h", 0.5}}), 2, 1e-12);
  for (const char* name : {"old", "w", "Parameters"})
    EXPECT_EQ(failure_of([&] { area({{name, 1.0}}); }).kind, FailureKind::bad_value) << name;
  EXPECT_EQ(geo_constants("DefineConstant [a={1,Min 0}, b, c=2*(3+d)];/* DefineConstant[e] */"),
            (std::vector<std::string>{"a", "b", "c"}));
  std::filesystem::remove(path);
}

} // namespace
} // namespace hvi::solver::test
