// The structure of a supernodal factor from an order of elimination: the step between ordering.hpp
// and the numeric factorisation.
#pragma once

#include "solver/linear/ordering.hpp"

namespace hvi::solver {

/// CHOLMOD's symbolic factor of K with the links of `order`, postordered. What cholmod_l_analyze_p
/// does, which would transpose the permuted matrix four times; here its triangles are read off the
/// rows of K. Null where memory ends. Sets lnz and fl of the session.
cholmod_factor* symbolic_factor(const SparseMatrix& k, const ContactLastOrder& order,
                                CholmodSession& session);

} // namespace hvi::solver
