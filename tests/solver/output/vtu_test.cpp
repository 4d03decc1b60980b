// VTU files as an independent reader (python3-meshio) sees them.
#include "solver/common/failure.hpp"
#include "solver/output/encode.hpp"
#include "solver/output/file.hpp"
#include "solver/output/vtu.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

std::string base64_of(const std::string& text) {
  return base64(std::as_bytes(std::span(text.data(), text.size())));
}

/// Runs a Python program; its exit code.
int python(const fs::path& folder, const std::string& program) {
  const auto script = folder / "check.py";
  std::ofstream(script) << program;
  return std::system(("/usr/bin/python3 '" + script.string() + "'").c_str());
}

fs::path folder_of_fields(const std::string& name) {
  auto folder = fs::path(testing::TempDir()) / ("hvi_" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

TEST(Encode, Base64MatchesRfc4648) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
}

TEST(Vtu, PaddingPutsTensorsRowByRow) {
  const auto vector = vtk_array("u", 2, {1, 2, 3, 4});
  EXPECT_EQ(vector.components, 3);
  EXPECT_EQ(vector.values, (std::vector<double>{1, 2, 0, 3, 4, 0}));
  const auto tensor = vtk_array("s", 4, {1, 2, 3, 4});
  EXPECT_EQ(tensor.components, 9);
  EXPECT_EQ(tensor.values, (std::vector<double>{1, 2, 0, 3, 4, 0, 0, 0, 0}));
}

TEST(Vtu, MeshioReadsWhatWasWritten) {
  const auto folder = folder_of_fields("vtu");
  VtuGrid grid;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  grid.connectivity = {0, 1, 2, 0, 2, 3};
  grid.point_data = {{"u & v", 3, {0, 0, 0, .1, 0, 0, 0, -2e-300, 0, 1, 2, 3}}};
  grid.cell_data = {{"sigma", 9, std::vector<double>(18, 1.0 / 3.0), "N/mm^2"}, {"p", 1, {4, 5}}};
  write_atomically(folder / "a.vtu", vtu_bytes(grid, {"s", "mm"}));
  EXPECT_EQ(0, python(folder, R"(
import meshio, sys, os
m = meshio.read(os.path.join(os.path.dirname(os.path.abspath(__file__)), "a.vtu"))
assert m.points.shape == (4, 3)
assert m.cells[0].type == "triangle" and m.cells[0].data.tolist() == [[0,1,2],[0,2,3]]
assert m.point_data["u & v"].tolist() == [[0,0,0],[.1,0,0],[0,-2e-300,0],[1,2,3]]
assert m.cell_data["sigma"][0].shape == (2, 9) and (m.cell_data["sigma"][0] == 1/3).all()
assert m.cell_data["p"][0].tolist() == [4, 5]
import xml.etree.ElementTree as E
arrays = E.parse(os.path.join(os.path.dirname(os.path.abspath(__file__)), "a.vtu")).getroot().iter("DataArray")
units = {a.get("Name"): (k.get("name"), k.get("location"), k.text) for a in arrays for k in a.findall("InformationKey")}
key = ("UNITS_LABEL", "vtkDataArray")
assert units == {"sigma": (*key, "N/mm^2"), "TimeValue": (*key, "s"), "Points": (*key, "mm")}, units
)"));
}

TEST(Vtu, ManyBlocksAndQuadraticCells) {
  const auto folder = folder_of_fields("vtu_large");
  VtuGrid grid; // 60,000 quadratic triangles side by side: several compressed blocks per array
  grid.cell = VtkCell::quadratic_triangle;
  const int n = 60000;
  VtuArray field{"f", 1, {}};
  for (int c = 0; c < n; ++c) {
    const double x = c;
    for (const auto& p : {Point{x, 0, 0}, Point{x + 1, 0, 0}, Point{x, 1, 0}, Point{x + .5, 0, 0},
                          Point{x + .5, .5, 0}, Point{x, .5, 0}}) {
      grid.connectivity.push_back(static_cast<std::int64_t>(grid.points.size()));
      grid.points.push_back(p);
      field.values.push_back(p[0] * 3 + p[1]);
    }
  }
  grid.point_data = {field};
  write_atomically(folder / "b.vtu", vtu_bytes(grid));
  EXPECT_EQ(0, python(folder, R"(
import meshio, os
m = meshio.read(os.path.join(os.path.dirname(os.path.abspath(__file__)), "b.vtu"))
assert m.cells[0].type == "triangle6" and m.cells[0].data.shape == (60000, 6)
f = m.point_data["f"]
assert (f == 3 * m.points[:, 0] + m.points[:, 1]).all()
)"));
}

TEST(Vtu, PvdIsXmlWithTheTimes) {
  const auto folder = folder_of_fields("pvd");
  write_atomically(folder / "a.pvd", pvd_bytes({{0.5, 0, "a<1>.vtu"}, {1.0, 1, "b.vtu"}}));
  EXPECT_EQ(0, python(folder, R"(
import os, xml.etree.ElementTree as E
root = E.parse(os.path.join(os.path.dirname(os.path.abspath(__file__)), "a.pvd")).getroot()
sets = root.findall("./Collection/DataSet")
assert [float(s.get("timestep")) for s in sets] == [0.5, 1.0]
assert [s.get("file") for s in sets] == ["a<1>.vtu", "b.vtu"]
)"));
}

TEST(Vtu, WrongLengthIsRefused) {
  VtuGrid grid;
  grid.points = {{0, 0, 0}};
  grid.cell = VtkCell::vertex;
  grid.connectivity = {0};
  grid.point_data = {{"u", 3, {1, 2}}};
  EXPECT_THROW(vtu_bytes(grid), Failure);
}

} // namespace
} // namespace hvi::solver
