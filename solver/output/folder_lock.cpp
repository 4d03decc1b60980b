// See folder_lock.hpp.
#include "solver/output/folder_lock.hpp"

#include "solver/output/temporary_file.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <string>
#include <system_error>
#include <thread>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, const std::string& reason) {
  throw Failure(FailureKind::output_folder, {},
                fmt::format("cannot write into the folder `{}`: {}", folder.string(), reason));
}

/// "process 4711 on host, begun 2026-01-31 12:00:00 UTC"
std::string ourselves() {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 64> when{};
  std::strftime(when.data(), when.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  return fmt::format("process {} on {}, begun {}", ::getpid(), host.data(), when.data());
}

/// What the holder has written; it may be about to.
std::string holder(int descriptor) {
  for (int i = 0; i < 20; ++i) {
    std::array<char, 512> text{};
    const auto got = ::pread(descriptor, text.data(), text.size(), 0);
    const std::string out(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
    if (out.ends_with('\n')) return out.substr(0, out.size() - 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return "another run";
}

} // namespace

FolderLock::FolderLock(fs::path folder)
    : folder_(std::move(folder)), name_(folder_ / ".hvi-run.lock") {
  std::error_code error;
  made_ = fs::create_directories(folder_, error);
  if (error) refuse(folder_, error.message());
  try {
    hold();
  } catch (const Failure&) {
    leave();
    throw;
  }
}

void FolderLock::hold() {
  while (!take()) {
  }
  const std::string text = fmt::format("{}\n", ourselves());
  const bool told = ::ftruncate(descriptor_, 0) == 0 && write_all(descriptor_, text);
  if (told || errno == EBADF || errno == EINVAL)
    return; // another user's lock file, which we may hold but not change
  const std::string reason = std::strerror(errno);
  ::unlink(name_.c_str());
  ::close(descriptor_);
  refuse(folder_, reason);
}

/// False when the file was removed by the one who held it: there is a new one to take.
bool FolderLock::take() {
  descriptor_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0 && errno == EACCES)
    descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor_ < 0) {
    const int reason = errno;
    std::error_code error;
    if (reason == ENOENT && fs::create_directories(folder_, error)) return false; // it was empty
    refuse(folder_, std::strerror(reason));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    const std::string who = holder(descriptor_);
    ::close(descriptor_);
    throw Failure(
        FailureKind::busy_folder, {},
        fmt::format("another run writes into the folder `{}`: {}", folder_.string(), who));
  }
  struct stat held {
  }, named{};
  if (::fstat(descriptor_, &held) == 0 && ::stat(name_.c_str(), &named) == 0 &&
      held.st_ino == named.st_ino && held.st_dev == named.st_dev)
    return true;
  ::close(descriptor_);
  return false;
}

/// Only where it is empty.
void FolderLock::leave() const {
  if (made_) ::rmdir(folder_.c_str());
}

FolderLock::~FolderLock() {
  ::unlink(name_.c_str());
  ::close(descriptor_);
  leave();
}

} // namespace hvi::solver
