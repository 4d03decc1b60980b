// The MSH reader: formats against each other, groups, errors, hostile input.
#include "solver/mesh/read_msh.hpp"
#include "tests/solver/mesh/helpers.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace hvi::solver::test {
namespace {

void expect_same(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.dim, b.dim);
  EXPECT_EQ(a.cells, b.cells);
  ASSERT_EQ(a.facets.size(), b.facets.size());
  for (std::size_t f = 0; f < a.facets.size(); ++f) {
    EXPECT_EQ(a.facets[f].nodes, b.facets[f].nodes);
    EXPECT_EQ(a.facets[f].cell, b.facets[f].cell);
    EXPECT_EQ(a.facets[f].other, b.facets[f].other);
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t n = 0; n < a.nodes.size(); ++n)
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(a.nodes[n][i], b.nodes[n][i], 1e-15); // ascii: 16 digits
  ASSERT_EQ(a.groups.size(), b.groups.size());
  for (const auto& [name, group] : a.groups) {
    ASSERT_TRUE(b.groups.contains(name)) << name;
    EXPECT_EQ(b.groups.at(name).kind, group.kind) << name;
    EXPECT_EQ(b.groups.at(name).entities, group.entities) << name;
  }
}

TEST(ReadMsh, AllFormatsGiveTheSameMesh) {
  for (const std::string part : {"plate", "block"}) {
    const Mesh first = read_msh(data_file(part + "_41_ascii.msh"));
    check_mesh(first);
    for (const char* format :
         {"41_binary", "41_big_endian", "22_ascii", "22_binary", "22_big_endian"}) {
      SCOPED_TRACE(part + format);
      expect_same(first, read_msh(data_file(part + "_" + format + ".msh")));
    }
  }
}

TEST(ReadMsh, PlaneGroups) {
  const Mesh mesh = read_msh(data_file("plate_41_ascii.msh"));
  EXPECT_EQ(mesh.dim, 2);
  EXPECT_EQ(mesh.groups.size(), 6U);
  EXPECT_NEAR(group_measure(mesh, "soft"), 1, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "hard"), 1, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "left"), 1, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "ground"), 2, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "seam"), 1, 1e-14);
  ASSERT_EQ(mesh.groups.at("corner").entities.size(), 1U);
  EXPECT_EQ(mesh.nodes[mesh.groups.at("corner").entities[0]], (Point{0, 0, 0}));
  const double side = facet_normal(mesh, mesh.groups.at("seam").entities[0])[0];
  EXPECT_NEAR(std::abs(side), 1, 1e-14);
  for (const auto f : mesh.groups.at("seam").entities) {
    EXPECT_GE(mesh.facets[f].other, 0);
    EXPECT_NEAR(facet_normal(mesh, f)[0], side, 1e-14) << "one side of the seam throughout";
  }
}

TEST(ReadMsh, SolidGroups) {
  const Mesh mesh = read_msh(data_file("block_41_binary.msh"));
  EXPECT_EQ(mesh.dim, 3);
  EXPECT_NEAR(total_measure(mesh), 2, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "soft"), 1, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "left"), 1, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "ground"), 2, 1e-14);
  EXPECT_NEAR(group_measure(mesh, "7"), 1, 1e-14) << "a group without a name: its tag";
  for (const auto f : mesh.groups.at("seam").entities) EXPECT_GE(mesh.facets[f].other, 0);
  EXPECT_EQ(mesh.groups.at("rail").kind, Group::Kind::points);
  EXPECT_TRUE(mesh.groups.at("rail").of_lines);
  for (const auto n : mesh.groups.at("rail").entities) {
    EXPECT_NEAR(mesh.nodes[n][1], 0, 1e-15);
    EXPECT_NEAR(mesh.nodes[n][2], 0, 1e-15);
  }
  EXPECT_GT(mesh.groups.at("rail").entities.size(), 4U);
  EXPECT_EQ(mesh.groups.at("corner").entities.size(), 1U);
}

TEST(ReadMsh, SecondOrderKeepsTheCorners) {
  for (const std::string part : {"plate", "block"}) {
    const Mesh first = read_msh(data_file(part + "_41_ascii.msh"));
    const Mesh second = read_msh(data_file(part + "_41_second_order.msh"));
    check_mesh(second);
    EXPECT_EQ(second.nodes.size(), first.nodes.size()) << "midpoints are dropped";
    EXPECT_EQ(second.cells.size(), first.cells.size());
    for (const auto& [name, group] : first.groups) {
      if (group.kind == Group::Kind::points) continue;
      EXPECT_NEAR(group_measure(second, name), group_measure(first, name), 1e-13) << name;
    }
  }
}

TEST(ReadMsh, CaseFiles) {
  const Mesh cross = read_msh(data_file("cross_5x2.msh"));
  check_mesh(cross);
  EXPECT_EQ(cross.nodes.size(), 28U);
  EXPECT_EQ(cross.cells.size(), 40U);
  EXPECT_NEAR(total_measure(cross), 2.5, 1e-14);
  const Mesh strip = read_msh(data_file("zigzag_33x5.msh"));
  check_mesh(strip);
  EXPECT_EQ(strip.nodes.size(), 204U);
  EXPECT_NEAR(total_measure(strip), 8e-4, 1e-15);
  for (const auto& [name, measure] :
       {std::pair{"bottom", 0.08}, {"top", 0.08}, {"left", 0.01}, {"right", 0.01}})
    EXPECT_NEAR(group_measure(strip, name), measure, 1e-15) << name;
}

/// ---- small files written here ------------------------------------------------------------------

std::string msh2(const std::string& nodes, const std::string& elements,
                 const std::string& names = "") {
  const auto lines = [](const std::string& s) { return std::count(s.begin(), s.end(), '\n'); };
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  if (!names.empty())
    text += fmt::format("$PhysicalNames\n{}\n{}$EndPhysicalNames\n", lines(names), names);
  return text + fmt::format("$Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
                            lines(nodes), nodes, lines(elements), elements);
}

const std::string square_nodes = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n";
const std::string square_cells = "1 2 2 5 1 1 2 3\n2 2 2 5 1 1 3 4\n";

Failure parse_failure(const std::string& text) {
  return failure_of([&] { parse_msh(text, "test.msh"); });
}

void expect_failure(const std::string& text, FailureKind kind, const std::string& part) {
  const Failure failure = parse_failure(text);
  EXPECT_EQ(failure.kind, kind) << failure.what();
  EXPECT_NE(std::string(failure.what()).find(part), std::string::npos)
      << failure.what() << "\n does not say: " << part;
}

TEST(ReadMsh, SparseTagsUnusedNodesAndFlippedCells) {
  const Mesh mesh = parse_msh(
      msh2("900000000 0 0 0\n7 9 9 9\n-3 0 1 0\n20 1 0 0\n", "5 2 0 900000000 -3 20\n"), "x.msh");
  check_mesh(mesh);
  EXPECT_EQ(mesh.nodes, (std::vector<Point>{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}})) << "in file order";
  EXPECT_NEAR(total_measure(mesh), 0.5, 1e-15);
  EXPECT_TRUE(mesh.groups.empty());
}

TEST(ReadMsh, WindowsLineEnds) {
  std::string text = msh2(square_nodes, square_cells, "2 5 \"the body\"\n"), windows;
  for (const char c : text) windows += c == '\n' ? "\r\n" : std::string(1, c);
  expect_same(parse_msh(text, "x.msh"), parse_msh(windows, "x.msh"));
}

TEST(ReadMsh, LinesMakeAMeshOfAnInterval) {
  const Mesh mesh =
      parse_msh(msh2("1 0 0 0\n2 1 0 0\n3 3 0 0\n", "1 15 2 1 1 1\n2 1 2 2 1 1 2\n3 1 2 2 1 3 2\n",
                     "0 1 \"wall\"\n"),
                "x.msh");
  check_mesh(mesh);
  EXPECT_EQ(mesh.dim, 1);
  EXPECT_NEAR(total_measure(mesh), 3, 1e-15);
  EXPECT_EQ(facet_normal(mesh, mesh.groups.at("wall").entities.at(0))[0], -1);
}

TEST(ReadMsh, GroupsOfSeveralKindsAndWithoutElements) {
  const Mesh mesh = parse_msh(
      msh2(square_nodes, square_cells + "3 1 2 5 1 1 2\n4 15 2 5 1 3\n", "1 9 \"nothing\"\n"),
      "x.msh");
  ASSERT_EQ(mesh.groups.size(), 4U);
  EXPECT_EQ(mesh.groups.at("5 (cells)").entities.size(), 2U);
  EXPECT_EQ(mesh.groups.at("5 (facets)").entities.size(), 1U);
  EXPECT_EQ(mesh.groups.at("5 (points)").entities.size(), 1U);
  EXPECT_TRUE(mesh.groups.at("nothing").entities.empty());
}

TEST(ReadMsh, ACellInTwoGroupsIsOneCell) {
  const std::string again = "3 2 2 6 1 1 2 3\n"; // another physical group, the same entity
  const Mesh mesh = parse_msh(msh2(square_nodes, square_cells + again), "x.msh");
  check_mesh(mesh);
  EXPECT_EQ(mesh.cells.size(), 2U);
  EXPECT_EQ(mesh.groups.at("5").entities, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(mesh.groups.at("6").entities, (std::vector<std::int32_t>{0}));
}

/// A seam of two curves that run towards each other: with a minus before the second one the facets
/// of both look the same way.
TEST(ReadMsh, TheSignOfAGroupTurnsFacetsInside) {
  for (const bool minus : {false, true}) {
    const std::string text = fmt::format(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"seam\"\n2 2 \"all\"\n"
        "$EndPhysicalNames\n$Entities\n0 2 1 0\n1 0 0 0 0 0 0 1 1 0\n2 0 0 0 0 0 0 1 {}1 0\n"
        "1 0 0 0 0 0 0 1 2 0\n$EndEntities\n"
        "$Nodes\n1 7 1 7\n2 1 0 7\n1\n2\n3\n4\n5\n6\n7\n"
        "-1 0 0\n1 0 0\n0 -1 0\n0 0 0\n0 1 0\n-1 1 0\n1 1 0\n$EndNodes\n"
        "$Elements\n3 8 1 8\n1 1 1 1\n1 3 4\n1 2 1 1\n2 5 4\n"
        "2 1 2 6\n3 1 3 4\n4 3 2 4\n5 1 4 5\n6 4 2 5\n7 1 5 6\n8 2 7 5\n$EndElements\n",
        minus ? "-" : "");
    const Mesh mesh = parse_msh(text, "x.msh");
    const auto& seam = mesh.groups.at("seam").entities;
    ASSERT_EQ(seam.size(), 2U);
    EXPECT_NEAR(facet_normal(mesh, seam[0])[0] * facet_normal(mesh, seam[1])[0], minus ? 1 : -1,
                1e-14);
  }
}

/// Nodes may come with their parameters: one on curves, two on surfaces.
TEST(ReadMsh, ParametersOfNodesAreNoCoordinates) {
  const auto mesh_of = [](bool parametric) {
    const auto more = [&](const char* parameters) { return parametric ? parameters : ""; };
    return parse_msh(
        fmt::format("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 1 1 0\n"
                    "1 0 0 0 0 0 0 1 3 0\n1 0 0 0 0 0 0 1 2 0\n$EndEntities\n"
                    "$Nodes\n2 4 1 4\n1 1 {0} 2\n1\n2\n0 0 0{1}\n1 0 0{2}\n"
                    "2 1 {0} 2\n3\n4\n1 1 0{3}\n0 1 0{3}\n$EndNodes\n"
                    "$Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 4\n$EndElements\n",
                    parametric ? 1 : 0, more(" 0.25"), more(" 0.75"), more(" 0.5 -0.5")),
        "x.msh");
  };
  expect_same(mesh_of(true), mesh_of(false));
}

/// On an interval it turns nothing: a point has no order of nodes.
TEST(ReadMsh, TheSignOfAPointOfAnIntervalSaysNothing) {
  const std::string text =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n0 1 \"wall\"\n"
      "$EndPhysicalNames\n$Entities\n1 1 0 0\n1 0 0 0 1 -1\n1 0 0 0 0 0 0 1 2 0\n$EndEntities\n"
      "$Nodes\n1 3 1 3\n1 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n3 0 0\n$EndNodes\n"
      "$Elements\n2 3 1 3\n0 1 15 1\n1 1\n1 1 1 2\n2 1 2\n3 2 3\n$EndElements\n";
  const Mesh mesh = parse_msh(text, "x.msh");
  check_mesh(mesh);
  EXPECT_EQ(facet_normal(mesh, mesh.groups.at("wall").entities.at(0))[0], -1);
}

/// A facet has one normal, whichever way its groups have it round.
TEST(ReadMsh, TellsOfFacetsThatTwoGroupsTurn) {
  for (const bool minus : {false, true}) {
    const std::string text = fmt::format(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 1 1 0\n"
        "1 0 0 0 0 0 0 2 1 {}3 0\n1 0 0 0 0 0 0 1 2 0\n$EndEntities\n"
        "$Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n-1 0 0\n1 0 0\n0 -1 0\n0 1 0\n$EndNodes\n"
        "$Elements\n2 3 1 3\n1 1 1 1\n1 3 4\n2 1 2 2\n2 1 3 4\n3 3 2 4\n$EndElements\n",
        minus ? "-" : "");
    const Mesh mesh = parse_msh(text, "x.msh");
    EXPECT_FALSE(mesh.groups.at("1").against_another);
    EXPECT_EQ(mesh.groups.at("3").against_another, minus);
    EXPECT_EQ(refine(mesh).groups.at("3").against_another, minus);
  }
}

TEST(ReadMsh, RefusesBadMeshes) {
  const auto bad = FailureKind::bad_mesh;
  const std::string name = "2 5 \"body\"\n";
  expect_failure(msh2(square_nodes, square_cells + "9 2 2 5 1 1 3 2\n", name), bad, "there twice");
  expect_failure(msh2(square_nodes, square_cells + "9 2 2 6 2 1 3 2\n", name), bad, "there twice");
  expect_failure(msh2("1 0 0 0\n2 1 1 0\n3 2 2 0\n", "8 2 2 5 1 1 2 3\n", name), bad,
                 "element 8 of group \"body\" with corners (0, 0), (1, 1), (2, 2) is degenerate");
  expect_failure(msh2(square_nodes, "8 2 2 5 1 1 2 2\n"), bad, "degenerate");
  expect_failure(msh2("1 0 0 0\n2 1 0 0\n3 1 1 .1\n", "8 2 0 1 2 3\n"), bad, "z = 0");
  expect_failure(msh2("1 0 0 0\n2 1 1 0\n", "8 1 0 1 2\n"), bad, "y = 0");
  expect_failure(msh2(square_nodes, square_cells + "9 1 2 7 1 2 4\n", "1 7 \"wall\"\n"), bad,
                 "element 9 of group \"wall\" is not a side of any cell");
  expect_failure(msh2(square_nodes + "5 2 .5 0\n", square_cells + "9 2 2 5 1 2 3 4\n"), bad,
                 "overlap");
  expect_failure(msh2("1 0 0 0\n2 1e200 0 0\n3 0 1e200 0\n", "8 2 0 1 2 3\n"), bad, "degenerate");
}

TEST(ReadMsh, RefusesBrokenFiles) {
  const auto broken = FailureKind::broken_file;
  expect_failure("", broken, "$MeshFormat");
  expect_failure("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", broken, "MSH version 4;");
  expect_failure("$MeshFormat\n4.1 2 8\n$EndMeshFormat\n", broken, "file type is 2");
  expect_failure("$MeshFormat\n4.1 0 4\n$EndMeshFormat\n", broken, "data size is 4");
  expect_failure("$MeshFormat\n4.1 1 8\nabcd\n$EndMeshFormat\n", broken, "byte order");
  expect_failure("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", broken, "ends without $Nodes");
  expect_failure("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$\n", broken, "expected a section");
  expect_failure(msh2("1 0 0 0\n1 1 0 0\n", "8 1 0 1 1\n"), broken, "two nodes have the tag 1");
  expect_failure(msh2(square_nodes, "8 2 0 1 2 9\n"), broken, "element 8 uses node 9");
  expect_failure(msh2(square_nodes, ""), broken, "no lines, triangles or tetrahedra");
  expect_failure(msh2("1 0 0 zero\n", ""), broken, "test.msh: line 6: expected a coordinate");
  expect_failure(msh2("1 0 0 nan\n", ""), broken, "not a finite number");
  expect_failure(msh2(square_nodes, "1 2 2 5 1 1 2 99999999999\n"), broken, "too large");
  expect_failure("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9999999999999\n1 0 0 0\n", broken,
                 "room for at most");
  expect_failure("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n-1\n", broken, "-1");
  expect_failure("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PartitionedEntities\n", broken,
                 "partitioned");
  expect_failure(bytes_of(data_file("quads.msh")), broken, "type 3 (quadrangles)");
  const std::string twice = "$Nodes\n0\n$EndNodes\n";
  expect_failure("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + twice + twice, broken,
                 "a second $Nodes");
}

TEST(ReadMsh, CountsAreHeldAgainstWhatIsLeft) {
  const auto broken = FailureKind::broken_file;
  // A group's tag takes two bytes at least: nine of them fit.
  expect_failure(
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n1 0 0 0\n1 0 0 0 9 1 2 3 4 5 6 7 8 9\n"
      "$EndEntities\n",
      broken, "ends without $Nodes");
  // Binary blocks of two triangles each where three triangles are announced.
  std::string text = "$MeshFormat\n2.2 1 8\n";
  const auto add = [&](auto value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  add(1);
  text += "\n$EndMeshFormat\n$Nodes\n4\n";
  for (int n = 0; n < 4; ++n) {
    add(n + 1);
    for (const double x : {n % 2 * 1.0, n / 2 * 1.0, 0.0}) add(x);
  }
  text += "\n$EndNodes\n$Elements\n3\n";
  for (int block = 0; block < 2; ++block) {
    for (const int word : {2, 2, 0}) add(word);
    for (int e = 0; e < 2; ++e)
      for (const int word : {2 * block + e + 1, 1, 2 + e, 3 + e}) add(word);
  }
  expect_failure(text + "\n$EndElements\n", broken, "a block of 2 elements where 1 are left");
}

TEST(ReadMsh, MissingFilesAndFolders) {
  EXPECT_EQ(failure_of([] { read_msh("/nowhere/mesh.msh"); }).kind, FailureKind::missing_file);
  EXPECT_EQ(failure_of([] { read_msh("/tmp"); }).kind, FailureKind::missing_file);
}

/// ---- hostile input -----------------------------------------------------------------------------

class Folder {
public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "hvi_msh_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

private:
  std::filesystem::path path_;
};

TEST(ReadMshSafety, AGeometryNamedMshIsNotExecuted) {
  const Folder folder;
  std::ofstream(folder / "a.msh") << "SystemCall \"touch " << folder / "ran"
                                  << "\";\nPoint(1) = {0, 0, 0};\n";
  const Failure failure = failure_of([&] { read_msh(folder / "a.msh"); });
  EXPECT_EQ(failure.kind, FailureKind::broken_file);
  EXPECT_NE(std::string(failure.what()).find("does not begin with $MeshFormat"), std::string::npos);
  EXPECT_NE(failure.help.find(".geo"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "ran"));
}

TEST(ReadMshSafety, AnOptionFileBesideTheMeshIsNotRead) {
  const Folder folder;
  std::filesystem::copy_file(data_file("plate_41_ascii.msh"), folder / "a.msh");
  std::ofstream(folder / "a.msh.opt") << "SystemCall \"touch " << folder / "ran"
                                      << "\";\n";
  std::ofstream(folder / "a.opt") << "SystemCall \"touch " << folder / "ran"
                                  << "\";\n";
  expect_same(read_msh(folder / "a.msh"), read_msh(data_file("plate_41_ascii.msh")));
  EXPECT_FALSE(std::filesystem::exists(folder / "ran"));
}

/// Anything but a mesh or a Failure fails the test (or crashes it, under the sanitizers too).
bool parses(const std::string& bytes) {
  try {
    parse_msh(bytes, "x.msh");
    return true;
  } catch (const Failure&) {
    return false;
  }
}

const char* const small_files[] = {
    "plate_41_ascii.msh",  "plate_41_binary.msh",     "plate_22_ascii.msh",
    "plate_22_binary.msh", "plate_22_big_endian.msh", "plate_41_big_endian.msh",
    "cross_5x2.msh"};

TEST(ReadMshSafety, EveryTruncationIsRefused) {
  for (const char* file : small_files) {
    const std::string bytes = bytes_of(data_file(file));
    const std::size_t needed = bytes.rfind("$EndElements") + std::string("$EndElements").size();
    for (std::size_t n = 0; n < needed; ++n)
      ASSERT_FALSE(parses(bytes.substr(0, n))) << file << " " << n;
    ASSERT_TRUE(parses(bytes.substr(0, needed)));
  }
}

TEST(ReadMshSafety, RandomDamageNeverCrashes) {
  std::mt19937 random(20240229);
  std::size_t refused = 0;
  for (const char* file : small_files) {
    const std::string bytes = bytes_of(data_file(file));
    for (int trial = 0; trial < 1500; ++trial) {
      std::string damaged = bytes;
      for (unsigned k = 1 + random() % 4; k > 0; --k) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
        case 0:
          damaged[at] = static_cast<char>(random());
          break;
        case 1:
          damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
          break;
        case 2:
          damaged.erase(at, 1 + random() % 9);
          break;
        default:
          damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 40));
        }
      }
      if (!parses(damaged)) ++refused;
    }
  }
  EXPECT_GT(refused, 5000U) << "damage is noticed as a rule";
}

} // namespace
} // namespace hvi::solver::test
