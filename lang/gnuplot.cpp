// Drawing through gnuplot (gnuplot.hpp).
#include "lang/gnuplot.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/read_file.hpp"
#include "solver/output/file.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

namespace hvi::lang {
namespace {

namespace fs = std::filesystem;

constexpr const char* where_to_get_it = "apt-get install gnuplot-nox";

[[noreturn]] void fail(const std::string& what, const std::string& help = {}) {
  throw solver::Failure(solver::FailureKind::output, {}, what, help);
}

/// A folder that only this user can enter; it goes away with all that is in it.
class PrivateFolder {
public:
  PrivateFolder() {
    std::error_code error;
    const fs::path place = fs::temp_directory_path(error);
    if (error) fail(fmt::format("there is no folder for temporary files: {}", error.message()));
    name_ = (place / "hvi-picture.XXXXXX").string();
    if (::mkdtemp(name_.data()) == nullptr)
      fail(fmt::format("no folder for a picture can be made in `{}`: {}", place.string(),
                       std::strerror(errno)));
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder() {
    std::error_code ignore;
    fs::remove_all(name_, ignore);
  }
  fs::path path() const { return name_; }

private:
  std::string name_;
};

/// gnuplot's exit code in `folder`, reading `commands`; no start-up file of the user's is read.
int run_gnuplot(const fs::path& folder) {
  int failed = 0; // the first reason; without one of these gnuplot would draw somewhere else
  const auto set = [&failed](int status) { failed = failed != 0 ? failed : status; };
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  set(posix_spawn_file_actions_addchdir_np(&actions, folder.c_str()));
  set(posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "commands", O_RDONLY, 0));
  set(posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0));
  set(posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0));
  char program[] = "gnuplot", plain[] = "--default-settings";
  char* words[] = {program, plain, nullptr};
  pid_t child = 0;
  posix_spawnattr_t attributes; // we ignore what a closed pipe sends, gnuplot need not
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  if (failed == 0) set(::posix_spawnp(&child, program, &actions, &attributes, words, environ));
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    fail(fmt::format("gnuplot cannot be started: {}", std::strerror(failed)),
         failed == ENOENT ? where_to_get_it : "");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

void plot(const std::string& commands, const fs::path& picture, Canvas canvas) {
  const bool svg = picture.extension() == ".svg";
  const PrivateFolder folder;
  const std::string head =
      fmt::format("set terminal {} size {},{}{}\nset output 'drawn'\n", svg ? "svg" : "pngcairo",
                  canvas.width, canvas.height, svg && canvas.white ? " background 'white'" : "");
  solver::write_atomically(folder.path() / "commands", head + commands);
  const bool drawn = run_gnuplot(folder.path()) == 0;
  const std::string bytes = drawn ? solver::read_file(folder.path() / "drawn").value_or("") : "";
  if (bytes.empty())
    fail(fmt::format("gnuplot did not draw `{}`", picture.filename().string()), where_to_get_it);
  solver::write_atomically(picture, bytes, solver::Durability::synced);
}

std::string quoted(std::string text) {
  std::erase_if(text, [](char c) {
    return c == '\'' || c == '\\' || c == '`' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  return "'" + text + "'";
}

} // namespace hvi::lang
