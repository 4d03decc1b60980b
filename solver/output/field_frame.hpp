// Fields at one time, each on the grid it lives on: what pictures and viewers show.
#pragma once

#include "solver/output/vtu.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

/// How the point of a law lies on the law's graph.
enum class BranchKind : std::uint8_t {
  open,          ///< the multiplier is zero on a piece of the graph
  loaded,        ///< on a piece along which the multiplier does not fall
  softened,      ///< on a piece along which it falls
  held,          ///< inside a jump of the graph: rigid contact
  stick,         ///< friction: inside the ball at zero
  slip,          ///< friction: the bound is reached
  slip_softened, ///< and falls with the slip
};

/// The grid of the body (no name), of a field on the contact (the field's name) or of the points of
/// a law (the law's name).
struct FieldGrid {
  std::string name;
  VtuGrid grid;
};

struct FieldFrame {
  double t = 0.0;
  int step = 0;
  std::vector<FieldGrid> grids;
};

/// Names of the arrays that a frame has besides the fields that were asked for.
inline constexpr const char* displacement_array = "displacement"; ///< of the first vector unknown
inline constexpr const char* multiplier_array = "xi"; ///< of a law's points, global directions
inline constexpr const char* force_array = "force";   ///< -M^T xi, which acts on the body
inline constexpr const char* branch_array = "branch"; ///< BranchKind

} // namespace hvi::solver
