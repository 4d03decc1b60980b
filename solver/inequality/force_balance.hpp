// The balance of forces at the contact unknowns, r - S c - G^T W xi, with S c kept.
#pragma once

#include "solver/inequality/points.hpp"
#include "solver/linear/pieces.hpp"

#include <functional>
#include <memory>

namespace hvi::solver {

/// S c of the displacements that were asked for last.
class KeptProduct {
public:
  explicit KeptProduct(const ReducedOperator& s);
  const ReducedOperator& op() const { return op_; }
  const Vector& value() const { return s_c_; }
  void update(const Vector& c);                  ///< S c, unless c is what it was
  void take(const Vector& c, const Vector& s_c); ///< as the caller computed it
  void belongs_to(const Vector& c);              ///< the value is S c
  void forget();                                 ///< the value belongs to no displacements
  /// The value moves by `change`; |S||c| is taken for that of the displacements before, until
  /// `belongs_to` names the new ones.
  template <class Change>
  void shift(const Change& change) {
    s_c_ += change;
  }
  /// S c itself in place of what shifts made of it; the largest entry by which that was off.
  double correct(const Vector& c);
  const Vector& magnitude(const Vector& c); ///< |S||c|

private:
  const ReducedOperator& op_;
  Vector s_c_, c_, magnitude_, exact_;
  bool have_magnitude_ = false;
};

/// What is left of each equation, the sizes of what it is made of, and their worst ratio.
struct Errors {
  Vector left, size;
  double worst = 0.0;
};
/// The largest of what is left, each row divided by its ContactPoints::row_units.
double largest_left(const Errors& of, const ContactPoints& points);

class ForceBalance {
public:
  /// `target`: the ratio that solves aim at.
  ForceBalance(const ContactPoints& points, const ReducedOperator& s, double target);
  void set_load(const Vector& r) { load_ = r; }
  const Vector& load() const { return load_; }
  double target() const { return target_; }
  /// r - S c - G^T W xi, S c as it is kept; until the next call of either.
  const Vector& residual(const Vector& xi);
  /// The same with the sizes, componentwise.
  const Errors& errors(const Vector& c, const Vector& xi);
  /// The worst ratio of this residual, from above; for iterations on all rows.
  double worst_of(const Vector& residual, const Vector& c, const Vector& xi) const;
  /// The same residual where it is more than `ratio` of its row's size; 0 in the other rows.
  /// Nothing where no row is, or one with more than `seen` among them.
  Vector beyond(double ratio, double seen, const Vector& residual, const Vector& c,
                const Vector& xi) const;
  /// c = 0 on the pieces of S on which neither loads nor multipliers act: what Newton's method left
  /// there is rounding of earlier multipliers. (Iterations do the same within each solve:
  /// PetscSolver.)
  void leave_at_rest(const Vector& xi, Vector& c);

  KeptProduct product;

private:
  bool sums_cancel() const;
  Vector sizes(const Vector& c) const;
  double turned_size(Eigen::Index i, const std::function<double(int)>& whole_size,
                     double largest_xi) const;
  double largest_multiplier(const Vector& xi) const;
  double worst_ratio(const Errors& of, const Vector& c, const Vector& xi) const;
  double worst_of_all_rows(const Errors& of, const Vector& c, const Vector& xi) const;

  const ContactPoints& points_;
  const IterativeOperator* all_rows_; ///< null: the rows are condensed
  double target_;
  Vector load_, force_;
  std::unique_ptr<const Pieces> pieces_; ///< of S, once they are asked for
  Errors errors_;                        ///< room for what is returned
};

} // namespace hvi::solver
