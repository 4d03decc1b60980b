// See iterative_operator.hpp.
#include "solver/inequality/iterative_operator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace hvi::solver {

/// A product each: who asks for many prepares for dense factors, of which there are none.
void IterativeOperator::column(int j, double* out) const {
  Vector of;
  k_.apply(Vector::Unit(size(), j), of);
  std::copy(of.begin(), of.end(), out);
}

/// Others may use the solver with laws of their own meanwhile.
bool IterativeOperator::use_laws() const {
  return solver_.laws() == &h_ || solver_.set_laws(h_, symmetric_);
}

bool IterativeOperator::factor(const SparseMatrix& h, std::span<const int>) {
  h_ = h;
  h_.makeCompressed();
  return solver_.set_laws(h_, symmetric_);
}

IterativeAnswer IterativeOperator::answer_to(const Vector& b, double reduction, Vector& x) const {
  if (use_laws()) return solver_.solve(b, reduction, x);
  IterativeAnswer none;
  none.outcome = IterativeAnswer::Outcome::indefinite;
  return none;
}

bool IterativeOperator::solve_to(const Vector& b, double reduction, Vector& x,
                                 double enough) const {
  const IterativeAnswer answer = answer_to(b, reduction, x);
  const bool stagnated = answer.outcome == IterativeAnswer::Outcome::stagnated;
  if (stagnated && answer.reduction <= enough) return true;
  if (stagnated)
    throw Failure(FailureKind::not_certified, {},
                  fmt::format("the iterative solver of {} unknowns stopped after {} iterations, "
                              "which left {:.1e} of the forces: {}",
                              size(), answer.iterations, answer.reduction, answer.reason),
                  "take `using solver = direct`; Poisson's ratios near 1/2, flat cells and "
                  "stiffnesses many decades apart are hard for iterations");
  return answer.solved();
}

/// What is not positive definite has no answer.
void IterativeOperator::solve_or_refuse(const Vector& b, double reduction, Vector& x,
                                        double enough) const {
  if (!solve_to(b, reduction, x, enough))
    x.setConstant(size(), std::numeric_limits<double>::quiet_NaN());
}

void IterativeOperator::solve_for_direction(const Vector& b, Vector& x) const {
  constexpr double wanted = 1e-8, enough = 1e-2;
  solve_or_refuse(b, wanted, x, enough);
}

/// Conjugate gradients from a random force come across directions of negative energy, which are at
/// the end of the spectrum; laws that add stiffness only leave nothing to ask. Where the sum is not
/// symmetric neither iterations nor a factor can tell.
bool IterativeOperator::definite() {
  if (!symmetric_) return true;
  bool adds_only = true;
  for (int i = 0; i < h_.rows() && adds_only; ++i)
    for (SparseMatrix::InnerIterator it(h_, i); it; ++it)
      adds_only = adds_only && (it.col() != i || it.value() >= 0.0);
  if (adds_only) return true;
  Vector b(size()), x;
  std::uint32_t random = 12345;
  for (double& v : b) {
    random = random * 1664525u + 1013904223u;
    v = random / 4294967296.0 - 0.5;
  }
  return solve_to(b, 1e-8, x);
}

} // namespace hvi::solver
