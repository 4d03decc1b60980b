// A law's slope as the difference of two that rise: slope = rising part - fall.
//
// `fall` adds up how far the slope has fallen, down jumps included, from 0 outwards (C. Jordan's
// decomposition). Both parts are gradients of convex functions, also of laws that fall infinitely
// fast or jump down, so that the fall can be taken as it is at the last iterate and moved along.
#pragma once

#include "solver/inequality/prepared_law.hpp"

namespace hvi::solver {

class RiseAndFall {
public:
  explicit RiseAndFall(const PreparedLaw& law);

  double fall(double r) const;
  /// The point with z + gamma (slope + fall)(z) = y, `s` and `d` those of the rising part. Radial:
  /// y >= 0, state -1 at the origin.
  GraphPoint resolvent(double y, double gamma) const;

private:
  /// A part of a piece on which the slope rises (the fall is constant there) or falls (the rising
  /// part is).
  struct Stretch {
    double low, high;
    int piece;
    bool rises;
    double constant;
  };
  void cut(int piece, double low, double high);
  double slope(int piece, double r) const;
  double fall_in(const Stretch& s, double r) const;
  double rising_in(const Stretch& s, double r) const;
  void add_up_to_the_right(std::size_t first, double fall);
  void add_up_to_the_left(std::size_t past, double fall);
  double solve_in(const Stretch& s, double y, double gamma) const;

  const PreparedLaw* law_;
  std::vector<Stretch> stretches_;
};

} // namespace hvi::solver
