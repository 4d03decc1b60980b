// What the help of a message says to write, as edits of the script: candidates, of which those are
// offered that mend it (actions.hpp).
#pragma once

#include "lang/editor/analysis.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

struct Change {
  Span span; ///< what is replaced
  std::string text;
};

struct Edit {
  std::vector<Change> changes; ///< in the order of their places, none over another
  std::string title;
  bool one_of_several = false; ///< those behind it may be offered beside it
};

/// The better ones first.
[[nodiscard]] std::vector<Edit> edits_for(const Analysis& analysis, const Diagnostic& diagnostic);

/// Where the help shows a shape, `dot(a, b)`, and a, b are what stands at the place.
[[nodiscard]] std::vector<Edit> edits_by_shape(const Analysis& analysis,
                                               const Diagnostic& diagnostic);

} // namespace hvi::lang
