// A mesh as a picture of it sees it: what faces the viewer, in which colour, and what is in front.
#pragma once

#include "lang/draw/axes.hpp"
#include "lang/draw/raster.hpp"
#include "solver/time/run.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hvi::lang {

using Place = draw::Spot; ///< of the plane of the view, or of the sheet

/// A point in the plane of the view: the plane itself in 1D and 2D.
Place flat(const solver::Point& p, int dim);

/// The box of a mesh in the plane of the view.
struct ViewBox {
  Place low{1e300, 1e300}, high{-1e300, -1e300};

  double size() const { return std::max(high[0] - low[0], high[1] - low[1]); }
};
ViewBox view_box(const solver::Mesh& mesh);

/// A part that is all cells has no colour of its own.
bool is_whole(const solver::Discretisation& d, std::size_t part);

constexpr draw::Colour plain{0.894, 0.894, 0.894};
draw::Colour colour_of(std::size_t part);

/// A triangle of the picture: a cell in 2D, in 3D a facet of the boundary whose outer side is
/// turned to the viewer.
struct Patch {
  draw::Triangle nodes{};
  std::int32_t entity = -1; ///< the cell, the facet
  draw::Colour colour = plain;
};
std::vector<Patch> patches(const solver::Discretisation& d);

/// The picture's triangles with what hides what, for a plane on a sheet.
class MeshSight {
public:
  MeshSight(const solver::Mesh& mesh, const std::vector<Patch>& all, const draw::Plane& plane);
  /// Which cell, or facet, is in front at a place of the plane of the view; -1: none.
  std::int32_t in_front(const Place& at) const;

private:
  draw::Raster raster_;
};

/// The triangles as an image that fills the plane: hidden surfaces are hidden. In 3D lit.
draw::Panel patches_panel(const solver::Mesh& mesh, const std::vector<Patch>& all,
                          const draw::Plane& plane, bool with_edges);

} // namespace hvi::lang
