// Multipliers of laws, by the part on which they are asked for.
#pragma once

#include "lang/check/context.hpp"

#include <string>

namespace hvi::lang {

class Multipliers {
public:
  explicit Multipliers(const Context& context)
      : mistakes_(context.mistakes), model_(context.model) {}

  /// False (reported) where the expression reads that of a law which does not act on this part.
  /// `layer.xi` in a function's body meant the first application of the law; here it is that on the
  /// part.
  bool take_on_part(const Span& span, int part, Symbol& expression);

private:
  Mistakes& mistakes_;
  const Model& model_;
};

} // namespace hvi::lang
