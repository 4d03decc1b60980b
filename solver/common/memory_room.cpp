// See memory_room.hpp. Linux: /proc and the control groups' folders.
#include "solver/common/memory_room.hpp"

#include <fmt/format.h>

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

constexpr double unknown = std::numeric_limits<double>::infinity();
constexpr auto whole_line = std::numeric_limits<std::streamsize>::max();

/// The number after a name in a file of lines `name number`; nothing: not there.
std::optional<double> entry(const fs::path& file, const std::string& name) {
  std::ifstream in(file);
  for (std::string word; in >> word; in.ignore(whole_line, '\n'))
    if (double value = 0.0; word == name && in >> value) return value;
  return std::nullopt;
}

/// A file of one number; nothing where it is not there, or says "max".
std::optional<double> number(const fs::path& file) {
  std::ifstream in(file);
  double value = 0.0;
  if (in >> value) return value;
  return std::nullopt;
}

/// Of one control group; version 1 says "no limit" with a number near 2^63.
std::optional<double> room_of_group(const fs::path& folder) {
  const bool second = fs::exists(folder / "memory.max");
  const auto limit = number(folder / (second ? "memory.max" : "memory.limit_in_bytes"));
  const auto used = number(folder / (second ? "memory.current" : "memory.usage_in_bytes"));
  if (!limit || !used || *limit > 1e18) return std::nullopt;
  const auto cache =
      entry(folder / "memory.stat", second ? "inactive_file" : "total_inactive_file");
  return std::max(0.0, *limit - *used + cache.value_or(0.0));
}

struct Mount {
  fs::path root, place;
  std::string type, options;
};

/// The lines of /proc/self/mountinfo that are control groups (proc(5)): id parent device root place
/// options [fields] - type source super-options.
std::vector<Mount> control_group_mounts() {
  std::vector<Mount> out;
  std::ifstream in("/proc/self/mountinfo");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string skip, root, place;
    words >> skip >> skip >> skip >> root >> place;
    while (words >> skip && skip != "-") {
    }
    Mount mount{root, place, "", ""};
    words >> mount.type >> skip >> mount.options;
    if (mount.type == "cgroup" || mount.type == "cgroup2") out.push_back(std::move(mount));
  }
  return out;
}

/// Of this process's control groups; lines of /proc/self/cgroup are `id:controllers:path`.
std::optional<double> own_groups_room() {
  std::optional<double> least;
  const auto mounts = control_group_mounts();
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == line.npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path path = line.substr(second + 1);
    const bool unified = controllers.empty();
    if (!unified && controllers.find("memory") == controllers.npos) continue;
    for (const Mount& mount : mounts) {
      if (unified != (mount.type == "cgroup2") ||
          (!unified && mount.options.find("memory") == std::string::npos))
        continue;
      fs::path inside = path.lexically_relative(mount.root); // in a container: of its own root
      if (inside.empty() || *inside.begin() == "..") inside = path.relative_path();
      const auto room = control_group_room((mount.place / inside).lexically_normal(), mount.place);
      if (room) least = std::min(*room, least.value_or(unknown));
    }
  }
  return least;
}

double limit_of(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
  return static_cast<double>(limit.rlim_cur);
}

/// In /proc/self/status sizes are in kB.
double own(const std::string& name) {
  return 1024.0 * entry("/proc/self/status", name).value_or(0.0);
}

constexpr const char* what_helps =
    "fewer cells or P1 need less; so do iterations (`using solver = iterative`) and a factor in "
    "single precision (`using factor = single`); fewer steps with `memory = direct`, and another "
    "route for it; several tensors that are multiples of one need one matrix";

} // namespace

std::optional<double> control_group_room(fs::path folder, const fs::path& top) {
  std::optional<double> least;
  for (;;) {
    if (const auto room = room_of_group(folder)) least = std::min(*room, least.value_or(unknown));
    if (folder == top || !folder.has_relative_path() || folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return least;
}

MemoryRoom memory_room() {
  MemoryRoom out{unknown, ""};
  const auto consider = [&](double bytes, const char* from) {
    if (bytes < out.bytes) out = {std::max(0.0, bytes), from};
  };
  if (const double limit = limit_of(RLIMIT_AS); limit < unknown)
    consider(limit - own("VmSize:"), "the limit on this process's addresses (ulimit -v)");
  if (const double limit = limit_of(RLIMIT_DATA); limit < unknown)
    consider(limit - own("VmData:"), "the limit on this process's data (ulimit -d)");
  if (const auto groups = own_groups_room())
    consider(*groups, "the limit of the process's control group");
  if (const auto available = entry("/proc/meminfo", "MemAvailable:"))
    consider(1024.0 * *available, "what this machine has available");
  return out;
}

double memory_held() { return own("VmRSS:"); }
double memory_peak() { return own("VmHWM:"); }

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.3g} MB", bytes / 1e6)
                     : fmt::format("{:.3g} GB", bytes / 1e9);
}

void require_memory(double bytes, const std::string& what) {
  if (bytes < little_memory) return;
  const MemoryRoom room = memory_room();
  if (bytes <= room.bytes) return;
  const double held = memory_held();
  throw Failure(FailureKind::too_large, {},
                fmt::format("the run needs about {}: {} more than it holds now, for {}; {} "
                            "leaves {}",
                            bytes_text(held + bytes), bytes_text(bytes), what, room.from,
                            bytes_text(room.bytes)),
                what_helps);
}

} // namespace hvi::solver
