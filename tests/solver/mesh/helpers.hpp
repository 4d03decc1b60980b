// Meshes and checks shared by the tests of solver/mesh.
#pragma once

#include "solver/common/failure.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>

namespace hvi::solver::test {

inline std::string data_file(const std::string& name) {
  return std::string(HVI_SOURCE_DIR) + "/tests/data/" + name;
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline Mesh unit_mesh(int dim, std::array<int, 3> cells) {
  std::array<std::vector<double>, 3> lines;
  for (int a = 0; a < dim; ++a) lines[a] = uniform_coordinates(0, 1, cells[a]);
  return structured_mesh(dim, lines);
}

/// A box with uneven lines, sheared and with its inner nodes shaken: no cell like another.
inline Mesh shaken_mesh(int dim, int cells, unsigned seed) {
  Mesh mesh = unit_mesh(dim, {cells, cells, cells});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.12 / cells, 0.12 / cells);
  for (auto& p : mesh.nodes) {
    const Point old = p;
    bool inner = true;
    for (int a = 0; a < dim; ++a) inner = inner && old[a] > 1e-12 && old[a] < 1 - 1e-12;
    for (int a = 0; a < dim; ++a) p[a] += inner ? shake(random) : 0.0;
    if (dim > 1) p[0] += 0.3 * p[1];
  }
  return mesh;
}

inline double total_measure(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    sum += cell_measure(mesh, static_cast<int>(c));
  return sum;
}

inline double group_measure(const Mesh& mesh, const std::string& name) {
  double sum = 0;
  const Group& group = mesh.groups.at(name);
  for (const auto e : group.entities)
    sum += group.kind == Group::Kind::cells ? cell_measure(mesh, e) : facet_measure(mesh, e);
  return sum;
}

/// The mesh with a failure's kind and text, for EXPECT on both.
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

/// What every mesh must satisfy, by brute force and independent of build_facets:
/// positive cells; each facet on one cell iff in the boundary list; outward normals; sum of
/// boundary normals zero; volume by the divergence theorem; groups sorted, unique, in range.
inline void check_mesh(const Mesh& mesh) {
  const int d = mesh.dim;
  std::map<std::set<std::int32_t>, int> sides;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    ASSERT_GT(cell_measure(mesh, static_cast<int>(c)), 0);
    for (int skip = 0; skip <= d; ++skip) {
      std::set<std::int32_t> key;
      for (int k = 0; k <= d; ++k)
        if (k != skip) key.insert(mesh.cells[c][k]);
      ++sides[key];
    }
  }
  const double size = bounding_box(mesh).diagonal();
  Point closed{};
  double volume = 0, surface = 0;
  std::size_t boundary = 0;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const Facet& facet = mesh.facets[f];
    const std::set<std::int32_t> key(facet.nodes.begin(), facet.nodes.begin() + d);
    ASSERT_EQ(sides.at(key), facet.other < 0 ? 1 : 2);
    const Point n = facet_normal(mesh, static_cast<int>(f));
    const Point& on = mesh.nodes[facet.nodes[0]];
    double out = 0; // the opposite corner lies behind the facet
    for (int k = 0; k <= d; ++k)
      for (int a = 0; a < 3; ++a) out += n[a] * (mesh.nodes[mesh.cells[facet.cell][k]][a] - on[a]);
    ASSERT_LT(out, 0);
    if (facet.other >= 0) continue;
    ++boundary;
    const double measure = facet_measure(mesh, static_cast<int>(f));
    surface += measure;
    for (int a = 0; a < 3; ++a) closed[a] += measure * n[a];
    for (int k = 0; k < d; ++k)
      for (int a = 0; a < d; ++a)
        volume += measure * n[a] * mesh.nodes[facet.nodes[k]][a] / (d * d);
  }
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(closed[a], 0, 1e-12 * surface);
  EXPECT_NEAR(volume, total_measure(mesh), 1e-12 * surface * size);
  EXPECT_EQ(boundary,
            static_cast<std::size_t>(std::count_if(sides.begin(), sides.end(),
                                                   [](const auto& s) { return s.second == 1; })));
  for (const auto& [name, group] : mesh.groups) {
    const auto& e = group.entities;
    EXPECT_TRUE(std::is_sorted(e.begin(), e.end())) << name;
    EXPECT_EQ(std::adjacent_find(e.begin(), e.end()), e.end()) << name;
    const auto limit = group.kind == Group::Kind::cells    ? mesh.cells.size()
                       : group.kind == Group::Kind::facets ? mesh.facets.size()
                                                           : mesh.nodes.size();
    if (!e.empty()) {
      EXPECT_GE(e.front(), 0) << name;
      EXPECT_LT(static_cast<std::size_t>(e.back()), limit) << name;
    }
  }
}

/// Alternating sum of the numbers of vertices, edges, faces, cells, each counted as a set.
inline long euler_characteristic(const Mesh& mesh) {
  std::set<std::set<std::int32_t>> simplices;
  for (const auto& c : mesh.cells) {
    for (unsigned mask = 1; mask < (2U << mesh.dim); ++mask) {
      std::set<std::int32_t> s;
      for (int k = 0; k <= mesh.dim; ++k)
        if (mask >> k & 1U) s.insert(c[k]);
      simplices.insert(s);
    }
  }
  long sum = 0;
  for (const auto& s : simplices) sum += s.size() % 2 == 1 ? 1 : -1;
  return sum;
}

} // namespace hvi::solver::test
