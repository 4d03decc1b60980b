// From a name to its other places.
#pragma once

#include "lang/editor/protocol.hpp"

#include <string>

namespace hvi::lang {

/// Where the name at a place is declared; null where it is not.
[[nodiscard]] Json definition(const EditorPlace& place);
/// Every place where the name stands, in imports, too.
[[nodiscard]] Json references(const EditorPlace& place, bool with_declaration);
/// The same in the script alone, to be underlined.
[[nodiscard]] Json highlights(const EditorPlace& place);

/// The range of a name that can be renamed; null for others: names of the library, words.
[[nodiscard]] Json renamed_range(const EditorPlace& place);
/// The edits that rename it. A name that cannot be, or is taken, is refused: `error` says why.
[[nodiscard]] Json rename(const EditorPlace& place, const std::string& name, std::string& error);

} // namespace hvi::lang
