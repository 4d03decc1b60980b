// See hash.hpp.
#include "solver/common/hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace hvi::solver {

std::uint64_t hash_of(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

} // namespace hvi::solver
