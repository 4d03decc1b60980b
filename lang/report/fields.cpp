// See fields.hpp.
#include "lang/report/fields.hpp"

#include "lang/check/model.hpp"
#include "lang/draw/surface.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <utility>

namespace hvi::lang {
namespace {

using Json = nlohmann::ordered_json;
using solver::VtkCell;
using solver::VtuArray;
using solver::VtuGrid;

/// Numbers in all frames together: some 30 MB before they are packed.
constexpr std::size_t most_numbers = 8'000'000;

constexpr std::array<std::array<int, 3>, 4> triangle_parts{
    {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
/// Four at the corners; the octahedron between them around its diagonal 4-9.
constexpr std::array<std::array<int, 4>, 8> tetra_parts{{{0, 4, 6, 7},
                                                         {1, 5, 4, 8},
                                                         {2, 6, 5, 9},
                                                         {3, 7, 9, 8},
                                                         {4, 9, 5, 8},
                                                         {4, 9, 8, 7},
                                                         {4, 9, 7, 6},
                                                         {4, 9, 6, 5}}};

double volume(const VtuGrid& grid, const std::array<std::uint32_t, 4>& cell) {
  std::array<solver::Point, 3> e{};
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) e[k][i] = grid.points[cell[k + 1]][i] - grid.points[cell[0]][i];
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

template <std::size_t N, std::size_t M>
void add_parts(const VtuGrid& grid, const std::int64_t* cell,
               const std::array<std::array<int, N>, M>& parts, std::vector<std::uint32_t>& out) {
  for (const auto& part : parts) {
    std::array<std::uint32_t, 4> nodes{};
    for (std::size_t k = 0; k < N; ++k) nodes[k] = static_cast<std::uint32_t>(cell[part[k]]);
    if (N == 4 && volume(grid, nodes) < 0.0) std::swap(nodes[2], nodes[3]);
    out.insert(out.end(), nodes.begin(), nodes.begin() + N);
  }
}

Json names_of(const VtuGrid& grid) {
  Json out = Json::array();
  for (const auto* arrays : {&grid.point_data, &grid.cell_data})
    for (const VtuArray& array : *arrays)
      out.push_back({{"name", array.name},
                     {"components", array.components},
                     {"unit", ModelUnits::bracketed(array.unit)}, // behind its numbers
                     {"means", arrays == &grid.cell_data}});      // of cells, at their nodes
  return out;
}

Json law_points_json(const solver::FieldFrame& frame, Blocks& blocks) {
  Json out = Json::array();
  for (std::size_t g = 1; g < frame.grids.size(); ++g) {
    const VtuGrid& grid = frame.grids[g].grid;
    const auto is_multiplier = [](const VtuArray& a) { return a.name == solver::multiplier_array; };
    if (std::ranges::none_of(grid.point_data, is_multiplier)) continue; // no law
    std::vector<double> flat;
    for (const auto& p : grid.points) flat.insert(flat.end(), p.begin(), p.end());
    Json law{{"name", frame.grids[g].name}, {"points", blocks.add(flat)}};
    for (const VtuArray& array : grid.point_data) law[array.name] = blocks.add(array.values);
    out.push_back(std::move(law));
  }
  return out;
}

/// Which frames are shown: all, or evenly chosen ones with the last.
std::vector<std::size_t> chosen(std::span<const solver::FieldFrame> frames) {
  const VtuGrid& grid = frames.front().grids.front().grid;
  std::size_t numbers = 1;
  for (const auto* arrays : {&grid.point_data, &grid.cell_data})
    for (const VtuArray& array : *arrays) numbers += grid.points.size() * array.components;
  const std::size_t most = std::clamp<std::size_t>(most_numbers / numbers, 2, 100);
  const std::size_t n = std::min(most, frames.size());
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < n; ++k)
    out.push_back(n == 1 ? frames.size() - 1 : k * (frames.size() - 1) / (n - 1));
  return out;
}

} // namespace

std::vector<std::uint32_t> simplices_of(const VtuGrid& grid) {
  std::vector<std::uint32_t> out;
  const int stride = nodes_of(grid.cell);
  for (std::size_t c = 0; c < grid.connectivity.size(); c += static_cast<std::size_t>(stride)) {
    const std::int64_t* const cell = grid.connectivity.data() + c;
    switch (grid.cell) {
    case VtkCell::quadratic_edge:
      add_parts<2, 2>(grid, cell, {{{0, 2}, {2, 1}}}, out);
      break;
    case VtkCell::quadratic_triangle:
      add_parts(grid, cell, triangle_parts, out);
      break;
    case VtkCell::quadratic_tetra:
      add_parts(grid, cell, tetra_parts, out);
      break;
    case VtkCell::tetra:
      add_parts<4, 1>(grid, cell, {{{0, 1, 2, 3}}}, out);
      break;
    default:
      for (int k = 0; k < stride; ++k) out.push_back(static_cast<std::uint32_t>(cell[k]));
    }
  }
  return out;
}

Json fields_json(std::span<const solver::FieldFrame> frames, Blocks& blocks) {
  if (frames.empty() || frames.front().grids.empty()) return nullptr;
  const VtuGrid& grid = frames.front().grids.front().grid;
  std::vector<double> flat;
  for (const auto& p : grid.points) flat.insert(flat.end(), p.begin(), p.end());
  const int dim = draw::skin_of(grid).dim;
  Json out{{"dim", dim},
           {"points", blocks.add(flat)},
           {"cells", blocks.add_integers(simplices_of(grid))},
           {"arrays", names_of(grid)},
           {"frames", Json::array()}};
  for (const std::size_t f : chosen(frames)) {
    const solver::FieldFrame& frame = frames[f];
    Json data = Json::array();
    for (const Json& array : out["arrays"])
      data.push_back(blocks.add(
          draw::nodal_array(frame.grids.front().grid, array["name"].get<std::string>()).values));
    out["frames"].push_back({{"t", frame.t},
                             {"step", frame.step},
                             {"data", data},
                             {"laws", law_points_json(frame, blocks)}});
  }
  return out;
}

} // namespace hvi::lang
