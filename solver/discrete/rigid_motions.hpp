// The rigid motions of the pieces of a mesh that keep all imposed values.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/linear/dense.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// An orthonormal basis of the x with |a x| <= small |x|, near to unit vectors where that is
/// possible: motions that people have names for.
DenseMatrix kernel(const DenseMatrix& a, double small);

/// What a matrix makes of motions, a column each.
struct MotionForces {
  DenseMatrix forces, sizes; ///< K v, and what its rows sum up, |K| |v|
};
MotionForces forces_of(const SparseMatrix& k, const DenseMatrix& motions);
/// The same of whatever holds the matrix, or of its transpose.
using ForcesOfMotions = std::function<MotionForces(const DenseMatrix& motions, bool transposed)>;

/// Root of the mean square of the sizes over the columns.
double mean_size(const DenseMatrix& sizes);
/// Forces are rounding below this part of it.
inline constexpr double product_of_rounding = 2e-14;

/// Cells that share a facet are one piece, and move as one: by translations and infinitesimal
/// rotations about its centre; axisymmetric by the translation along the axis, scalar by a
/// constant. Pieces that have a node in common (hinges) move it alike. Motions that vanish where
/// values are imposed form a linear space, of which this is a basis.
class RigidMotions {
public:
  RigidMotions(const Discretisation& discretisation, int unknown);

  const Space& space() const { return *space_; }
  int unknown() const { return space_->block_of(block_.first); }
  int count() const { return static_cast<int>(basis_.cols()); }
  /// The motions on some dofs, a column each; of size about 1 on their pieces. 0 on those of other
  /// unknowns.
  DenseMatrix on(std::span<const std::int32_t> dofs) const;
  /// In words: "the body moves along x", "the piece `upper` turns about (0.5, 0)"; of several
  /// unknowns "`theta`: a constant is added to the body".
  std::string describe(const Vector& motion) const;

private:
  struct Piece {
    Point centre{};
    double size = 0.0; ///< the largest distance of a node from there
    std::string name;  ///< "the body", "the piece `upper`"
  };
  void find_pieces(const Discretisation& d, std::span<const std::int32_t> piece_of_cell);
  void find_basis(const Discretisation& d, std::span<const std::int32_t> piece_of_cell);
  /// Which component of the unknown this is; -1: a dof without one of its functions.
  int component_of(std::int32_t dof) const;
  /// Column of `piece` in the row of component c at x: what its amplitudes make of that.
  Vector row(int piece, const Point& x, int c) const;
  std::string words(const Piece& piece, const Vector& amplitudes) const;
  int first(int piece) const { return piece * per_piece_; }

  const Space* space_;
  SpaceBlock block_;
  int components_, per_piece_; ///< of the unknown; of its motions
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> piece_of_node_;
  DenseMatrix basis_; ///< amplitudes of all pieces x motions
};

/// Of each unknown that imposed values leave any.
std::vector<RigidMotions> motions_of_unknowns(const Discretisation& discretisation);

/// The forces of these motions. Of several unknowns each has units of its own: their rows, one set
/// below the other, are divided by the size of what they sum up.
DenseMatrix resistance(const MotionForces& of, const Space& space,
                       std::span<const std::int32_t> dofs);

} // namespace hvi::solver
