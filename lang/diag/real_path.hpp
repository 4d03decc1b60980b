// Where a path leads.
#pragma once

#include <filesystem>
#include <new>
#include <system_error>

namespace hvi::lang {

/// The path without links, `.` and `..`, as far as it exists; empty where the system does not say.
/// That there is no memory to say it in is not such an answer: it throws bad_alloc.
[[nodiscard]] inline std::filesystem::path real_path(const std::filesystem::path& path) {
  std::error_code error;
  auto out = std::filesystem::weakly_canonical(path, error);
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
  return error ? std::filesystem::path() : out;
}

} // namespace hvi::lang
