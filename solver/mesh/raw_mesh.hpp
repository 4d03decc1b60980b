// A mesh as a file or gmsh gives it: tags instead of indices, elements of all dimensions mixed.
// Internal to solver/mesh; between the readers (read_msh, gmsh_module) and a proper Mesh.
#pragma once

#include "solver/mesh/mesh.hpp"
#include "solver/mesh/straightening.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

struct RawMesh {
  /// A piece of the geometry and the physical groups (tags) it is in.
  struct Entity {
    int dim = 0;
    int tag = 0;
    std::vector<int> physical;
    bool reversed = false;             ///< in its groups: facets inside the body look the other way
    std::vector<char> against_first{}; ///< by group: not as in the first one

    /// gmsh tells by the sign of a group's tag how an entity is turned in it: that of the first one
    /// becomes `reversed`. (In MSH 2.2 the elements themselves are turned.)
    void take_signs();
  };
  /// A simplex given by the tags of its corners.
  struct Element {
    int dim = 0;
    std::int32_t entity = -1; ///< index into entities; -1: in no group
    std::int64_t tag = 0;
    std::array<std::int64_t, 4> nodes{};
  };
  /// The nodes of an element of second order that are no corners, in gmsh's order: as many as a
  /// simplex of its dimension has edges.
  struct Middles {
    std::size_t element = 0; ///< index into elements
    std::array<std::int64_t, 6> nodes{};
  };
  std::vector<std::int64_t> node_tags;
  std::vector<Point> coordinates; ///< of node_tags
  std::vector<Entity> entities;
  std::vector<Element> elements;
  std::vector<Middles> middles;                     ///< by increasing element
  std::map<std::pair<int, int>, std::string> names; ///< (dim, physical tag) -> name
};

/// What a gmsh element type is, as far as we read it: corners are the first dim + 1 nodes.
struct ElementType {
  int dim;
  int nodes;
};
/// Throws Failure(broken_file), prefixed with what `where` says, for a type that is not a simplex.
ElementType element_type(std::int64_t type, const std::function<std::string()>& where);

/// The elements of the highest dimension become cells (flipped where negative), those one lower
/// named facets if they are in a group, the nodes of the others groups of points. Nodes of no cell
/// are dropped, and so are those in the middle of edges: `straightened`, if given, gets what that
/// changes. A physical group without a name is called by its tag ("7"); groups of different
/// kinds with one name are told apart as "name (cells)", "name (facets)", "name (points)".
/// Throws Failure(broken_file) for inconsistent tags and Failure(bad_mesh) for degenerate or
/// repeated cells, a mesh that is not flat, facets of no cell.
Mesh assemble(const RawMesh& raw, const std::string& name, Straightening* straightened = nullptr);

} // namespace hvi::solver
