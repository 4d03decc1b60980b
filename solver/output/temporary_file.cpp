// See temporary_file.hpp.
#include "solver/output/temporary_file.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

namespace hvi::solver {
namespace {

constexpr int most_tries = 100;
constexpr std::size_t most_of_name = 200; // of the 255 bytes that a name may have

std::string random_letters() {
  std::array<unsigned char, 8> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) < 0) return {};
  std::string out;
  for (const unsigned char byte : bytes) out += static_cast<char>('a' + byte % 26);
  return out;
}

/// Do we have the lock, and is the file still under its name? (On a system without locks no other
/// run removes the file either.)
bool is_ours(int descriptor) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

} // namespace

TemporaryFile::TemporaryFile(const std::filesystem::path& target) {
  const auto start = fmt::format(".{}.", target.filename().string().substr(0, most_of_name));
  for (int i = 0; i < most_tries && !open_under(target.parent_path(), start); ++i)
    if (errno != EEXIST) return;
}

/// False with EEXIST where another name may do.
bool TemporaryFile::open_under(const std::filesystem::path& folder, const std::string& start) {
  name_ = (folder / fmt::format("{}{}{}", start, random_letters(), temporary_ending)).string();
  const int opened = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW,
                            S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH);
  if (opened < 0) return false;
  if (!is_ours(opened)) { // someone who cleans up was quicker
    ::close(opened);
    errno = EEXIST;
    return false;
  }
  descriptor_ = opened;
  there_ = true;
  return true;
}

TemporaryFile::~TemporaryFile() {
  const int error = errno; // of the write that failed: the caller will tell it
  if (there_) ::unlink(name_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
  errno = error;
}

bool TemporaryFile::write(std::string_view bytes) { return write_all(descriptor_, bytes); }
bool TemporaryFile::sync() { return ::fsync(descriptor_) == 0; }

/// The lock stays with a second descriptor of the open file, or another run would take the file for
/// a dead writer's before it has its name.
bool TemporaryFile::close() {
  const int keeps_lock = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  return ::close(std::exchange(descriptor_, keeps_lock)) == 0;
}

bool TemporaryFile::rename_to(const std::filesystem::path& target) {
  if (::rename(name_.c_str(), target.c_str()) != 0) return false;
  there_ = false;
  return true;
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool sync_folder(const std::filesystem::path& folder) {
  const int descriptor =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL; // some file systems cannot
  ::close(descriptor);
  return synced;
}

} // namespace hvi::solver
