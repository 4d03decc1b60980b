// What an expression of a law's argument does towards an end of a piece, where it may have no
// value. Internal to solver/law.
#pragma once

#include "solver/kernel/tail.hpp"
#include "solver/law/law.hpp"

namespace hvi::solver {

/// Arguments beside `at`: above it (side 1) or below it (side -1), at a point of space and time.
struct Beside {
  double at = 0.0, side = 1.0;
  Point x{};
  LawTime t;
};

/// f(at + side / R) for large R, by the rules of growth.
Tail tail_towards(const Expr& f, const Beside& end);
/// Does f grow beyond all bounds there, by proof?
bool grows_towards(const Expr& f, const Beside& end);
/// f without those of its addends that tend to 0 there: r log(r) is 0 times infinity at 0.
Expr without_vanishing(const Expr& f, const Beside& end);
bool has_logarithm(const Expr& e);

} // namespace hvi::solver
