// A hash of bytes that is the same on every machine.
#pragma once

#include <cstdint>
#include <string_view>

namespace hvi::solver {

/// XXH3 of 64 bits: by it changed files are known. It keeps out no forger.
std::uint64_t hash_of(std::string_view bytes);

} // namespace hvi::solver
