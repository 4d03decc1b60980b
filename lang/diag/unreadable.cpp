// See unreadable.hpp.
#include "lang/diag/unreadable.hpp"

#include "solver/common/read_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace hvi::lang {

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
