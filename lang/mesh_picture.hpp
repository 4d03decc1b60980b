// A picture of a mesh with the parts of a script, before anything is solved.
#pragma once

#include "lang/script.hpp"
#include "solver/time/run.hpp"

#include <filesystem>

namespace hvi::lang {

/// The parts of the script, each with what it is made of and its measure, a line each.
std::string describe_parts(const Script& script, const solver::Discretisation& discretisation);
/// Draws cells (in 3D the surface that is seen) in grey and the script's parts in colours: pieces
/// of the body as areas, parts of its boundary as lines or areas, points as dots. Throws
/// Failure(output).
void draw_mesh(const Script& script, const solver::Discretisation& discretisation,
               const std::filesystem::path& picture);

} // namespace hvi::lang
