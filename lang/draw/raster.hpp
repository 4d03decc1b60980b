// A depth buffer: triangles with light, lines and arrows in space, as pixels.
#pragma once

#include "lang/draw/colour_map.hpp"
#include "lang/draw/surface.hpp"

#include <array>
#include <vector>

namespace hvi::lang::draw {

/// A parallel projection. Distances are kept across the view; `toward` points to the viewer.
struct View {
  Point right{1, 0, 0}, up{0, 1, 0}, toward{0, 0, 1};
  /// (to the right, up, towards the viewer)
  Point operator()(const Point& p) const;
};
/// The plane itself in 2D; in 3D from the front, the right and above.
View view_of(int dim);

/// The part of the plane of a view that an image shows, and its size in pixels.
struct Frame {
  double left = 0.0, bottom = 0.0; ///< of the plane
  double scale = 1.0;              ///< pixels to a unit
  int width = 0, height = 0;
};

/// Draws into a depth buffer that has several samples in each pixel; lines are thinner than a
/// pixel, seams between triangles do not show.
class Raster {
public:
  Raster(View view, Frame frame, bool lit);
  /// Coloured by a value at every corner; `normals` by corner, read where there is light.
  void surface(const std::vector<Triangle>& triangles, const std::vector<Point>& points,
               const std::vector<std::array<Point, 3>>& normals,
               const std::vector<std::array<double, 3>>& values, const ColourMap& colours);
  /// In one colour.
  void surface(const std::vector<Triangle>& triangles, const std::vector<Point>& points,
               const std::vector<std::array<Point, 3>>& normals, Colour colour);
  /// A line of this many pixels, in front of surfaces it lies on.
  void line(const Point& from, const Point& to, Colour colour, double thick, double opacity = 1.0);
  /// What was drawn at a point of the plane of the view; all zero: nothing.
  std::array<std::uint8_t, 4> sample(double right, double up) const;
  /// The mean of the samples; clear where nothing was drawn.
  Image image() const;

private:
  struct Corner {
    double x, y, depth, value;
    Point normal;
  };
  void triangle(const std::array<Corner, 3>& corners, const ColourMap* colours, Colour colour);
  Corner corner(const Point& p, double value, const Point& normal) const;
  double light(Point normal) const;
  void set(std::size_t sample, double depth, Colour colour);

  View view_;
  Frame frame_;
  bool lit_;
  int wide_, high_;
  std::vector<float> depth_;
  std::vector<std::array<std::uint8_t, 4>> samples_;
};

/// An arrow of a shaft and a head as a surface, from `tail` to `tip`, `thick` wide at its shaft.
struct Arrow {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
};
Arrow arrow(const Point& tail, const Point& tip, double thick);

} // namespace hvi::lang::draw
