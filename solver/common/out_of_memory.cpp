// See out_of_memory.hpp: fmt is called here alone, so that no other file makes its templates.
#include "solver/common/out_of_memory.hpp"

#include <fmt/format.h>

namespace hvi::solver {

OutOfMemory::OutOfMemory(fmt::string_view format, fmt::format_args arguments) {
  fmt::vformat_to_n(text_.data(), text_.size() - 1, format, arguments);
}

} // namespace hvi::solver
