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
/// A reader sees the old file or the new one, never half of one; its mode is what the umask says.
/// Throws Failure(output) with the path and the system's reason (full disk, no permission, a folder
/// in the way), for a device or a pipe, too: nothing could take its place.
void write_atomically(const std::filesystem::path& path, std::string_view bytes,
                      Durability durability = Durability::ordinary);

/// New bytes for a file that is there, or for what a symbolic link leads to: its mode, owner, names
/// (hard links) and attributes stay. Atomic where it has one name only and no attributes; else it
/// is written over, and what it held comes back when that fails. Throws Failure(output).
void rewrite_file(const std::filesystem::path& path, std::string_view bytes);

/// One line more at the end of a file, after a newline that a killed writer may have left out. What
/// a failed write left is cut off again. Throws Failure(output).
void append_line(const std::filesystem::path& path, std::string_view line,
                 Durability durability = Durability::synced);

/// Throws what `write_atomically` would throw for `path`, as far as that shows before there is
/// anything to write.
void try_to_write(const std::filesystem::path& path);

/// Removes the temporary files in a folder whose writers have died. Each writer holds a lock on its
/// file for as long as it lives: those of other runs stay.
void remove_leftovers(const std::filesystem::path& folder);

} // namespace hvi::solver
