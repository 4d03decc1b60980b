// Numbers of a script and of its mesh, moved by one unit in the last place: what `stability` runs.
#pragma once

#include "lang/session.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace hvi::lang {

/// A number in the text of a script that may be moved.
struct Literal {
  std::size_t begin = 0, length = 0;
  double value = 0.0;
};

/// The numbers of the script's own file, whose text this is, that are data: not 0, no exponents
/// behind `^`, not in
/// `param`, `report`, `expect` or `study`, and only those with which the script still compiles when
/// they are moved (numbers of cells and steps must be whole).
std::vector<Literal> movable_literals(const std::string& path, const std::string& text,
                                      const CompileSettings& settings);

/// The text with each of them moved up or down, at random by `sample`.
std::string moved_text(const std::string& text, const std::vector<Literal>& literals,
                       std::uint64_t sample);

/// Moves every coordinate of the mesh that is not zero in the same way.
void move_nodes(solver::Mesh& mesh, std::uint64_t sample);

} // namespace hvi::lang
