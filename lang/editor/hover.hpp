// What an editor shows of the name under the pointer, and of the arguments of the call that is
// being written.
#pragma once

#include "lang/editor/protocol.hpp"

namespace hvi::lang {

/// Type, shape, value, the line of the declaration and what its comment says; of what is built in
/// its usage; of a word that begins a statement what it states. Null where there is nothing.
[[nodiscard]] Json hover(const EditorPlace& place);

/// The arguments of the call around the place, and the one the place is in; null outside of calls.
[[nodiscard]] Json signature(const EditorPlace& place);

/// "superpotential slip(xi, mu = 1)": how a declared name is written where it is used.
[[nodiscard]] std::string heading_of(const Analysis& analysis, const Definition& definition);
/// Heading, what it is, and comment, as Markdown.
[[nodiscard]] std::string describe(const Analysis& analysis, const Definition& definition);

} // namespace hvi::lang
