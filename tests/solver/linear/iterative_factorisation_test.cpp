#include "solver/common/failure.hpp"
#include "solver/linear/iterative_factorisation.hpp"

#include <gtest/gtest.h>

namespace hvi::solver::test {
namespace {

/// Divides by the diagonal 1, 2, .., n, and says of every solve what it is told to.
class Diagonal final : public IterativeSolver {
public:
  explicit Diagonal(IterativeAnswer::Outcome outcome = IterativeAnswer::Outcome::solved)
      : outcome_(outcome) {}
  void matrix_changed() override {}
  void set_free_motions(const DenseMatrix&) override {}
  bool set_laws(const SparseMatrix&, bool) override { return true; }
  const SparseMatrix* laws() const override { return nullptr; }
  void call_between_iterations(std::function<void()>) override {}
  IterativeAnswer solve(const Vector& b, double, Vector& x) override {
    x = b;
    for (Eigen::Index i = 0; i < b.size(); ++i) x[i] /= static_cast<double>(i + 1);
    IterativeAnswer answer;
    answer.outcome = outcome_;
    return answer;
  }
  const IterativeStatistics& statistics() const override { return statistics_; }

private:
  IterativeAnswer::Outcome outcome_;
  IterativeStatistics statistics_;
};

/// 1, 2, .., n on the diagonal.
SparseMatrix counting(int n) {
  SparseMatrix out(n, n);
  for (int i = 0; i < n; ++i) out.insert(i, i) = i + 1;
  out.makeCompressed();
  return out;
}

TEST(IterativeFactorisation, SolvesSeveralRightHandSidesSideBySide) {
  Diagonal solver;
  constexpr int n = 3, count = 2;
  const SparseMatrix matrix = counting(n);
  const HeldRows k(matrix, {});
  const auto factorisation = iterative_factorisation(solver, k);
  DenseMatrix rows(RightHandSides::stride_of(count), n); // a column for each unknown
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows.data()[i] = static_cast<double>(i + 1);
  DenseMatrix expected = rows;
  for (int i = 0; i < n; ++i) expected.col(i).head(count) /= i + 1;
  factorisation->back(RightHandSides(rows, count), Columns::interior);
  EXPECT_TRUE(rows.isApprox(expected, 1e-15)) << rows;
}

TEST(IterativeFactorisation, KeepsTheOrderOfTheUnknowns) {
  Diagonal solver;
  const SparseMatrix matrix = counting(4);
  const HeldRows k(matrix, {});
  const auto factorisation = iterative_factorisation(solver, k);
  EXPECT_EQ(factorisation->order().interior, 4);
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(factorisation->order().unknown[static_cast<std::size_t>(i)], i);
}

TEST(IterativeFactorisation, SaysWhyItDoesNotSolve) {
  const SparseMatrix matrix = counting(2);
  const HeldRows k(matrix, {});
  Diagonal indefinite(IterativeAnswer::Outcome::indefinite);
  EXPECT_THROW(iterative_factorisation(indefinite, k)->factor(matrix), NotFactorable);
  Diagonal stagnated(IterativeAnswer::Outcome::stagnated);
  EXPECT_THROW(iterative_factorisation(stagnated, k)->factor(matrix), Failure);
  Diagonal solver;
  EXPECT_NO_THROW(iterative_factorisation(solver, k)->factor(matrix));
}

} // namespace
} // namespace hvi::solver::test
