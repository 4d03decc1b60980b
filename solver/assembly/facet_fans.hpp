// Normals at nodes of a surface that is made of flat facets: a smooth one that they stand for has
// one normal at a node, a mean of theirs; across a crease there are two.
#pragma once

#include "solver/fem/space.hpp"

#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace hvi::solver {

/// Facets of a region and how they meet at its nodes. Numbers of facets are places in the list
/// given.
///
/// At a corner the normal is along sum w_f n_f, with w_f = 1/length in 2D and sin a/(|e1| |e2|) in
/// 3D, the edges e1 and e2 there and the angle a between them (N. Max; S. Jin, R. R. Lewis, D.
/// West, A comparison of algorithms for vertex normal computation, The Visual Computer). On a
/// circle and a ball that is the radius whatever the facets' sizes; weights by area turn it towards
/// the larger ones, by a part of the angle from facet to facet. At an end of the surface facets are
/// on one side only: there the mean m is turned, by the least d across it with (m + d + n_j) . e =
/// 0 along the edges e to corners j that have facets all about, or are turned already (on circles
/// and balls n_i + n_j is across the chord). In the middle of an edge the normal is along n_i +
/// n_j.
class FacetFans {
public:
  FacetFans(const Space& space, std::span<const std::int32_t> facets);

  std::size_t size() const { return normals_.size(); }
  double measure(std::size_t f) const { return measures_[f]; }
  const Point& normal(std::size_t f) const { return normals_[f]; }
  /// The facets at a node that f is joined to by others without a crease between them, f among
  /// them, in increasing order. f alone where they point all about, as at the tip of a needle: they
  /// have no common normal.
  std::vector<int> about(int f, std::int32_t node) const;
  /// At node `local` of facet f, in the order of Space::nodes_of_facet.
  Point normal_at(int f, int local) const;

private:
  struct Member {
    int facet;
    double weight;
  };
  struct Corner {
    Point normal;
    bool known; ///< facets of the fan all about, or turned
  };
  std::int32_t node(int f, int local) const;
  const Point& place(int f, int local) const;
  const Corner& corner(int f, int local) const;
  Corner mean(const std::vector<int>& fan, std::int32_t node) const;
  bool is_closed(const std::vector<int>& fan, std::int32_t node) const;
  struct End {
    Point normal;
    bool whole; ///< its edges to known corners are not all along one line of a surface in space
  };
  bool turn_ends();
  std::optional<End> at_end(const Corner& mean, const std::vector<int>& fan,
                            std::int32_t node) const;

  const Space& space_;
  std::vector<std::int32_t> facets_;
  std::vector<Point> normals_;
  std::vector<double> measures_;
  std::unordered_map<std::int32_t, std::vector<Member>> at_node_;
  std::map<std::pair<std::int32_t, int>, Corner> corners_; ///< by node and first facet of the fan
  std::vector<const Corner*> corner_of_;                   ///< by facet and local corner
};

} // namespace hvi::solver
