// See unreadable.hpp.
#include "lang/diag/unreadable.hpp"

#include "lang/diag/suggest.hpp"
#include "solver/common/read_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

/// Paths of what is in a folder, of a large one of a part; none where it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  constexpr std::size_t most = 2000;
  std::vector<fs::path> out;
  std::error_code problem;
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end;) {
    out.push_back(entry->path());
    entry.increment(problem);
    if (out.size() == most) break;
  }
  std::ranges::sort(out); // the order of the disk is any
  return out;
}

} // namespace

std::string meant_file(const std::string& folder, const std::string& name) {
  const fs::path at = fs::path(folder.empty() ? "." : folder);
  std::error_code problem;
  if (fs::exists(at / name, problem)) return {};
  const fs::path own = fs::path(name).parent_path(), last = fs::path(name).filename();
  for (const fs::path& below : entries_of(at))
    if (fs::is_directory(below, problem) && fs::is_regular_file(below / last, problem))
      return fmt::format("did you mean `{}`?", (below.filename() / last).string());
  std::vector<std::string> beside;
  for (const fs::path& file : entries_of(at / own))
    if (fs::is_regular_file(file, problem)) beside.push_back((own / file.filename()).string());
  for (const std::string& file : beside) // `laws` for `laws.hvi`
    if (last.extension().empty() && fs::path(file).stem() == last)
      return fmt::format("did you mean `{}`?", file);
  return did_you_mean(name, beside);
}

std::string why_unreadable(const std::string& path, const std::string& name) {
  std::error_code problem;
  const auto status = std::filesystem::status(path, problem);
  if (status.type() == std::filesystem::file_type::not_found)
    return fmt::format("there is no file `{}`", name);
  if (std::filesystem::is_directory(status)) return fmt::format("`{}` is a folder", name);
  if (!problem && !std::filesystem::is_regular_file(status))
    return fmt::format("`{}` is a device or a pipe, not a file", name);
  const std::string reason = problem                    ? problem.message()
                             : !solver::read_file(path) ? std::strerror(errno)
                                                        : "the system refused it for a moment";
  return fmt::format("`{}` cannot be read: {}", name, reason);
}

std::string said_of_file(const std::string& name, const std::string& what) {
  const std::string last = std::filesystem::path(name).filename().string();
  return what.find(last) == std::string::npos ? fmt::format("`{}`: {}", name, what) : what;
}

} // namespace hvi::lang
