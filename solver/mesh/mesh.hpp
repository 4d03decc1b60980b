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
  std::array<std::int32_t, 3> nodes{-1, -1,
                                    -1}; ///< dim of them, ordered outwards (right-hand rule)
  std::int32_t cell = -1;                ///< the cell it bounds; its normal points out of it
  std::int32_t other = -1;               ///< the cell on the other side; -1: boundary
};

/// A named set of cells, facets, or points.
struct Group {
  enum class Kind : std::uint8_t { cells, facets, points };
  Kind kind = Kind::cells;
  std::vector<std::int32_t> entities; ///< sorted, unique
  bool of_lines = false;              ///< points: the corners of lines in space
  /// Facets: one inside the body is in another group, too, the other way round, and has the normal
  /// that it has there.
  bool against_another = false;
};

struct Mesh {
  int dim = 2;
  /// The half plane x >= 0 of a body of revolution about the y axis: x is r, y is z (2D only).
  bool axisymmetric = false;
  std::vector<Point> nodes;
  std::vector<std::array<std::int32_t, 4>> cells; ///< dim + 1 nodes each, positively oriented
  std::vector<Facet> facets;                      ///< all boundary facets, then named interior ones
  std::map<std::string, Group> groups; ///< sides of generated meshes too: left right bottom top ...
  std::string description;             ///< "rectangle(2, 1, cells = [32, 16])", "cross.msh"
  /// The first cell of each of several meshes put together, in their order; empty: one mesh.
  std::vector<std::int32_t> pieces{};

  /// Which of them a cell belongs to; 0 where there is one mesh.
  int piece_of_cell(std::int32_t cell) const;

  int nodes_per_cell() const { return dim + 1; }
  int nodes_per_facet() const { return dim; }
};

/// Signed measure (length, area, volume) of a cell; positive when it is well oriented.
double cell_measure(const Mesh& mesh, int cell);
double facet_measure(const Mesh& mesh, int facet);
/// Unit normal of a facet, pointing out of facets[facet].cell.
Point facet_normal(const Mesh& mesh, int facet);

/// Builds `facets`: keeps `named` facets (given by their nodes) and adds every boundary facet.
/// Returns for each named facet its index. The node order of a named interior facet chooses which
/// side is its `cell`: the one it points out of (1D: the left one). Throws Failure(bad_mesh) for a
/// facet of no cell, a facet of three cells, and two cells on the same side of a facet.
std::vector<std::int32_t> build_facets(Mesh& mesh,
                                       const std::vector<std::array<std::int32_t, 3>>& named);

/// Corners of the smallest box around the mesh.
struct Box {
  Point low{}, high{};
  double diagonal() const;
};
Box bounding_box(const Mesh& mesh);

/// The barycentric coordinates of a point in a cell; outside of it some are below 0.
std::array<double, 4> barycentric_of(const Mesh& mesh, std::int32_t cell, const Point& p);

/// Finds the cell that holds a point and its barycentric coordinates there (-1: outside, some
/// barycentric coordinate below -1e-9). On a common side of cells the answer is one of them, always
/// the same; where several pieces of a mesh meet, one of the first of them. A tree of boxes: O(log
/// cells) a look-up whatever the grading and the stretching of the cells, where a uniform grid of
/// buckets degrades. Keeps a pointer to the mesh.
class CellLocator {
public:
  /// For about so many points: a few are found by going through all cells.
  explicit CellLocator(const Mesh& mesh, std::size_t points = 1000);
  /// The cell that holds p, the deepest of several, with p's barycentric coordinates in it; -1:
  /// none. `looked_at` gains the number of boxes and cells that were compared with p.
  int find(const Point& p, std::array<double, 4>& barycentric,
           std::size_t* looked_at = nullptr) const;

private:
  struct Node {
    Box box;
    std::int32_t first = 0,
                 count = 0; ///< leaf: cells order_[first ...]; else count 0, child `first`
  };
  void build(std::int32_t node, std::int32_t first, std::int32_t past,
             const std::vector<Point>& centres);

  const Mesh* mesh_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
  double widest_margin_ = 0.0; ///< without a tree: the box of no cell is widened by more
};

struct MeshQuality {
  double shortest_edge, longest_edge, h; ///< h = largest cell diameter
  double worst_aspect; ///< longest edge over inscribed diameter, scaled: 1 is best
  double measure;      ///< total length, area or volume
  int pieces;          ///< connected components
};
MeshQuality mesh_quality(const Mesh& mesh);
/// For each cell the number of its connected piece (0, 1, ...); cells that share a facet are
/// connected, cells that share only a node or (3D) an edge are not.
std::vector<std::int32_t> pieces_of(const Mesh& mesh);

/// Groups with dimension, number of entities and measure; nodes, cells, sizes and quality; a few
/// lines of text for `hvi-run mesh FILE`.
std::string describe_mesh(const Mesh& mesh);

} // namespace hvi::solver
