// Other unknowns inside a direct solver, u = T x, against dense linear algebra.
#include "matrices.hpp"
#include "solver/linear/changed_unknowns.hpp"
#include "solver/linear/cholesky.hpp"
#include "solver/linear/general_lu.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hvi::solver::test {
namespace {

/// Pairs of unknowns are replaced by mixtures of themselves and of unknowns that stay, as where a
/// node's displacements become jumps.
struct Change {
  DenseMatrix t;
  std::shared_ptr<const BasisChange> change;

  Change(int n, const std::vector<int>& replaced, unsigned seed) : t(DenseMatrix::Identity(n, n)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-1.0, 1.0);
    for (std::size_t pair = 0; pair + 1 < replaced.size(); pair += 2) {
      const int a = replaced[pair], b = replaced[pair + 1];
      t(a, a) = t(b, b) = 0.8, t(a, b) = -0.6, t(b, a) = 0.6;
      for (int k = 0; k < 3; ++k) {
        const int other = static_cast<int>(random() % static_cast<unsigned>(n));
        if (std::ranges::find(replaced, other) != replaced.end()) continue;
        t(a, other) = value(random), t(b, other) = value(random);
      }
    }
    const DenseMatrix inverse = t.inverse();
    const auto rows = [&](const DenseMatrix& of) {
      DenseMatrix out = of(replaced, Eigen::all);
      out = out.unaryExpr([](double v) { return std::abs(v) < 1e-14 ? 0.0 : v; });
      return SparseMatrix(out.sparseView());
    };
    change = std::make_shared<const BasisChange>(replaced, rows(t), rows(inverse));
  }
};

double difference(const DenseMatrix& a, const DenseMatrix& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

TEST(BasisChange, IsThatOfDenseAlgebra) {
  const Problem problem = slab(6);
  const auto n = static_cast<int>(problem.k.rows());
  const std::vector<int> replaced(problem.contact.begin(), problem.contact.begin() + 8);
  const Change changed(n, replaced, 3);
  const DenseMatrix k(problem.k);
  EXPECT_LT(difference(DenseMatrix(changed.change->congruent(problem.k)),
                       changed.t.transpose() * k * changed.t),
            1e-14);
  EXPECT_LT(difference(DenseMatrix(changed.change->columns(problem.k)), k * changed.t), 1e-14);
  const Vector b = random_vector(n, 5);
  Vector u = b, r = b;
  changed.change->to_old(u);
  changed.change->transposed(r);
  EXPECT_LT(difference(u, changed.t * b), 1e-14);
  EXPECT_LT(difference(r, changed.t.transpose() * b), 1e-14);
}

/// Rows that the replaced unknowns were made of see one of these each, and exactly so.
TEST(BasisChange, DropsWhatCancels) {
  const int n = 12;
  const Change changed(n, {2, 3, 6, 7}, 8);
  const SparseMatrix seen = changed.change->columns(changed.change->inverse());
  EXPECT_EQ(seen.nonZeros(), 4);
  EXPECT_NEAR(seen.coeff(1, 3), 1.0, 1e-15);
}

/// K^-1, K^-T, S and its two triangular solves, for one and several right-hand sides.
void check(Factorisation& factor, const SparseMatrix& sparse, const Change& changed,
           const std::vector<int>& contact) {
  const DenseMatrix k(sparse);
  const auto n = static_cast<int>(k.rows());
  factor.factor(sparse);
  const Vector b = random_vector(n, 21);
  Vector u;
  solve(factor, b, u);
  EXPECT_LT((k * u - b).cwiseAbs().maxCoeff(), 1e-11);
  solve(factor, b, u, Columns::transposed);
  EXPECT_LT((k.transpose() * u - b).cwiseAbs().maxCoeff(), 1e-11);
  // With the contact unknowns of x given, the other rows of T^T (K u - b) hold.
  const Vector c = random_vector(static_cast<Eigen::Index>(contact.size()), 22);
  std::vector<Vector> r, found;
  DenseMatrix y;
  const std::vector<Vector> forces{b, random_vector(n, 23), Vector(2.0 * b)};
  const std::vector<Vector> values{c, Vector(-c), Vector(0.5 * c)};
  forward(factor, forces, y, r);
  back(factor, values, y, found);
  const Eigen::PartialPivLU<DenseMatrix> to_new(changed.t);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Vector x = to_new.solve(found[i]);
    EXPECT_LT((x(contact) - values[i]).cwiseAbs().maxCoeff(), 1e-12);
    Vector left = changed.t.transpose() * (forces[i] - k * found[i]);
    // S c = r is the contact rows' equation.
    EXPECT_LT((r[i] - factor.schur() * values[i] - left(contact)).cwiseAbs().maxCoeff(), 1e-10);
    left(contact).setZero();
    EXPECT_LT(left.cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(ChangedUnknowns, SolveTheEquationOfTheOldOnes) {
  const Problem problem = slab(6);
  const auto n = static_cast<int>(problem.k.rows());
  const std::vector<int> replaced(problem.contact.begin(), problem.contact.begin() + 8);
  const Change changed(n, replaced, 4);
  const SparseMatrix skew = with_skew_part(problem.k, 0.2, 6);
  const auto symmetric = with_changed_unknowns(
      analyse(changed.change->congruent(problem.k), replaced, true), changed.change);
  check(*symmetric, problem.k, changed, replaced);
  EXPECT_NE(lower_factor(*symmetric), nullptr);
  check(*symmetric->another(), 2.0 * problem.k, changed, replaced);
  check(*with_changed_unknowns(analyse(changed.change->congruent(skew), replaced, false),
                               changed.change),
        skew, changed, replaced);
  const auto general = with_changed_unknowns(
      general_factor(changed.change->congruent(skew), replaced), changed.change);
  check(*general, skew, changed, replaced);
  check(*general->another(), skew, changed, replaced);
}

} // namespace
} // namespace hvi::solver::test
