// Whole scripts for an editor: outline, colours, layout.
#pragma once

#include "lang/editor/protocol.hpp"

#include <string_view>
#include <vector>

namespace hvi::lang {

/// One symbol for each statement.
[[nodiscard]] Json outline(const EditorPlace& place);

/// Names of the kinds of tokens, in the order of their numbers.
[[nodiscard]] std::vector<std::string_view> colour_names();
/// Five numbers for each token: lines and characters from the one before, length, kind, 0.
[[nodiscard]] Json colours(const EditorPlace& place);

/// The edit that formats the script; empty where it has syntax errors or needs none.
[[nodiscard]] Json formatted(const EditorPlace& place);

} // namespace hvi::lang
