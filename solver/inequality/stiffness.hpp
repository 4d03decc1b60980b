// The laws' stiffness at the contact unknowns, H = sum_p w_p G_p^T D_p G_p, on a fixed pattern.
#pragma once

#include "solver/inequality/points.hpp"

namespace hvi::solver {

class StiffnessPattern {
public:
  explicit StiffnessPattern(const ContactPoints& points);
  const SparseMatrix& zero() const { return zero_; }

  /// h += w_p G_p^T D G_p, for an h that began as `zero`.
  void add(int p, const SmallMatrix& d, SparseMatrix& h) const {
    for (int k = first_contribution_[p]; k < first_contribution_[p + 1]; ++k) {
      const Contribution& q = contributions_[k];
      h.valuePtr()[q.value] += q.coefficient * d[q.entry];
    }
  }
  static void clear(SparseMatrix& h); ///< h = 0; the pattern stays
  /// H from the stiffnesses D of all points.
  void assemble(const std::vector<SmallMatrix>& d, SparseMatrix& h) const;

private:
  struct Contribution {
    int value, entry; ///< h.value[value] += coefficient * D_p[entry]
    double coefficient;
  };
  SparseMatrix zero_;
  std::vector<Contribution> contributions_;
  std::vector<int> first_contribution_;
};

} // namespace hvi::solver
