// See iterative_factorisation.hpp.
#include "solver/linear/iterative_factorisation.hpp"

#include <fmt/format.h>

#include <limits>
#include <numeric>
#include <stdexcept>

namespace hvi::solver {
namespace {

/// Solutions are corrected until their certificate holds: a correction gains so much.
constexpr double gain_of_solve = 1e-9;
/// And each row of it, in so many rounds at most.
constexpr double gain_of_row = 1e-10;
constexpr int most_rounds = 40;

class IterativeFactorisation final : public Factorisation {
public:
  IterativeFactorisation(IterativeSolver& solver, const MatrixRows& k) : solver_(solver), k_(k) {
    order_.unknown.resize(static_cast<std::size_t>(k.size()));
    std::iota(order_.unknown.begin(), order_.unknown.end(), 0);
    order_.interior = k.size();
  }

  std::unique_ptr<Factorisation> another() const override {
    throw std::logic_error("an iterative solver serves one matrix");
  }

  void factor(const SparseMatrix&) override { solve_by_norm(k_.diagonal(), x_); }

  void forward(RightHandSides, Columns) override {}

  void back(RightHandSides y, Columns columns) override {
    if (columns == Columns::transposed)
      throw std::logic_error("an iterative solver has no transposed solves");
    const int n = order_.size();
    for (int r = 0; r < y.count; ++r) {
      Vector b(n);
      for (int i = 0; i < n; ++i) b[i] = y.values[static_cast<std::ptrdiff_t>(i) * y.stride + r];
      const Vector& x = solve(b);
      for (int i = 0; i < n; ++i) y.values[static_cast<std::ptrdiff_t>(i) * y.stride + r] = x[i];
    }
  }

  const DenseMatrix& schur() const override { return none_; }
  const EliminationOrder& order() const override { return order_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  /// The norm of a residual does not see rows that are as small as rounding of others, which have
  /// an accuracy of their own: they are solved for once more, without the others.
  const Vector& solve(const Vector& b) {
    solve_by_norm(b, x_);
    Vector left = b, more;
    for (int round = 1; round < most_rounds; ++round) {
      if (!rows_that_do_not_hold(b, left)) break;
      solve_by_norm(left, more);
      x_ += more;
    }
    return x_;
  }

  void solve_by_norm(const Vector& b, Vector& x) {
    const IterativeAnswer answer = solver_.solve(b, gain_of_solve, x);
    if (answer.outcome == IterativeAnswer::Outcome::indefinite)
      throw NotFactorable(-1, std::numeric_limits<double>::quiet_NaN(),
                          "the matrix is not positive definite");
    if (!answer.solved())
      throw Failure(FailureKind::not_certified, {},
                    fmt::format("the iterative solver of {} unknowns stopped after {} iterations, "
                                "which left {:.1e} of the forces: {}",
                                b.size(), answer.iterations, answer.reduction, answer.reason),
                    "take `using solver = direct`");
  }

  /// left = b - K x in rows where it is more than `gain_of_row` of what they are made of, 0 in the
  /// others. Are there any?
  bool rows_that_do_not_hold(const Vector& b, Vector& left) const {
    Vector product, sizes;
    k_.apply(x_, product);
    k_.apply_magnitude(x_, sizes);
    left = b - product;
    for (Eigen::Index i = 0; i < b.size(); ++i)
      if (std::abs(left[i]) <= gain_of_row * (std::abs(b[i]) + sizes[i])) left[i] = 0.0;
    return !left.isZero(0.0);
  }

  IterativeSolver& solver_;
  const MatrixRows& k_;
  EliminationOrder order_;
  FactorStatistics statistics_;
  DenseMatrix none_;
  Vector x_;
};

} // namespace

std::unique_ptr<Factorisation> iterative_factorisation(IterativeSolver& solver,
                                                       const MatrixRows& k) {
  return std::make_unique<IterativeFactorisation>(solver, k);
}

} // namespace hvi::solver
