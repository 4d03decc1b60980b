// See unreadable.hpp.
#include "lang/diag/unreadable.hpp"

#include "lang/diag/suggest.hpp"
#include "solver/common/read_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
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

/// A folder below `at` as it was typed, or with the names that are there for those that are not.
std::optional<fs::path> folder_meant(const fs::path& at, const fs::path& typed) {
  fs::path out;
  std::error_code problem;
  for (const fs::path& part : typed) {
    if (fs::is_directory(at / out / part, problem)) {
      out /= part;
      continue;
    }
    std::vector<std::string> known;
    for (const fs::path& entry : entries_of(at / out))
      if (fs::is_directory(entry, problem)) known.push_back(entry.filename().string());
    const auto near = suggest(part.string(), known);
    if (!near) return std::nullopt;
    out /= *near;
  }
  return out;
}

/// The name of a file in `folder` that is most like the one typed: one of its ending first, then
/// another script, then any.
std::optional<std::string> file_meant(const fs::path& folder, const fs::path& typed) {
  std::error_code problem;
  std::vector<std::string> of_ending, scripts, files;
  for (const fs::path& entry : entries_of(folder)) {
    if (!fs::is_regular_file(entry, problem)) continue;
    files.push_back(entry.filename().string());
    if (entry.extension() == typed.extension()) of_ending.push_back(files.back());
    if (entry.extension() == ".hvi") scripts.push_back(files.back());
  }
  if (std::ranges::find(files, typed.string()) != files.end()) return typed.string();
  const auto of_stem = [&](const std::string& file) { // `laws` for `laws.hvi`
    return typed.extension().empty() && fs::path(file).stem() == typed;
  };
  for (const auto* some : {&scripts, &files})
    if (const auto found = std::ranges::find_if(*some, of_stem); found != some->end())
      return *found;
  if (typed.extension().empty())
    if (auto near = suggest(typed.string() + ".hvi", scripts)) return near;
  for (const auto* some : {&of_ending, &scripts, &files})
    if (auto near = suggest(typed.string(), *some)) return near;
  return std::nullopt;
}

} // namespace

std::string meant_file(const std::string& folder, const std::string& name) {
  const fs::path at = fs::path(folder.empty() ? "." : folder);
  std::error_code problem;
  if (fs::exists(at / name, problem)) return {};
  const fs::path last = fs::path(name).filename();
  const auto meant = [](const fs::path& path) {
    return fmt::format("did you mean `{}`?", path.string());
  };
  const auto own = folder_meant(at, fs::path(name).parent_path());
  if (own && fs::is_regular_file(at / *own / last, problem)) return meant(*own / last);
  for (const fs::path& below : entries_of(at))
    if (fs::is_directory(below, problem) && fs::is_regular_file(below / last, problem))
      return meant(below.filename() / last);
  const auto file = own ? file_meant(at / *own, last) : std::nullopt;
  return file ? meant(*own / *file) : std::string();
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
