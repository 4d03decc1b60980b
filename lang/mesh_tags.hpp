// Where the names of parts stand in the picture of a mesh.
#pragma once

#include "lang/mesh_sight.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hvi::lang {

constexpr double tag_arrow = 26.0, tag_size = 13.0; ///< of normals and lines, of names

/// A place of the part, and what leads from there to its name.
struct Tag {
  enum class Kind : std::uint8_t { normal, line, none }; ///< none: the name stands on the part
  Place at{}, outward{};
  Kind kind = Kind::none;
};

/// By part; none: nothing of it is seen. Names of pieces of the body stand on them where they find
/// room, otherwise beside the body with a line to the piece.
std::vector<std::optional<Tag>> tags_of(const solver::Discretisation& d,
                                        std::span<const std::string> names, const MeshSight& sight,
                                        const draw::Plane& plane);

} // namespace hvi::lang
