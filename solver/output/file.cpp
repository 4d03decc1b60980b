// Atomic files: temporary file, write, close, rename. Last stage of the pipeline.
#include "solver/output/file.hpp"

#include "solver/common/failure.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace hvi::solver {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw Failure(FailureKind::output, {}, "cannot write `" + path.string() + "`: " + reason,
                "choose another output folder, or make room and give permission to write there");
}

/// A file descriptor with the temporary file's name; both go away unless `keep` is called.
class TemporaryFile {
public:
  explicit TemporaryFile(const std::filesystem::path& target)
      : name_(target.string() + ".XXXXXX"), descriptor_(::mkostemp(name_.data(), O_CLOEXEC)) {}
  /// An open file that is not ours to remove.
  TemporaryFile(const std::filesystem::path& target, int descriptor)
      : name_(target.string()), descriptor_(descriptor) {}
  bool is_open() const { return descriptor_ >= 0; }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (opened_ && !kept_) ::unlink(name_.c_str());
  }

  bool open() {
    opened_ = descriptor_ >= 0;
    // mkstemp makes the file private; results are meant to be read by others.
    return opened_ && ::fchmod(descriptor_, 0644) == 0;
  }
  bool write(std::string_view bytes) {
    while (!bytes.empty()) {
      const auto written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
  }
  bool sync() { return ::fsync(descriptor_) == 0; }
  /// Some systems report a full disk only here.
  bool close() { return ::close(std::exchange(descriptor_, -1)) == 0; }
  bool rename_to(const std::filesystem::path& target) {
    kept_ = ::rename(name_.c_str(), target.c_str()) == 0;
    return kept_;
  }

private:
  std::string name_;
  int descriptor_;
  bool opened_ = false, kept_ = false;
};

} // namespace

namespace {

/// A device or a pipe (/dev/stdout, /dev/full) is written to; a rename would replace it by a file.
bool is_special(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  return !error && std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
         !std::filesystem::is_directory(status);
}

void write_directly(const std::filesystem::path& path, std::string_view bytes) {
  TemporaryFile file(path, ::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.is_open() || !file.write(bytes) || !file.close()) fail(path, std::strerror(errno));
}

/// A new name lasts when the folder that holds it is on the disk, too.
bool sync_folder(const std::filesystem::path& folder) {
  const int descriptor =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL; // some file systems cannot
  ::close(descriptor);
  return synced;
}

} // namespace

void write_atomically(const std::filesystem::path& path, std::string_view bytes,
                      Durability durability) {
  if (path.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (error) fail(path, error.message());
  }
  if (is_special(path)) return write_directly(path, bytes);
  TemporaryFile file(path);
  const bool written = file.open() && file.write(bytes) &&
                       (durability == Durability::ordinary || file.sync()) && file.close() &&
                       file.rename_to(path) &&
                       (durability == Durability::ordinary || sync_folder(path.parent_path()));
  if (!written) fail(path, std::strerror(errno));
}

} // namespace hvi::solver
