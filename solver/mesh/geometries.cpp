// What the geometries of `gmsh` meshes are called, what their numbers mean, which are possible.
#include "solver/mesh/geometries.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/joined.hpp"
#include "solver/mesh/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

using Numbers = std::vector<double>;

/// A condition that the numbers of a geometry must meet beyond being positive.
struct Condition {
  const char* geometry;
  const char* text;
  bool (*holds)(const Numbers&);
};

const Condition conditions[] = {
    {"annulus", "inner < outer", [](const Numbers& p) { return p[0] < p[1]; }},
    {"plate_with_hole", "2 * hole_radius < min(width, height)",
     [](const Numbers& p) { return 2 * p[2] < std::min(p[0], p[1]); }},
    {"dogbone", "waist < width", [](const Numbers& p) { return p[2] < p[1]; }},
    {"dogbone", "(width - waist)/2 <= notch_radius < length/2",
     [](const Numbers& p) { return (p[1] - p[2]) / 2 <= p[3] && p[3] < p[0] / 2; }},
    {"bracket", "1.5 * thickness < min(length, height)",
     [](const Numbers& p) { return 1.5 * p[3] < std::min(p[0], p[1]); }},
    {"bracket", "2 * hole_radius < width", [](const Numbers& p) { return 2 * p[4] < p[2]; }},
    {"bracket", "hole_radius < 0.4 * (min(length, height) - thickness)",
     [](const Numbers& p) { return p[4] < 0.4 * (std::min(p[0], p[1]) - p[3]); }},
    {"bracket", "hole_radius + thickness/2 < 0.6 * (min(length, height) - thickness)",
     [](const Numbers& p) { return p[4] + p[3] / 2 < 0.6 * (std::min(p[0], p[1]) - p[3]); }},
};

Failure bad(const GeometryInfo& info, const std::string& what) {
  return Failure(FailureKind::bad_value, {},
                 fmt::format("{}({}): {}", info.name, joined(info.parameters), what));
}

bool is_centre(const std::string& parameter) { return parameter == "cx" || parameter == "cy"; }

void check_numbers(const GeometryInfo& info, const Numbers& p) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool ok = std::isfinite(p[i]) && std::abs(p[i]) < 1e30 &&
                    (is_centre(info.parameters[i]) || p[i] > 1e-30);
    if (!ok) throw bad(info, fmt::format("{} cannot be {}", info.parameters[i], p[i]));
  }
  for (const Condition& c : conditions)
    if (info.name == c.geometry && !c.holds(p)) throw bad(info, fmt::format("needs {}", c.text));
}

/// An upper bound of the number of cells, so that gmsh does not run for hours.
void check_size(const GeometryInfo& info, const Numbers& p) {
  const auto at = std::find(info.parameters.begin(), info.parameters.end(), "size");
  const auto i = static_cast<std::size_t>(at - info.parameters.begin());
  double extent = 0;
  for (std::size_t k = 0; k < i; ++k)
    if (!is_centre(info.parameters[k])) extent = std::max(extent, p[k]);
  for (std::size_t k = i; k < p.size(); ++k)
    if (p[k] > 2 * extent)
      throw bad(info, fmt::format("{} is {}, larger than the body", info.parameters[k], p[k]));
  check_cell_limit(std::pow(extent / p[i], info.dim));
  if (p.back() < 1e-6 * extent)
    throw bad(info, fmt::format("{} is {}, less than a millionth of the body",
                                info.parameters.back(), p.back()));
}

} // namespace

const std::vector<GeometryInfo>& geometries() {
  static const std::vector<GeometryInfo> list{
      {"disk", 2, {"cx", "cy", "radius", "size"}, {0, 0, 1, 0.1}, {"rim", "body"}},
      {"annulus",
       2,
       {"inner", "outer", "size", "size_inner"},
       {0.5, 1, 0.1, 0.1},
       {"inner", "outer", "body"}},
      {"plate_with_hole",
       2,
       {"width", "height", "hole_radius", "size", "size_hole"},
       {2, 1, 0.2, 0.1, 0.1},
       {"left", "right", "bottom", "top", "hole", "body"}},
      {"half_disk",
       2,
       {"radius", "size", "size_pole"},
       {1, 0.1, 0.1},
       {"top", "bottom", "pole", "body"},
       {"pole"}},
      {"quarter_disk",
       2,
       {"radius", "size", "size_pole"},
       {1, 0.1, 0.1},
       {"top", "left", "bottom", "pole", "body"},
       {"pole"}},
      {"graded_rectangle",
       2,
       {"width", "height", "size", "size_corner"},
       {2, 1, 0.1, 0.1},
       {"left", "right", "bottom", "top", "body"}},
      {"l_shape",
       2,
       {"side", "size", "size_corner"},
       {1, 0.1, 0.1},
       {"left", "right", "bottom", "top", "notch", "body"}},
      {"dogbone",
       2,
       {"length", "width", "waist", "notch_radius", "size", "size_notch"},
       {4, 1, 0.6, 0.5, 0.1, 0.1},
       {"left", "right", "bottom", "top", "notch", "body"}},
      {"ball", 3, {"radius", "size"}, {1, 0.3}, {"surface", "body"}},
      {"half_ball",
       3,
       {"radius", "size", "size_pole"},
       {1, 0.3, 0.3},
       {"top", "bottom", "pole", "body"},
       {"pole"}},
      {"cylinder",
       3,
       {"radius", "height", "size", "size_bottom"},
       {0.5, 1, 0.2, 0.2},
       {"bottom", "top", "side", "body"}},
      {"bracket",
       3,
       {"length", "height", "width", "thickness", "hole_radius", "size", "size_seat"},
       {8, 6, 4, 1, 0.8, 0.5, 0.5},
       {"seat", "load", "back", "tip", "bolt", "pin", "body"},
       {"pin"}},
  };
  return list;
}

const GeometryInfo& geometry_info(const std::string& name) {
  std::string names;
  for (const auto& info : geometries()) {
    if (info.name == name) return info;
    names += (names.empty() ? "" : ", ") + info.name;
  }
  throw Failure(FailureKind::bad_value, {},
                fmt::format("there is no geometry `{}`; there are: {}", name, names));
}

std::vector<double> complete_numbers(const GeometryInfo& info, std::vector<double> numbers) {
  const std::size_t all = info.parameters.size();
  const bool has_fine = info.parameters.back() != "size";
  if (numbers.empty()) numbers = info.defaults;
  if (has_fine && numbers.size() + 1 == all) numbers.push_back(numbers.back());
  if (numbers.size() != all)
    throw bad(info,
              fmt::format("takes {}{} numbers, not {}",
                          has_fine ? fmt::format("{} or ", all - 1) : "", all, numbers.size()));
  check_numbers(info, numbers);
  check_size(info, numbers);
  return numbers;
}

} // namespace hvi::solver
