// Fill-reducing orders with the contact unknowns last: the step between the pattern of K and its
// symbolic factorisation.
#pragma once

#include "solver/linear/elimination_tree.hpp"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

struct ContactLastOrder {
  std::vector<Long> permutation; ///< position -> unknown; the contact unknowns last, in their order
  std::vector<std::pair<int, int>> links; ///< zero entries that keep them last; see below
  std::string name;                       ///< the method that won
};

/// CAMD with constraints, or METIS on the interior where the work is large and METIS has fewer
/// nonzeros. CHOLMOD postorders the elimination tree afterwards, which may
/// move contact unknowns of separate bodies between interior ones; so `links` makes the tree one
/// path at its root: each contact unknown is joined with the next, and every component of the
/// interior with the first. The links cost no fill beyond the dense trailing block.
ContactLastOrder order_contact_last(const SparseMatrix& k, std::span<const int> contact,
                                    CholmodSession& session);

/// Orders of the last few patterns. One that is known is handed out again, to the same bits.
class OrderStore {
public:
  ContactLastOrder order(const SparseMatrix& k, std::span<const int> contact,
                         CholmodSession& session);
  /// What the last order handed out had cost when it was found; 0 if it was found just now.
  double seconds_of_last() const { return seconds_of_last_; }
  int reused() const { return reused_; }
  double seconds_spared() const { return seconds_spared_; }

private:
  struct Known {
    std::vector<int> outer, inner, contact;
    ContactLastOrder order;
    double seconds;
  };
  std::vector<Known> known_;
  int reused_ = 0;
  double seconds_of_last_ = 0, seconds_spared_ = 0;
};

} // namespace hvi::solver
