// Files that are whole or not there: every result goes through `write_atomically`.
#pragma once

#include <filesystem>
#include <string_view>

namespace hvi::solver {

enum class Durability {
  ordinary,
  synced
}; ///< synced: on the disk before the name changes, and so is the name

/// Writes `bytes` to a temporary file in the folder of `path` (made when missing), then renames it.
/// A reader sees the old file or the new one, never half of one. Throws Failure(output) with the
/// path and the system's reason (full disk, no permission, a folder in the way).
void write_atomically(const std::filesystem::path& path, std::string_view bytes,
                      Durability durability = Durability::ordinary);

} // namespace hvi::solver
