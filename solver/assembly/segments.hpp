// The intersections of two sides: facets of the second one, projected along given directions onto
// those of the first one. Internal to solver/assembly.
#pragma once

#include "solver/fem/element.hpp"
#include "solver/fem/space.hpp"
#include "solver/mesh/box_tree.hpp"

#include <optional>
#include <span>
#include <vector>

namespace hvi::solver {

/// A quadrature point where both sides are.
struct Meeting {
  Barycentric first{}, second{}; ///< in the facets
  int facet = 0;                 ///< of the second side, in its list
  double weight = 0.0;           ///< a share of the first facet's measure
  double distance = 0.0;         ///< along the direction
};

/// Where a facet meets the second side.
struct Meetings {
  std::vector<Meeting> points;
  double twice = 0.0; ///< the share of the facet over which the second side lies twice
};

/// The second side, prepared for many facets of the first one.
class SecondSide {
public:
  /// `up`: about the normal of the first side; the look-up is quick along it.
  SecondSide(const Mesh& mesh, std::span<const std::int32_t> facets, const Point& up, double reach);
  /// Where the facet meets the second side along the direction, no farther than `reach`: points of
  /// a rule of this degree on every piece. What is behind the facet is met where the two bodies
  /// overlap, not through them.
  Meetings meet(int facet, const Point& direction, const Quadrature& rule);

private:
  Box box_around(std::span<const Point> corners, const Point& sweep) const;
  Point turned(const Point& x) const;
  bool is_through_bodies(const Point& from, const Point& direction, double distance, double size);
  int bodies_at(const Point& x) const;

  const Mesh* mesh_;
  std::vector<std::int32_t> facets_;
  std::array<Point, 3> axes_;
  double reach_;
  std::optional<BoxTree> tree_;
  std::optional<BoxTree> cells_; ///< of the mesh, once a facet has something behind it
};

} // namespace hvi::solver
