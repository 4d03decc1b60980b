// Whole files.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <new>
#include <optional>
#include <string>

namespace hvi::solver {

/// The bytes of a file, `most` of them at most. Nothing, and `errno` says why, where the system
/// does not give them, and where it is no file: a pipe or a device may never end. A stream would
/// take memory that runs out for the end of the file; here it is a bad_alloc.
inline std::optional<std::string> read_file(const std::filesystem::path& path,
                                            std::size_t most = std::numeric_limits<off_t>::max()) {
  constexpr std::size_t least_room = 4096;
  struct Descriptor {
    int number;
    ~Descriptor() { // the reason is told afterwards
      const int error = errno;
      if (number >= 0) ::close(number);
      errno = error;
    }
  };
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct stat status {};
  if (file.number < 0 || ::fstat(file.number, &status) != 0) {
    if (errno == ENOMEM) throw std::bad_alloc();
    return std::nullopt;
  }
  if (!S_ISREG(status.st_mode)) {
    errno = EINVAL;
    return std::nullopt;
  }
  // One more than its size shows the end; files of the system have no size before they are read.
  std::string bytes(std::min(most, static_cast<std::size_t>(status.st_size) + 1), '\0');
  std::size_t done = 0;
  while (done < most) {
    if (done == bytes.size()) bytes.resize(std::min(most, 2 * done + least_room));
    const auto got = ::read(file.number, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

} // namespace hvi::solver
