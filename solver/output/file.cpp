// Atomic files: temporary file, write, close, rename. Last stage of the pipeline.
#include "solver/output/file.hpp"

#include "solver/common/failure.hpp"
#include "solver/output/temporary_file.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

constexpr const char* choose_another =
    "choose another output folder, or make room and give permission to write there";

std::string refusal(const fs::path& path, const std::string& reason) {
  return fmt::format("cannot write `{}`: {}", path.string(), reason);
}

[[noreturn]] void fail(const fs::path& path, const std::string& reason,
                       const char* help = choose_another) {
  throw Failure(FailureKind::output, {}, refusal(path, reason), help);
}

void make_folder(const fs::path& path) {
  if (!path.has_parent_path()) return;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) fail(path, error.message());
}

/// A rename would replace a device or a pipe by a file, or is refused by a folder.
void refuse_special(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (error || !fs::exists(status) || fs::is_regular_file(status)) return;
  if (fs::is_directory(status)) fail(path, "a folder of this name is in the way");
  throw Failure(FailureKind::special_output, {},
                refusal(path, "it is a device, a pipe or a socket"));
}

/// The descriptor of a file that is there.
class OpenFile {
public:
  OpenFile(const fs::path& path, int flags)
      : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  bool is_open() const { return descriptor_ >= 0; }
  int get() const { return descriptor_; }

private:
  int descriptor_;
};

/// May another file take its place without a loss: one name, an owner that can be kept, no
/// attributes (which hold access lists)?
bool can_be_replaced(const fs::path& path, const struct stat& status) {
  return status.st_nlink == 1 && ::listxattr(path.c_str(), nullptr, 0) <= 0;
}

bool replace_file(const fs::path& path, const struct stat& status, std::string_view bytes) {
  TemporaryFile file(path);
  struct stat made {};
  if (!file.is_open() || ::fstat(file.descriptor(), &made) != 0) return false;
  if ((made.st_uid != status.st_uid || made.st_gid != status.st_gid) &&
      ::fchown(file.descriptor(), status.st_uid, status.st_gid) != 0)
    return false;
  return ::fchmod(file.descriptor(), status.st_mode & 07777) == 0 && file.write(bytes) &&
         file.sync() && file.close() && file.rename_to(path) && sync_folder(path.parent_path());
}

/// The first bytes of a file, which it keeps.
bool put_at_start(int descriptor, std::string_view bytes) {
  return ::lseek(descriptor, 0, SEEK_SET) == 0 && write_all(descriptor, bytes) &&
         ::ftruncate(descriptor, static_cast<off_t>(bytes.size())) == 0 && ::fsync(descriptor) == 0;
}

std::string content_of(int descriptor, std::size_t size) {
  std::string out(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const auto got = ::pread(descriptor, out.data() + done, size - done, static_cast<off_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  out.resize(done);
  return out;
}

} // namespace

void write_atomically(const fs::path& path, std::string_view bytes, Durability durability) {
  make_folder(path);
  refuse_special(path);
  TemporaryFile file(path);
  const bool synced = durability == Durability::synced;
  const bool written = file.is_open() && file.write(bytes) && (!synced || file.sync()) &&
                       file.close() && file.rename_to(path) &&
                       (!synced || sync_folder(path.parent_path()));
  if (!written) fail(path, std::strerror(errno));
}

void rewrite_file(const fs::path& path, std::string_view bytes) {
  constexpr const char* help = "give permission to write the file, or make room";
  std::error_code error;
  const fs::path target = fs::canonical(path, error); // a link stays one
  struct stat status {};
  if (error) fail(path, error.message(), help);
  if (::access(target.c_str(), W_OK) != 0 || ::stat(target.c_str(), &status) != 0)
    fail(path, std::strerror(errno), help);
  remove_leftovers(target.parent_path());
  if (can_be_replaced(target, status) && replace_file(target, status, bytes)) return;
  const OpenFile file(target, O_RDWR);
  if (!file.is_open()) fail(path, std::strerror(errno), help);
  const std::string before = content_of(file.get(), static_cast<std::size_t>(status.st_size));
  if (before.size() != static_cast<std::size_t>(status.st_size))
    fail(path, "it cannot be read again", help);
  if (put_at_start(file.get(), bytes)) return;
  const int reason = errno;
  put_at_start(file.get(), before); // its blocks are there
  fail(path, std::strerror(reason), help);
}

void append_line(const fs::path& path, std::string_view line, Durability durability) {
  make_folder(path);
  refuse_special(path);
  const OpenFile file(path, O_RDWR | O_CREAT | O_APPEND);
  const off_t before = file.is_open() ? ::lseek(file.get(), 0, SEEK_END) : -1;
  if (before < 0) fail(path, std::strerror(errno));
  char last = '\n';
  if (before > 0 && ::pread(file.get(), &last, 1, before - 1) != 1)
    fail(path, std::strerror(errno));
  const std::string text = fmt::format("{}{}\n", last == '\n' ? "" : "\n", line);
  if (write_all(file.get(), text) &&
      (durability == Durability::ordinary || ::fsync(file.get()) == 0))
    return;
  const int reason = errno;
  if (::ftruncate(file.get(), before) != 0) errno = reason; // the next line begins with a newline
  fail(path, std::strerror(reason));
}

void try_to_write(const fs::path& path) {
  make_folder(path);
  refuse_special(path);
  const TemporaryFile file(path);
  if (!file.is_open()) fail(path, std::strerror(errno));
}

void remove_leftovers(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, error), end; !error && at != end;
       at.increment(error)) {
    const auto name = at->path().filename().string();
    if (!name.starts_with('.') || !name.ends_with(temporary_ending)) continue;
    const OpenFile file(at->path(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
    if (file.is_open() && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0) ::unlink(at->path().c_str());
  }
}

} // namespace hvi::solver
