// Values of declarations: found when they are first used, each at most once; a circle is an error.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/limits.hpp"
#include "lang/check/material_places.hpp"
#include "lang/check/meshes.hpp"
#include "lang/check/parameters.hpp"
#include "lang/check/parts.hpp"
#include "lang/check/spaces.hpp"
#include "lang/check/states.hpp"
#include "lang/check/tensors.hpp"

#include <utility>

namespace hvi::lang {

class DeclaredValues {
public:
  DeclaredValues(const Context& context, Limits& limits, Meshes& meshes, Parts& parts,
                 MaterialPlaces& places, Tensors& tensors, States& states, Parameters& parameters,
                 Spaces& spaces)
      : mistakes_(context.mistakes), names_(context.names), evaluator_(context.evaluator),
        at_hand_(context.at_hand), limits_(limits), meshes_(meshes), parts_(parts), places_(places),
        tensors_(tensors), states_(states), parameters_(parameters), spaces_(spaces) {}

  Value& value_of(int declaration, const Span& use);

private:
  Value evaluate(int declaration);

  Mistakes& mistakes_;
  Names& names_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Limits& limits_;
  Meshes& meshes_;
  Parts& parts_;
  MaterialPlaces& places_;
  Tensors& tensors_;
  States& states_;
  Parameters& parameters_;
  Spaces& spaces_;
};

} // namespace hvi::lang
