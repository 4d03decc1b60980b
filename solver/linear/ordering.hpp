// Fill-reducing orders with the contact unknowns last: the step between the pattern of K and its
// symbolic factorisation.
#pragma once

#include "solver/linear/elimination_order.hpp"
#include "solver/linear/elimination_tree.hpp"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

/// An order of elimination, and what a symbolic factorisation needs of it; by position.
struct ContactLastOrder {
  std::vector<Long> permutation; ///< position -> unknown; the contact unknowns last, in their order
  std::vector<Long> parent;      ///< in the elimination tree, which is postordered; -1: none
  std::vector<Long> count;       ///< nonzeros of each column of the factor
  /// Upper triangle of the matrix and of the zero entries that keep the contact last (see below),
  /// with one row for unknowns of equal neighbours: that of the first of them.
  Pattern above;
  double nonzeros = 0, flops = 0; ///< of the factor
  std::string name;               ///< the method that won
};

/// CAMD with constraints, or METIS on the interior where the work is large and METIS has fewer
/// nonzeros; then postordered. That may move contact unknowns of separate bodies between interior
/// ones, so zero entries make the tree one path at its root: each contact unknown is joined with
/// the next, and every component of the interior with the first. They cost no fill beyond the dense
/// trailing block.
ContactLastOrder order_contact_last(const SparseMatrix& k, std::span<const int> contact,
                                    CholmodSession& session);

/// The same for those who solve in it.
EliminationOrder elimination_order(const ContactLastOrder& order, std::span<const int> contact);

/// Orders of the last few patterns. A known one is used again, so that runs have the same bits.
class OrderStore {
public:
  ContactLastOrder order(const SparseMatrix& k, std::span<const int> contact,
                         CholmodSession& session);
  /// The seconds that finding the last returned order took; 0 if it was found just now.
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
