// The modules of the standard library, embedded at build from stdlib/*.hvi.
#pragma once

#include <span>
#include <string_view>

namespace hvi::lang {

struct Module {
  std::string_view name; ///< "friction"
  std::string_view text;
};
std::span<const Module> standard_library();

} // namespace hvi::lang
