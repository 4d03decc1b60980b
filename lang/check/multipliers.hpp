// Multipliers of laws, by the part on which they are asked for: `layer.xi` is read as that of the
// first application of the law.
#pragma once

#include "lang/check/context.hpp"

#include <string>

namespace hvi::lang {

class Multipliers {
public:
  explicit Multipliers(const Context& context)
      : mistakes_(context.mistakes), model_(context.model) {}

  /// `layer.xi` meant the first application of the law; here it is the one on this part.
  bool take_on_part(const Span& span, int part, Symbol& expression);
  /// The multiplier of a law on this very part: `layer.xi` meant the first one found by name.
  void name_on_part(int part, Symbol& expression) const;

private:
  Mistakes& mistakes_;
  const Model& model_;
};

} // namespace hvi::lang
