// The laws' stiffness at the contact unknowns, H = sum_p w_p G_p^T D_p G_p, on a fixed pattern.
#pragma once

#include "solver/inequality/points.hpp"

namespace hvi::solver {

class StiffnessPattern {
public:
  explicit StiffnessPattern(const ContactPoints& points);
  const SparseMatrix& zero() const { return zero_; }

  /// h += w_p G_p^T D G_p, for an h that began as `zero`; D of this point, row by row.
  void add(int p, std::span<const double> d, SparseMatrix& h) const;
  static void clear(SparseMatrix& h); ///< h = 0; the pattern stays
  /// H from the stiffnesses D of all points.
  void assemble(const PointMatrices& d, SparseMatrix& h) const;

private:
  /// What a point sees: its G_p on the unknowns that it touches, column by column in `g_`, and for
  /// each pair of these its place in h, in `places_`.
  struct Seen {
    std::size_t columns = 0, first_g = 0, first_place = 0;
  };
  std::vector<int> take(const PointData& q);

  const ContactPoints& points_;
  SparseMatrix zero_;
  std::vector<Seen> seen_;
  std::vector<double> g_;
  std::vector<int> places_;
};

} // namespace hvi::solver
