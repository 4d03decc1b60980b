// A function of one number that costs microseconds, as piecewise polynomials to rounding: a direct
// sum asks a Mittag-Leffler function millions of times.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace hvi::solver {

/// Octaves 2^k <= |x| < 2^(k+1), each cut into 1, 2, 4, .. equal pieces until Chebyshev
/// polynomials agree with the function between their nodes, relative to its value there. A piece
/// without such a polynomial (a zero, a kink) calls the function. The value at x depends on x only,
/// not on what was asked before. For functions without features narrower than a piece.
class FunctionTable {
public:
  explicit FunctionTable(std::function<double(double)> function);
  double operator()(double x);
  /// Pieces so far, and those of them that call the function.
  std::size_t pieces() const { return pieces_; }
  std::size_t unresolved() const { return unresolved_; }

private:
  static constexpr int count = 24; ///< coefficients of a piece
  struct Piece {
    double middle = 0, half = 0;
    bool resolved = false;
    std::array<double, count> coefficients{};
    double value(double x) const;
  };
  struct Octave {
    double low = 0, per_length = 0; ///< piece of x: (x - low) * per_length
    std::vector<Piece> pieces;
  };
  const Octave& octave(double x);
  Octave cut(double from, double to, std::size_t pieces) const;
  Piece piece(double from, double to) const;

  static constexpr int exponents = 64; ///< 2^-32 <= |x| < 2^32 is tabulated
  std::function<double(double)> function_;
  std::array<std::array<Octave, exponents>, 2> octaves_; ///< positive, negative; empty: not asked
  std::size_t pieces_ = 0, unresolved_ = 0;
};

} // namespace hvi::solver
