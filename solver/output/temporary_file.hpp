// A file under a name of its own until it is whole. Used by file.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace hvi::solver {

/// Beside its target, `.NAME.XXXXXXXX.hvi-part`; it goes away unless it is renamed. Its writer
/// holds a lock on it, so that `remove_leftovers` tells dead writers' files from those of living
/// ones.
class TemporaryFile {
public:
  /// With the permissions that the umask leaves of rw-rw-rw-.
  explicit TemporaryFile(const std::filesystem::path& target);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  bool write(std::string_view bytes);
  bool sync();
  /// After the last write. Some systems report a full disk only here.
  bool close();
  bool rename_to(const std::filesystem::path& target);

private:
  bool open_under(const std::filesystem::path& folder, const std::string& start);

  std::string name_;
  int descriptor_ = -1;
  bool there_ = false;
};

/// All bytes, however many calls that takes.
bool write_all(int descriptor, std::string_view bytes);

/// A new name lasts when the folder that holds it is on the disk, too.
bool sync_folder(const std::filesystem::path& folder);

/// How the name of every temporary file ends.
inline constexpr std::string_view temporary_ending = ".hvi-part";

} // namespace hvi::solver
