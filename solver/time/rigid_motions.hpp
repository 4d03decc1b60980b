// The rigid motions of the pieces of a mesh that keep all imposed values.
#pragma once

#include "solver/linear/dense.hpp"
#include "solver/time/run.hpp"

#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Cells that share a facet are one piece, and move as one: by translations and infinitesimal
/// rotations about its centre; axisymmetric by the translation along the axis, scalar by a
/// constant. Pieces that have a node in common (hinges) move it alike. Motions that vanish where
/// values are imposed form a linear space, of which this is a basis.
class RigidMotions {
public:
  explicit RigidMotions(const Discretisation& discretisation);

  int count() const { return static_cast<int>(basis_.cols()); }
  /// The motions on some dofs, a column each; of size about 1 on their pieces.
  DenseMatrix on(std::span<const std::int32_t> dofs) const;
  /// In words: "moves along x", "turns about (0.5, 0)", with the name of the piece where there are
  /// several.
  std::string describe(const Vector& motion) const;

private:
  struct Piece {
    Point centre{};
    double size = 0.0; ///< the largest distance of a node from there
    std::string name;  ///< "the body", "the piece `upper`"
  };
  void find_pieces(const Discretisation& d);
  void find_basis(const Discretisation& d);
  /// Column of `piece` in the row of component c at x: what its amplitudes make of that.
  Vector row(int piece, const Point& x, int c) const;
  std::string words(const Piece& piece, const Vector& amplitudes) const;
  int first(int piece) const { return piece * per_piece_; }

  const Space* space_;
  int components_, per_piece_;
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> piece_of_node_;
  DenseMatrix basis_; ///< amplitudes of all pieces x motions
};

} // namespace hvi::solver
