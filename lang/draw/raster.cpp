// See raster.hpp. A scan of each triangle's box with its barycentric coordinates, and the nearest
// depth kept (E. Catmull, A subdivision algorithm for computer display of curved surfaces, 1974);
// light by normals that are interpolated (B. T. Phong, Illumination for computer generated
// pictures, Comm. ACM 18 (1975) 311-317).
#include "lang/draw/raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace hvi::lang::draw {
namespace {

constexpr int samples_a_side = 2; ///< four to a pixel

Point along(const Point& a, const Point& direction, double by) {
  return {a[0] + by * direction[0], a[1] + by * direction[1], a[2] + by * direction[2]};
}

std::uint8_t byte(double x) {
  return static_cast<std::uint8_t>(255.0 * std::clamp(x, 0.0, 1.0) + 0.5);
}

} // namespace

Point View::operator()(const Point& p) const { return {dot(right, p), dot(up, p), dot(toward, p)}; }

View view_of(int dim) {
  if (dim < 3) return {};
  const double turn = 0.6, tilt = 0.45; // radians
  const Point right{std::cos(turn), 0.0, -std::sin(turn)};
  const Point toward =
      unit({std::sin(turn) * std::cos(tilt), std::sin(tilt), std::cos(turn) * std::cos(tilt)});
  return {right, cross(toward, right), toward};
}

Raster::Raster(View view, Frame frame, bool lit)
    : view_(view), frame_(frame), lit_(lit), wide_(samples_a_side * frame.width),
      high_(samples_a_side * frame.height),
      depth_(static_cast<std::size_t>(wide_) * high_, -std::numeric_limits<float>::infinity()),
      samples_(depth_.size()) {}

Raster::Corner Raster::corner(const Point& p, double value, const Point& normal) const {
  const Point seen = view_(p);
  const double scale = samples_a_side * frame_.scale;
  return {(seen[0] - frame_.left) * scale, high_ - (seen[1] - frame_.bottom) * scale,
          seen[2] * scale, value, view_(normal)};
}

/// A lamp over the viewer's left shoulder, light from everywhere, and a faint gloss.
double Raster::light(Point normal) const {
  if (!lit_) return 1.0;
  Point n = unit(normal);
  if (n[2] < 0.0) n = {-n[0], -n[1], -n[2]}; // the inner side of a thin thing
  static const Point lamp = unit({-0.30, 0.60, 0.8});
  static const Point half = unit({-0.30, 0.60, 1.8});
  const double gloss = std::pow(std::max(dot(n, half), 0.0), 40.0);
  return 0.66 + 0.33 * std::max(dot(n, lamp), 0.0) + 0.10 * gloss;
}

void Raster::set(std::size_t sample, double depth, Colour colour) {
  depth_[sample] = static_cast<float>(depth);
  samples_[sample] = {byte(colour.red), byte(colour.green), byte(colour.blue), 255};
}

void Raster::triangle(const std::array<Corner, 3>& c, const ColourMap* colours, Colour colour) {
  const auto twice_area = [](const Corner& a, const Corner& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  };
  const double area = twice_area(c[0], c[1], c[2].x, c[2].y);
  if (area == 0.0 || !std::isfinite(area)) return;
  const auto [x_low, x_high] = std::minmax({c[0].x, c[1].x, c[2].x});
  const auto [y_low, y_high] = std::minmax({c[0].y, c[1].y, c[2].y});
  const int x_begin = std::max(0, static_cast<int>(std::floor(x_low)));
  const int y_begin = std::max(0, static_cast<int>(std::floor(y_low)));
  const int x_end = static_cast<int>(std::min<double>(wide_, std::ceil(x_high) + 1));
  const int y_end = static_cast<int>(std::min<double>(high_, std::ceil(y_high) + 1));
  constexpr double rim = -1e-9; // samples on a common edge belong to both
  for (int y = y_begin; y < y_end; ++y)
    for (int x = x_begin; x < x_end; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double a = twice_area(c[1], c[2], px, py) / area;
      const double b = twice_area(c[2], c[0], px, py) / area;
      const double d = 1.0 - a - b;
      if (a < rim || b < rim || d < rim) continue;
      const double depth = a * c[0].depth + b * c[1].depth + d * c[2].depth;
      const std::size_t sample = static_cast<std::size_t>(y) * wide_ + x;
      if (depth <= static_cast<double>(depth_[sample])) continue;
      Point normal{};
      for (int i = 0; i < 3; ++i)
        normal[i] = a * c[0].normal[i] + b * c[1].normal[i] + d * c[2].normal[i];
      const Colour own =
          colours ? (*colours)(a * c[0].value + b * c[1].value + d * c[2].value) : colour;
      const double bright = light(normal);
      set(sample, depth, {bright * own.red, bright * own.green, bright * own.blue});
    }
}

void Raster::surface(const std::vector<Triangle>& triangles, const std::vector<Point>& points,
                     const std::vector<std::array<Point, 3>>& normals,
                     const std::vector<std::array<double, 3>>& values, const ColourMap& colours) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [i, j, k] = triangles[t];
    triangle({corner(points[i], values[t][0], normals[t][0]),
              corner(points[j], values[t][1], normals[t][1]),
              corner(points[k], values[t][2], normals[t][2])},
             &colours, {});
  }
}

void Raster::surface(const std::vector<Triangle>& triangles, const std::vector<Point>& points,
                     const std::vector<std::array<Point, 3>>& normals, Colour colour) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [i, j, k] = triangles[t];
    triangle({corner(points[i], 0, normals[t][0]), corner(points[j], 0, normals[t][1]),
              corner(points[k], 0, normals[t][2])},
             nullptr, colour);
  }
}

void Raster::line(const Point& from, const Point& to, Colour colour, double thick, double opacity) {
  const Corner a = corner(from, 0, {}), b = corner(to, 0, {});
  const double half = 0.5 * thick * samples_a_side, before = 2.5 * half + samples_a_side;
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  const double dx = length > 0.0 ? (b.x - a.x) / length : 1.0;
  const double dy = length > 0.0 ? (b.y - a.y) / length : 0.0;
  const auto range = [&](double p, double q, int size) {
    return std::pair(std::max(0, static_cast<int>(std::min(p, q) - half - 1)),
                     static_cast<int>(std::min<double>(size, std::max(p, q) + half + 2)));
  };
  const auto [x_begin, x_end] = range(a.x, b.x, wide_);
  const auto [y_begin, y_end] = range(a.y, b.y, high_);
  for (int y = y_begin; y < y_end; ++y)
    for (int x = x_begin; x < x_end; ++x) {
      const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
      const double on = std::clamp(px * dx + py * dy, 0.0, length);
      const double ax = px - on * dx, ay = py - on * dy;
      if (ax * ax + ay * ay > half * half) continue;
      const double part = length > 0.0 ? on / length : 0.0;
      const double depth = (1.0 - part) * a.depth + part * b.depth + before;
      const std::size_t sample = static_cast<std::size_t>(y) * wide_ + x;
      if (depth <= static_cast<double>(depth_[sample])) continue;
      auto& under = samples_[sample];
      const double covered = under[3] > 0 ? opacity : 1.0;
      const double rest = 1.0 - covered;
      set(sample, depth,
          {covered * colour.red + rest * under[0] / 255.0,
           covered * colour.green + rest * under[1] / 255.0,
           covered * colour.blue + rest * under[2] / 255.0});
    }
}

std::array<std::uint8_t, 4> Raster::sample(double right, double up) const {
  const double scale = samples_a_side * frame_.scale;
  const double x = (right - frame_.left) * scale, y = high_ - (up - frame_.bottom) * scale;
  if (!(x >= 0.0 && x < wide_ && y >= 0.0 && y < high_)) return {};
  return samples_[static_cast<std::size_t>(y) * wide_ + static_cast<std::size_t>(x)];
}

Image Raster::image() const {
  Image out{frame_.width, frame_.height, {}};
  out.rgba.reserve(4 * static_cast<std::size_t>(out.width) * out.height);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      std::array<int, 4> sum{};
      for (int s = 0; s < samples_a_side * samples_a_side; ++s) {
        const auto row = static_cast<std::size_t>(samples_a_side * y + s / samples_a_side);
        const auto& sample = samples_[row * wide_ + samples_a_side * x + s % samples_a_side];
        for (int i = 0; i < 3; ++i) sum[i] += sample[3] > 0 ? sample[i] : 0;
        sum[3] += sample[3] > 0;
      }
      for (int i = 0; i < 3; ++i)
        out.rgba.push_back(static_cast<std::uint8_t>(sum[3] > 0 ? sum[i] / sum[3] : 0));
      out.rgba.push_back(
          static_cast<std::uint8_t>(255 * sum[3] / (samples_a_side * samples_a_side)));
    }
  return out;
}

Arrow arrow(const Point& tail, const Point& tip, double thick) {
  const Point axis{tip[0] - tail[0], tip[1] - tail[1], tip[2] - tail[2]};
  const double length = std::sqrt(dot(axis, axis));
  const Point ahead = unit(axis);
  const Point aside =
      unit(cross(ahead, std::abs(ahead[1]) < 0.9 ? Point{0, 1, 0} : Point{1, 0, 0}));
  const Point above = cross(ahead, aside);
  const double head = std::min(4.0 * thick, 0.5 * length);
  Arrow out;
  constexpr int around = 12;
  const auto ring = [&](double at, double radius) {
    const auto first = static_cast<std::int32_t>(out.points.size());
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / around;
      const Point centre = along(tail, ahead, at);
      out.points.push_back(
          along(along(centre, aside, radius * std::cos(angle)), above, radius * std::sin(angle)));
    }
    return first;
  };
  const auto join = [&](std::int32_t a, std::int32_t b) {
    for (int k = 0; k < around; ++k) {
      const int next = (k + 1) % around;
      out.triangles.push_back({a + k, a + next, b + k});
      out.triangles.push_back({a + next, b + next, b + k});
    }
  };
  const auto end = ring(0.0, 0.5 * thick), neck = ring(length - head, 0.5 * thick);
  const auto flange = ring(length - head, 1.4 * thick), point = ring(length, 0.0);
  join(end, neck), join(neck, flange), join(flange, point);
  return out;
}

} // namespace hvi::lang::draw
