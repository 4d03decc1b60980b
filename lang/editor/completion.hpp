// What may be written at a place of a script.
#pragma once

#include "lang/editor/protocol.hpp"

namespace hvi::lang {

/// A list of items that fit there: members behind a dot (sides and groups of a mesh, parts of the
/// unknown, the multiplier of a law), arguments within a call, spaces behind `in`, parts behind
/// `on`, modules behind `import`, files within quotes, settings behind `using`, statements at the
/// beginning of a line; elsewhere every name that is visible.
[[nodiscard]] Json completion(const EditorPlace& place);

} // namespace hvi::lang
