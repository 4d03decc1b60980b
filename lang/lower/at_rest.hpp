// The static problem at the initial time: what `from u = static` starts from.
#pragma once

#include "lang/check/model.hpp"

namespace hvi::lang {

/// The same problem where nothing moves and nothing has been: rates and memories are zero, states
/// keep their initial values, laws that see rates or memories alone are dropped. Its one step ends
/// at the initial time. Nothing is reported.
Model at_rest(Model model);

} // namespace hvi::lang
