// Base64 and zlib blocks as VTK writes them inside XML.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace hvi::solver {

std::string base64(std::span<const std::byte> bytes);

/// VTK's compressed array: base64 of the UInt64 header [blocks, block size, size of a last partial
/// block, compressed sizes...] followed by base64 of the zlib blocks. No bytes: one header of
/// zeros.
std::string vtk_compressed(std::span<const std::byte> bytes);

} // namespace hvi::solver
