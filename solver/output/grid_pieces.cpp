// See grid_pieces.hpp.
#include "solver/output/grid_pieces.hpp"

#include <fmt/format.h>

#include <string_view>

namespace hvi::solver {
namespace {

/// The entries of these points or cells.
VtuArray chosen(const VtuArray& whole, std::span<const std::int64_t> entries) {
  VtuArray out{whole.name, whole.components, {}, whole.unit};
  const auto n = static_cast<std::size_t>(whole.components);
  out.values.reserve(n * entries.size());
  for (const std::int64_t e : entries) {
    const auto from = whole.values.begin() + e * static_cast<std::int64_t>(n);
    out.values.insert(out.values.end(), from, from + static_cast<std::int64_t>(n));
  }
  return out;
}

void put_arrays(StateWriter& w, const std::vector<VtuArray>& arrays) {
  w.put(static_cast<std::uint64_t>(arrays.size()));
  for (const VtuArray& array : arrays) {
    put_text(w, array.name);
    w.put(array.components);
    w.put(array.values);
    put_text(w, array.unit);
  }
}

std::vector<VtuArray> get_arrays(StateReader& r) {
  std::vector<VtuArray> out;
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    VtuArray& array = out.emplace_back();
    array.name = get_text(r);
    array.components = r.get<int>();
    array.values = r.get_vector<double>();
    array.unit = get_text(r);
  }
  return out;
}

std::string section(const char* name, const std::vector<VtuArray>& arrays) {
  std::string out = fmt::format("<{}>\n", name);
  for (const VtuArray& array : arrays) out += array_without_values(array);
  return out + fmt::format("</{}>\n", name);
}

} // namespace

GridPieces::GridPieces(const VtuGrid& grid, std::span<const std::int32_t> part_of_cell, int count)
    : pieces_(static_cast<std::size_t>(count)) {
  const auto width = static_cast<std::size_t>(nodes_of(grid.cell));
  for (std::size_t c = 0; c < part_of_cell.size(); ++c)
    pieces_[static_cast<std::size_t>(part_of_cell[c])].cells.push_back(
        static_cast<std::int64_t>(c));
  std::vector<std::int64_t> place(grid.points.size(), -1);
  for (Piece& piece : pieces_) {
    for (const std::int64_t c : piece.cells)
      for (std::size_t k = 0; k < width; ++k) {
        const auto point =
            static_cast<std::size_t>(grid.connectivity[static_cast<std::size_t>(c) * width + k]);
        if (place[point] < 0) {
          place[point] = static_cast<std::int64_t>(piece.points.size());
          piece.points.push_back(static_cast<std::int64_t>(point));
        }
        piece.connectivity.push_back(place[point]);
      }
    for (const std::int64_t point : piece.points) place[static_cast<std::size_t>(point)] = -1;
  }
}

VtuGrid GridPieces::piece(const VtuGrid& grid, int p) const {
  const Piece& of = pieces_[static_cast<std::size_t>(p)];
  VtuGrid out;
  out.cell = grid.cell, out.time = grid.time, out.connectivity = of.connectivity;
  for (const std::int64_t point : of.points)
    out.points.push_back(grid.points[static_cast<std::size_t>(point)]);
  for (const VtuArray& array : grid.point_data) out.point_data.push_back(chosen(array, of.points));
  for (const VtuArray& array : grid.cell_data) out.cell_data.push_back(chosen(array, of.cells));
  return out;
}

std::string pvtu_bytes(const VtuGrid& piece, const VtuUnits& units,
                       std::span<const std::string> files) {
  std::string out = "<?xml version=\"1.0\"?>\n"
                    "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\" header_type=\"UInt64\" "
                    "compressor=\"vtkZLibDataCompressor\">\n<PUnstructuredGrid GhostLevel=\"0\">\n";
  out += section("PPointData", piece.point_data) + section("PCellData", piece.cell_data);
  out += section("PPoints", {{"Points", 3, {}, units.length}});
  for (const std::string& file : files)
    out += fmt::format("<Piece Source=\"{}\"/>\n", xml_escaped(file));
  return out + "</PUnstructuredGrid>\n</VTKFile>\n";
}

void put_grid(StateWriter& w, const VtuGrid& grid) {
  w.put(grid.cell);
  w.put(grid.time);
  w.put(grid.points);
  w.put(grid.connectivity);
  put_arrays(w, grid.point_data);
  put_arrays(w, grid.cell_data);
}

VtuGrid get_grid(StateReader& r) {
  VtuGrid out;
  out.cell = r.get<VtkCell>();
  out.time = r.get<double>();
  out.points = r.get_vector<Point>();
  out.connectivity = r.get_vector<std::int64_t>();
  out.point_data = get_arrays(r);
  out.cell_data = get_arrays(r);
  return out;
}

} // namespace hvi::solver
