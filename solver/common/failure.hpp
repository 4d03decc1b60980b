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

/// Kinds of failure. Whoever reports one knows each by its kind alone: the language has a table of
/// codes and exit codes, the command line the options that help.
enum class FailureKind {
  missing_file,        ///< a mesh or table file that is not there or cannot be read
  broken_file,         ///< a file that is there and is not what it should be
  unasked_geometry,    ///< a geometry file, which can run programs and was not allowed to
  unknown_group,       ///< a group or side that the mesh does not have
  empty_region,        ///< a part without entities
  overlapping_regions, ///< clamped and contact part share a face, a law twice on a part
  bad_mesh,            ///< inverted, degenerate or disconnected cells
  no_revolution,       ///< a mesh that is no half section of a body of revolution
  bad_value,           ///< data not finite, a point outside the mesh, incompatible initial state
  not_coercive,        ///< rigid motions left, or a matrix that is not positive definite
  not_elliptic,        ///< a tensor that is not positive definite
  bad_law,             ///< a law that is not locally Lipschitz at a point
  bad_kernel,          ///< a kernel that is not integrable or not finite
  not_certified,       ///< a step without certificate
  mostly_rounding,     ///< a result, or a step, that is mostly rounding
  limit,               ///< a limit of size or steps was met, on every machine
  too_large,           ///< more memory than this process may take: another machine may do
  out_of_reach,        ///< no setting within the limits has the wanted accuracy
  bad_checkpoint,      ///< a checkpoint that is damaged, of another format, or of another problem
  output,              ///< a result that could not be written
  special_output,      ///< a device, a pipe or a socket where a result should go
  output_folder,       ///< a folder of results that could not be made or written to
  busy_folder,         ///< another run writes into the folder of results
  interrupted,         ///< the user asked to stop
  suspended            ///< the user asked to stop, and the state is saved
};

/// Is it about writing results?
constexpr bool concerns_output(FailureKind kind) {
  using K = FailureKind;
  return kind == K::output || kind == K::special_output || kind == K::output_folder ||
         kind == K::busy_folder;
}

struct Failure : std::runtime_error {
  Failure(FailureKind kind_, Origin origin_, const std::string& message, std::string help_ = {})
      : std::runtime_error(message), kind(kind_), origin(origin_), help(std::move(help_)) {}
  FailureKind kind;
  Origin origin;
  /// What the user can do. Empty also where that depends on how the user asked (a name for the
  /// folder, a budget): the kind says it then.
  std::string help;
};

} // namespace hvi::solver
