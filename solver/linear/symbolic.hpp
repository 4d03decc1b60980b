// The structure of a supernodal factor from an order of elimination: the step between ordering.hpp
// and the numeric factorisation.
#pragma once

#include "solver/linear/ordering.hpp"

namespace hvi::solver {

/// CHOLMOD's symbolic factor in an order. What cholmod_l_analyze_p does, which would transpose the
/// permuted matrix four times. Null where memory ends. Uses up what `order` holds besides its
/// permutation.
cholmod_factor* symbolic_factor(ContactLastOrder& order, CholmodSession& session);

} // namespace hvi::solver
