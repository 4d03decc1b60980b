// A simplicial mesh in 1, 2 or 3 dimensions with named groups. Plain data.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace hvi::solver {

using Point = std::array<double, 3>; ///< unused coordinates are 0

/// A facet (point, edge or triangle) of the boundary, or of the interior when a group names it.
struct Facet {
  std::array<std::int32_t, 3> nodes{-1, -1, -1}; ///< dim of them
  std::int32_t cell = -1;                        ///< the cell it bounds; its normal points out of it
  std::int32_t other = -1;                       ///< the cell on the other side; -1: boundary
};

/// A named set of cells, facets, or points.
struct Group {
  enum class Kind : std::uint8_t { cells, facets, points };
  Kind kind = Kind::cells;
  std::vector<std::int32_t> entities; ///< sorted, unique
};

struct Mesh {
  int dim = 2;
  std::vector<Point> nodes;
  std::vector<std::array<std::int32_t, 4>> cells; ///< dim + 1 nodes each, positively oriented
  std::vector<Facet> facets;                      ///< all boundary facets, then named interior ones
  std::map<std::string, Group> groups; ///< sides of generated meshes too: left right bottom top ...
  std::string description;             ///< "rectangle(2, 1, cells = [32, 16])", "cross.msh"

  int nodes_per_cell() const { return dim + 1; }
  int nodes_per_facet() const { return dim; }
};

/// Signed measure (length, area, volume) of a cell; positive when it is well oriented.
double cell_measure(const Mesh& mesh, int cell);
double facet_measure(const Mesh& mesh, int facet);
/// Unit normal of a facet, pointing out of facets[facet].cell.
Point facet_normal(const Mesh& mesh, int facet);

/// Builds `facets`: keeps `named` facets (given by their nodes) and adds every boundary facet.
/// Returns for each named facet its index. Throws Failure(bad_mesh) for a facet of no cell.
std::vector<std::int32_t> build_facets(Mesh& mesh,
                                       const std::vector<std::array<std::int32_t, 3>>& named);

/// Finds the cell that holds a point and its barycentric coordinates there (-1: outside by more
/// than a relative 1e-9). A uniform grid of buckets makes a look-up O(1).
class CellLocator {
public:
  explicit CellLocator(const Mesh& mesh);
  int find(const Point& p, std::array<double, 4>& barycentric) const;

private:
  const Mesh* mesh_;
  Point low_{}, high_{};
  std::array<int, 3> buckets_{1, 1, 1};
  std::vector<std::vector<std::int32_t>> cells_;
};

struct MeshQuality {
  double shortest_edge, longest_edge, h; ///< h = largest cell diameter
  double worst_aspect;                   ///< longest edge over inscribed diameter, scaled: 1 is best
  double measure;                        ///< total length, area or volume
  int pieces;                            ///< connected components
};
MeshQuality mesh_quality(const Mesh& mesh);

} // namespace hvi::solver
