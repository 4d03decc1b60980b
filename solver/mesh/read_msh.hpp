// Reader of gmsh's MSH 2.2 and 4.1 files, ascii and binary. Our own, because libgmsh executes what
// it reads (docs/decisions). Knows no other format and opens no other file.
#pragma once

#include "solver/mesh/mesh.hpp"
#include "solver/mesh/straightening.hpp"

#include <string>
#include <string_view>

namespace hvi::solver {

/// Parses the bytes of an .msh file. Physical groups become groups; nodes of no cell are dropped.
/// `straightened`, if given, gets what is lost of cells of second order. Throws
/// Failure(broken_file) saying what was expected and where (line, or byte offset).
Mesh parse_msh(std::string_view bytes, const std::string& name,
               Straightening* straightened = nullptr);
/// Reads the file, then parse_msh. Throws Failure(missing_file).
Mesh read_msh(const std::string& path, Straightening* straightened = nullptr);

} // namespace hvi::solver
