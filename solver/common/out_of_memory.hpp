// Memory that a library asked for and did not get.
#pragma once

#include <fmt/core.h>

#include <array>
#include <new>

namespace hvi::solver {

/// A bad_alloc and not a Failure, so that code which handles failures does not continue without the
/// result. Its message is made without an allocation.
class OutOfMemory : public std::bad_alloc {
public:
  template <class... Arguments>
  explicit OutOfMemory(fmt::format_string<Arguments...> format, const Arguments&... arguments)
      : OutOfMemory(format, fmt::format_args(fmt::make_format_args(arguments...))) {}
  const char* what() const noexcept override { return text_.data(); }

private:
  OutOfMemory(fmt::string_view format, fmt::format_args arguments);

  std::array<char, 128> text_{};
};

} // namespace hvi::solver
