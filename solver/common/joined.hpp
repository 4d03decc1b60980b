// Lists in sentences. fmt::join would compile fmt's own formatting of numbers into every file that
// uses it.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <ranges>
#include <string>
#include <string_view>

namespace hvi::solver {

/// Texts, or numbers with all their digits, one after the other: "a, b, c".
template <std::ranges::input_range Range>
std::string joined(const Range& values, std::string_view between = ", ") {
  std::string out;
  bool first = true;
  for (const auto& value : values) {
    if (!first) out += between;
    first = false;
    if constexpr (std::convertible_to<decltype(value), std::string_view>)
      out += std::string_view(value);
    else
      out += fmt::format("{}", value);
  }
  return out;
}

/// The first `count` numbers of a point, with so many significant digits: "0.5, 1".
template <std::ranges::random_access_range Range>
std::string joined(const Range& numbers, int count, int digits) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format("{}{:.{}g}", i > 0 ? ", " : "", numbers[i], digits);
  return out;
}

} // namespace hvi::solver
