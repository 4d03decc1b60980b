#include "lang/check/allowed_path.hpp"

#include "lang/diag/real_path.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace hvi::lang {

std::optional<std::string> allowed_path(const std::string& path, const Span& span,
                                        const CheckOptions& options, Mistakes& mistakes) {
  namespace fs = std::filesystem;
  const fs::path folder = real_path(options.folder);
  const fs::path full = real_path(folder / path);
  const fs::path relative = full.lexically_relative(folder);
  if (fs::path(path).is_absolute() || relative.empty() || *relative.begin() == "..") {
    mistakes.error("E0604", span, fmt::format("`{}` lies outside the folder of the script", path),
                   "a script reads files beside it or below it only");
    return std::nullopt;
  }
  return full.string();
}

} // namespace hvi::lang
