// Builders: one function for each geometry, coordinates in the comment above it.
#include "solver/mesh/gmsh/geometries.hpp"

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace hvi::gmsh_module {
namespace {

namespace occ = gmsh::model::occ;
using Numbers = std::span<const double>;
using Test = std::function<bool(const Extent&)>;

constexpr double tolerance = 1e-5; // OpenCASCADE widens its boxes by 1e-7

Test everything() {
  return [](const Extent&) { return true; };
}

/// Lies in the plane x_axis = value.
Test on(int axis, double value) {
  return [=](const Extent& e) {
    return std::abs(e.low[axis] - value) < tolerance && std::abs(e.high[axis] - value) < tolerance;
  };
}

/// Lies in the square or, for a tube along `axis`, in the square column around the centre.
Test around(std::array<double, 3> centre, double radius, int axis) {
  return [=](const Extent& e) {
    for (int a = 0; a < 3; ++a) {
      if (a == axis) continue;
      if (e.low[a] < centre[a] - radius - tolerance || e.high[a] > centre[a] + radius + tolerance)
        return false;
    }
    return true;
  };
}

void cut(int dim, int body, int tool) {
  gmsh::vectorpair out;
  std::vector<gmsh::vectorpair> map;
  occ::cut({{dim, body}}, {{dim, tool}}, out, map);
}

/// A plane polygon given by its corners.
int polygon(const std::vector<std::array<double, 2>>& corners) {
  std::vector<int> points, lines;
  for (const auto& c : corners) points.push_back(occ::addPoint(c[0], c[1], 0));
  for (std::size_t i = 0; i < points.size(); ++i)
    lines.push_back(occ::addLine(points[i], points[(i + 1) % points.size()]));
  return occ::addPlaneSurface({occ::addCurveLoop(lines)});
}

void rectangle_sides(Blueprint& b, double width, double height) {
  b.sides = {
      {"left", on(0, 0)}, {"right", on(0, width)}, {"bottom", on(1, 0)}, {"top", on(1, height)}};
}

/// Disk around (cx, cy).
Blueprint disk(Numbers p) {
  occ::addDisk(p[0], p[1], 0, p[2], p[2]);
  Blueprint b{.size = p[3], .fine = p[3]};
  b.sides = {{"rim", everything()}};
  return b;
}

/// Ring around the origin.
Blueprint annulus(Numbers p) {
  const double inner = p[0], outer = p[1];
  cut(2, occ::addDisk(0, 0, 0, outer, outer), occ::addDisk(0, 0, 0, inner, inner));
  Blueprint b{.size = p[2], .fine = p[3], .reach = outer - inner};
  // The box of a circle may be a polygon's: half way between the radii is far from both.
  b.sides = {{"inner", around({0, 0, 0}, (inner + outer) / 2, 2)}, {"outer", everything()}};
  b.distance = [=](double x, double y, double) { return std::hypot(x, y) - inner; };
  return b;
}

/// (0, width) x (0, height) with a hole in its middle.
Blueprint plate_with_hole(Numbers p) {
  const double width = p[0], height = p[1], radius = p[2];
  cut(2, occ::addRectangle(0, 0, 0, width, height),
      occ::addDisk(width / 2, height / 2, 0, radius, radius));
  Blueprint b{.size = p[3], .fine = p[4], .reach = std::min(width, height) / 2};
  rectangle_sides(b, width, height);
  b.sides.emplace_back("hole", everything());
  b.distance = [=](double x, double y, double) {
    return std::hypot(x - width / 2, y - height / 2) - radius;
  };
  return b;
}

/// The lower half of the disk around (0, radius): it stands on the origin, a node ("pole").
Blueprint half_disk(Numbers p) {
  const double r = p[0];
  const int left = occ::addPoint(-r, r, 0), pole = occ::addPoint(0, 0, 0);
  const int right = occ::addPoint(r, r, 0), centre = occ::addPoint(0, r, 0);
  const int loop =
      occ::addCurveLoop({occ::addCircleArc(left, centre, pole),
                         occ::addCircleArc(pole, centre, right), occ::addLine(right, left)});
  occ::addPlaneSurface({loop});
  occ::remove({{0, centre}});
  Blueprint b{.size = p[1], .fine = p[2], .reach = r};
  b.sides = {{"top", on(1, r)}, {"bottom", everything()}};
  b.points = {{"pole", {0, 0, 0}}};
  b.distance = [](double x, double y, double z) { return std::hypot(x, y, z); };
  return b;
}

/// The half x >= 0 of half_disk: the section of a half ball.
Blueprint quarter_disk(Numbers p) {
  const double r = p[0];
  const int pole = occ::addPoint(0, 0, 0), rim = occ::addPoint(r, r, 0);
  const int centre = occ::addPoint(0, r, 0);
  const int loop = occ::addCurveLoop({occ::addCircleArc(pole, centre, rim),
                                      occ::addLine(rim, centre), occ::addLine(centre, pole)});
  occ::addPlaneSurface({loop});
  Blueprint b{.size = p[1], .fine = p[2], .reach = r};
  b.sides = {{"top", on(1, r)}, {"left", on(0, 0)}, {"bottom", everything()}};
  b.points = {{"pole", {0, 0, 0}}};
  b.distance = [](double x, double y, double z) { return std::hypot(x, y, z); };
  return b;
}

/// (0, width) x (0, height), fine at its four corners.
Blueprint graded_rectangle(Numbers p) {
  const double width = p[0], height = p[1];
  occ::addRectangle(0, 0, 0, width, height);
  Blueprint b{.size = p[2], .fine = p[3], .reach = std::min(width, height) / 2};
  rectangle_sides(b, width, height);
  b.distance = [=](double x, double y, double) {
    return std::hypot(std::min(x, width - x), std::min(y, height - y));
  };
  return b;
}

/// (0, side)^2 without its upper right quarter; the re-entrant corner is (side/2, side/2).
Blueprint l_shape(Numbers p) {
  const double s = p[0], h = p[0] / 2;
  polygon({{0, 0}, {s, 0}, {s, h}, {h, h}, {h, s}, {0, s}});
  Blueprint b{.size = p[1], .fine = p[2], .reach = h};
  rectangle_sides(b, s, s);
  b.sides.emplace_back("notch", everything());
  b.distance = [=](double x, double y, double) { return std::hypot(x - h, y - h); };
  return b;
}

/// (0, length) x (0, width), narrowed to `waist` in the middle by two round notches.
Blueprint dogbone(Numbers p) {
  const double length = p[0], width = p[1], waist = p[2], radius = p[3];
  const double low = (width - waist) / 2 - radius, high = (width + waist) / 2 + radius;
  gmsh::vectorpair out;
  std::vector<gmsh::vectorpair> map;
  occ::cut({{2, occ::addRectangle(0, 0, 0, length, width)}},
           {{2, occ::addDisk(length / 2, low, 0, radius, radius)},
            {2, occ::addDisk(length / 2, high, 0, radius, radius)}},
           out, map);
  Blueprint b{.size = p[4], .fine = p[5], .reach = width};
  rectangle_sides(b, length, width);
  b.sides.emplace_back("notch", everything());
  b.distance = [=](double x, double y, double) {
    return std::min(std::hypot(x - length / 2, y - low), std::hypot(x - length / 2, y - high)) -
           radius;
  };
  return b;
}

/// Ball around the origin.
Blueprint ball(Numbers p) {
  occ::addSphere(0, 0, 0, p[0]);
  Blueprint b{.dim = 3, .size = p[1], .fine = p[1]};
  b.sides = {{"surface", everything()}};
  return b;
}

/// The lower half (y < radius) of the ball around (0, radius, 0): it stands on the origin, a node.
Blueprint half_ball(Numbers p) {
  const double r = p[0];
  // A half sphere has a vertex at its pole z = -r; turning it about x brings the pole to y = -r.
  const int half = occ::addSphere(0, 0, 0, r, -1, -std::numbers::pi / 2, 0);
  occ::rotate({{3, half}}, 0, 0, 0, 1, 0, 0, -std::numbers::pi / 2);
  occ::translate({{3, half}}, 0, r, 0);
  Blueprint b{.dim = 3, .size = p[1], .fine = p[2], .reach = r};
  b.sides = {{"top", on(1, r)}, {"bottom", everything()}};
  b.points = {{"pole", {0, 0, 0}}};
  b.distance = [](double x, double y, double z) { return std::hypot(x, y, z); };
  return b;
}

/// Around the y axis, from y = 0 to y = height.
Blueprint cylinder(Numbers p) {
  const double radius = p[0], height = p[1];
  occ::addCylinder(0, 0, 0, 0, height, 0, radius);
  Blueprint b{.dim = 3, .size = p[2], .fine = p[3], .reach = height};
  b.sides = {{"bottom", on(1, 0)}, {"top", on(1, height)}, {"side", everything()}};
  b.distance = [](double, double y, double) { return y; };
  return b;
}

/// An angle bracket: a plate (0, length) x (0, thickness) lying on y = 0 and a plate
/// (0, thickness) x (0, height) standing at its left end, both (0, width) deep in z, their inner
/// corner rounded; a bolt hole through the lying plate and a pin hole through the standing one.
Blueprint bracket(Numbers p) {
  const double length = p[0], height = p[1], width = p[2], t = p[3], radius = p[4];
  const double f = t + t / 2; // where the rounding (radius t/2) starts
  const std::vector<std::array<double, 2>> outline{{t, f},      {t, height}, {0, height}, {0, 0},
                                                   {length, 0}, {length, t}, {f, t}};
  std::vector<int> points, curves;
  for (const auto& c : outline) points.push_back(occ::addPoint(c[0], c[1], 0));
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    curves.push_back(occ::addLine(points[i], points[i + 1]));
  const int centre = occ::addPoint(f, f, 0);
  curves.push_back(occ::addCircleArc(points.back(), centre, points.front()));
  gmsh::vectorpair out;
  occ::extrude({{2, occ::addPlaneSurface({occ::addCurveLoop(curves)})}}, 0, 0, width, out);
  const auto body =
      std::find_if(out.begin(), out.end(), [](const auto& e) { return e.first == 3; });
  occ::remove({{0, centre}});
  const double bolt = t + 0.6 * (length - t), pin = t + 0.6 * (height - t);
  std::vector<gmsh::vectorpair> map;
  occ::cut({*body},
           {{3, occ::addCylinder(bolt, -t, width / 2, 0, 3 * t, 0, radius)},
            {3, occ::addCylinder(-t, pin, width / 2, 3 * t, 0, 0, radius)}},
           out, map);
  Blueprint b{.dim = 3, .size = p[5], .fine = p[6], .reach = height};
  b.sides = {{"seat", on(1, 0)},
             {"load", on(1, height)},
             {"back", on(0, 0)},
             {"tip", on(0, length)},
             {"bolt", around({bolt, 0, width / 2}, radius, 1)},
             {"pin", around({0, pin, width / 2}, radius, 0)}};
  b.distance = [](double, double y, double) { return y; };
  return b;
}

} // namespace

Blueprint build(const std::string& geometry, Numbers numbers) {
  static const std::map<std::string, Blueprint (*)(Numbers)> builders{
      {"disk", disk},
      {"annulus", annulus},
      {"plate_with_hole", plate_with_hole},
      {"half_disk", half_disk},
      {"quarter_disk", quarter_disk},
      {"graded_rectangle", graded_rectangle},
      {"l_shape", l_shape},
      {"dogbone", dogbone},
      {"ball", ball},
      {"half_ball", half_ball},
      {"cylinder", cylinder},
      {"bracket", bracket}};
  const auto at = builders.find(geometry);
  if (at == builders.end()) throw std::invalid_argument("no geometry is called " + geometry);
  return at->second(numbers);
}

} // namespace hvi::gmsh_module
