// Mistakes that an editor can mend.
#pragma once

#include "lang/editor/protocol.hpp"

#include <functional>

namespace hvi::lang {

/// What makes a try: the text of the script after an edit, compiled.
using Compile = std::function<std::unique_ptr<Analysis>(std::string text)>;

/// Edits for the diagnostics that lie in a range: what the help proposes in backticks, at the place
/// it is about. Each was tried: with it the diagnostic is gone and no other one has come.
[[nodiscard]] Json actions(const EditorPlace& place, const Span& range, const Compile& compile);

} // namespace hvi::lang
