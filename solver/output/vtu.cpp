// VTU and PVD writers: grids of the results (solver/results) become XML. Last stage of the
// pipeline.
#include "solver/output/vtu.hpp"

#include "solver/common/failure.hpp"
#include "solver/output/encode.hpp"

#include <fmt/format.h>

#include <bit>
#include <span>

namespace hvi::solver {
namespace {

static_assert(std::endian::native == std::endian::little, "VTU files declare LittleEndian");

template <class T>
constexpr const char* vtk_type();
template <>
constexpr const char* vtk_type<double>() {
  return "Float64";
}
template <>
constexpr const char* vtk_type<std::int64_t>() {
  return "Int64";
}
template <>
constexpr const char* vtk_type<std::uint8_t>() {
  return "UInt8";
}

/// The unit as VTK stores one with an array, behind the values: readers look for these right behind
/// the tag of the array.
std::string unit_label(std::string_view unit) {
  return unit.empty() ? std::string()
                      : fmt::format("<InformationKey name=\"UNITS_LABEL\" "
                                    "location=\"vtkDataArray\">{}</InformationKey>",
                                    xml_escaped(unit));
}

/// Readers take NumberOfComponents="1" for a matrix of one column, so scalars leave it out.
template <class T>
std::string type_and_name(std::string_view name, int components) {
  const auto shape = components == 1 ? "" : fmt::format(" NumberOfComponents=\"{}\"", components);
  return fmt::format("type=\"{}\" Name=\"{}\"{}", vtk_type<T>(), xml_escaped(name), shape);
}

template <class T>
std::string data_array(std::string_view name, int components, std::span<const T> values,
                       std::string_view unit = {}) {
  return fmt::format("<DataArray {} format=\"binary\">{}{}</DataArray>\n",
                     type_and_name<T>(name, components), vtk_compressed(std::as_bytes(values)),
                     unit_label(unit));
}

std::string data_section(const char* section, const std::vector<VtuArray>& arrays,
                         std::size_t entries) {
  std::string out = fmt::format("<{}>\n", section);
  for (const auto& array : arrays) {
    if (array.values.size() != entries * static_cast<std::size_t>(array.components))
      throw Failure(FailureKind::output, {},
                    fmt::format("field `{}` has {} values, {} are needed", array.name,
                                array.values.size(),
                                entries * static_cast<std::size_t>(array.components)));
    out += data_array<double>(array.name, array.components, array.values, array.unit);
  }
  return out + fmt::format("</{}>\n", section);
}

std::string points_section(const VtuGrid& grid, const std::string& unit) {
  std::vector<double> flat;
  flat.reserve(3 * grid.points.size());
  for (const auto& p : grid.points) flat.insert(flat.end(), p.begin(), p.end());
  return "<Points>\n" + data_array<double>("Points", 3, flat, unit) + "</Points>\n";
}

std::string cells_section(const VtuGrid& grid, std::size_t n_cells) {
  const auto width = nodes_of(grid.cell);
  std::vector<std::int64_t> offsets(n_cells);
  for (std::size_t c = 0; c < n_cells; ++c) offsets[c] = static_cast<std::int64_t>(c + 1) * width;
  const std::vector<std::uint8_t> types(n_cells, static_cast<std::uint8_t>(grid.cell));
  return "<Cells>\n" + data_array<std::int64_t>("connectivity", 1, grid.connectivity) +
         data_array<std::int64_t>("offsets", 1, offsets) +
         data_array<std::uint8_t>("types", 1, types) + "</Cells>\n";
}

} // namespace

int nodes_of(VtkCell cell) {
  switch (cell) {
  case VtkCell::vertex:
    return 1;
  case VtkCell::line:
    return 2;
  case VtkCell::triangle:
    return 3;
  case VtkCell::tetra:
    return 4;
  case VtkCell::quadratic_edge:
    return 3;
  case VtkCell::quadratic_triangle:
    return 6;
  case VtkCell::quadratic_tetra:
    return 10;
  }
  return 0;
}

std::string xml_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
    case '&':
      out += "&amp;";
      break;
    case '<':
      out += "&lt;";
      break;
    case '>':
      out += "&gt;";
      break;
    case '"':
      out += "&quot;";
      break;
    default:
      out += c;
    }
  }
  return out;
}

std::string vtu_bytes(const VtuGrid& grid, const VtuUnits& units) {
  const auto n_cells = grid.connectivity.size() / static_cast<std::size_t>(nodes_of(grid.cell));
  std::string out = "<?xml version=\"1.0\"?>\n"
                    "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\" header_type=\"UInt64\" "
                    "compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n";
  out += fmt::format("<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" "
                     "NumberOfTuples=\"1\" format=\"ascii\">{}{}</DataArray>\n</FieldData>\n",
                     grid.time, unit_label(units.time));
  out += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", grid.points.size(),
                     n_cells);
  out += points_section(grid, units.length) + cells_section(grid, n_cells);
  out += data_section("PointData", grid.point_data, grid.points.size());
  out += data_section("CellData", grid.cell_data, n_cells);
  return out + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

std::string array_without_values(const VtuArray& array) {
  return fmt::format("<PDataArray {}>{}</PDataArray>\n",
                     type_and_name<double>(array.name, array.components), unit_label(array.unit));
}

std::string pvd_bytes(const std::vector<PvdEntry>& entries) {
  std::string out = "<?xml version=\"1.0\"?>\n"
                    "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                    "<Collection>\n";
  for (const auto& entry : entries)
    out += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n",
                       entry.time, entry.part, xml_escaped(entry.file));
  return out + "</Collection>\n</VTKFile>\n";
}

VtuArray vtk_array(std::string name, int components, const std::vector<double>& values) {
  const int side = components == 4 ? 2 : components == 2 ? 2 : 0;
  if (side == 0) return {std::move(name), components, values};
  const int padded = components == 4 ? 9 : 3;
  const auto n = values.size() / static_cast<std::size_t>(components);
  VtuArray out{std::move(name), padded, std::vector<double>(n * padded, 0.0)};
  for (std::size_t e = 0; e < n; ++e)
    for (int c = 0; c < components; ++c)
      out.values[e * padded + 3 * (c / side) + c % side] = values[e * components + c];
  return out;
}

} // namespace hvi::solver
