// What the engine reports when it cannot go on. Every report carries the origin of the plan item
// that caused it, so that the language can underline the line of the script.
#pragma once

#include <stdexcept>
#include <string>

namespace hvi::solver {

/// An opaque id of a plan item: whoever made the plan knows what it stands for. -1: nobody's.
struct Origin {
  int id = -1;
  friend bool operator==(const Origin&, const Origin&) = default;
};

/// Kinds of failure; the language maps each to a diagnostic code and an exit code.
enum class FailureKind {
  missing_file,        ///< a mesh or table file that is not there or cannot be read
  broken_file,         ///< a file that is there and is not what it should be
  unknown_group,       ///< a group or side that the mesh does not have
  empty_region,        ///< a part without entities
  overlapping_regions, ///< clamped and contact part share a face, a law twice on a part
  bad_mesh,            ///< inverted, degenerate or disconnected cells
  bad_value,           ///< data not finite, a point outside the mesh, incompatible initial state
  not_coercive,        ///< rigid motions left, or a matrix that is not positive definite
  not_elliptic,        ///< a tensor that is not positive definite
  bad_law,             ///< a law that is not locally Lipschitz at a point
  bad_kernel,          ///< a kernel that is not integrable or not finite
  not_certified,       ///< a step without certificate
  limit,               ///< a limit of size, memory or steps was met
  output,              ///< a result that could not be written
  interrupted          ///< the user asked to stop
};

struct Failure : std::runtime_error {
  Failure(FailureKind kind_, Origin origin_, const std::string& message, std::string help_ = {})
      : std::runtime_error(message), kind(kind_), origin(origin_), help(std::move(help_)) {}
  FailureKind kind;
  Origin origin;
  std::string help; ///< what the user can do, or empty
};

} // namespace hvi::solver
