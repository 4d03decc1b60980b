// The last factor, corrected where few points moved far from it: a preconditioner for S + H.
//
// The last factor M = S + H_old preconditions S + H. Most points keep their stiffness about; those
// that moved far (stick to slip and back, contact that opens) are few and have their unknowns to
// themselves. With X their unknowns, the preconditioner is the matrix P that equals S + H on X and
// M elsewhere, solved exactly:
//
//   R: unknowns that M holds by a penalty and that are free now. M^-1 gives 0 there, so that with
//      Y = M^-1 S E_R and C = (S + H)_RR - S_RF Y   (F: all but R)
//          x_R = C^-1 (b_R - Y^T b),   x_F = M^-1 b - Y x_R.
//   Q: the others, by Woodbury with Delta = (H - H_old)_QQ and Z = M^-1 E_Q:
//          force = (1 + Delta G)^-1 Delta x_Q,   G = Z_QQ + Y_Q C^-1 Y_Q^T,   b := b - E_Q force.
//
// The columns Y and Z are kept as long as the factor.
#pragma once

#include "solver/inequality/last_factor.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <unordered_map>

namespace hvi::solver {

/// Points whose stiffness moved far from the factored one.
struct FarPoints {
  /// An entry of Delta on the changed unknowns.
  struct Change {
    int row, column;
    double value;
    bool held; ///< the diagonal entry of a row that is held now
  };
  std::vector<int> freed, changed; ///< R and Q
  std::vector<Change> delta;
  std::vector<char> is_far; ///< by point
  std::size_t unknowns() const { return freed.size() + changed.size(); }
};

/// False when one of them shares its unknowns, or when they have more than `most` of them.
bool find_far_points(const ContactPoints& points, const std::vector<SmallMatrix>& d,
                     const std::vector<SmallMatrix>& d_factored, std::size_t most, FarPoints& out);

class Preconditioner {
public:
  Preconditioner(const ContactPoints& points, LastFactor& factor);
  /// Forgets what belongs to another factor than the last.
  void keep_up();
  /// For S + h. False: P has no factor.
  bool prepare(const FarPoints& far, const SparseMatrix& h);
  void apply(const Vector& r, Vector& out); ///< out = P^-1 r

  /// By unknown: M^-1 S e_i of freed ones, M^-1 e_i of changed ones.
  using Columns = std::unordered_map<int, Vector>;
  const Columns& columns() const; ///< known of the last factor
  int served() const;             ///< times that it was applied
  /// As a saved solver had them, for the factor that there is now.
  void restore(Columns columns, int served);

private:
  struct Freed {
    std::vector<int> unknowns;      ///< of y and block
    DenseMatrix y, block;           ///< Y with its rows R set to 0, S_RR - S_RF Y over `unit`
    Eigen::LLT<DenseMatrix> factor; ///< of C over `unit`
  };
  struct Changed {
    DenseMatrix z, y_rows; ///< Z, Y_Q
    Eigen::PartialPivLU<DenseMatrix> factor;
  };
  void solve_columns();
  void prepare_freed();
  void prepare_changed();
  Vector force_on_changed(Vector& t, const Vector& x) const;
  Vector move_freed(const Vector& t) const;

  const ContactPoints& points_;
  LastFactor& factor_;
  int number_ = 0, served_ = 0; ///< of the factor: which one, and how often it was applied
  Columns columns_;
  FarPoints far_;
  Vector kept_;       ///< room for `apply`
  double unit_ = 1.0; ///< the body's own stiffness: over it no unit system overflows
  Freed freed_;
  Changed changed_;
};

} // namespace hvi::solver
