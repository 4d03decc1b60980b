// Text for people. What cannot be written is no reason to stop: the end of the program looks
// whether the standard output took all of it (main.cpp).
#pragma once

#include <fmt/format.h>

#include <cstdio>

namespace hvi::lang {

/// On the standard output: results.
template <class... Arguments>
void say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  const auto text = fmt::format(format, std::forward<Arguments>(arguments)...);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

/// On stderr: messages and progress.
template <class... Arguments>
void tell(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  const auto text = fmt::format(format, std::forward<Arguments>(arguments)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

} // namespace hvi::lang
