// The iterative solvers of the module libhvi_petsc against dense algebra; skipped where PETSc is
// not installed.
#include "solver/common/failure.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/iterative_factorisation.hpp"
#include "solver/linear/iterative_solver.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace hvi::solver {
namespace {

/// A grid of n x n nodes whose two components are springs to their neighbours and to each other.
SparseMatrix springs(int n, double ground, double wind = 0.0) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto at = [n](int i, int j, int c) { return 2 * (i * n + j) + c; };
  const auto spring = [&](int a, int b, double k) {
    entries.insert(entries.end(), {{a, a, k}, {b, b, k}, {a, b, -k + wind}, {b, a, -k - wind}});
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int c = 0; c < 2; ++c) {
        if (i + 1 < n) spring(at(i, j, c), at(i + 1, j, c), 1.0 + c);
        if (j + 1 < n) spring(at(i, j, c), at(i, j + 1, c), 2.0 - c);
        if (c == 0) spring(at(i, j, 0), at(i, j, 1), 0.3);
        if (i == 0) entries.emplace_back(at(i, j, c), at(i, j, c), ground);
      }
  SparseMatrix out(2 * n * n, 2 * n * n);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

UnknownsOfNodes nodes_of(int n) {
  UnknownsOfNodes out;
  out.components = 2, out.nodes = n * n;
  out.motions = DenseMatrix::Zero(2 * n * n, 2);
  for (int i = 0; i < 2 * n * n; ++i) {
    out.node.push_back(i / 2), out.component.push_back(i % 2);
    out.motions(i, i % 2) = 1.0;
  }
  return out;
}

/// Without some unknowns, and their rows and columns.
SparseMatrix leave_out(const SparseMatrix& k, const std::vector<int>& kept) {
  std::vector<int> place(static_cast<std::size_t>(k.rows()), -1);
  for (std::size_t i = 0; i < kept.size(); ++i)
    place[static_cast<std::size_t>(kept[i])] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (const int i : kept)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      if (const int j = place[static_cast<std::size_t>(it.col())]; j >= 0)
        entries.emplace_back(place[static_cast<std::size_t>(i)], j, it.value());
  SparseMatrix out(static_cast<Eigen::Index>(kept.size()), static_cast<Eigen::Index>(kept.size()));
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// Stiffnesses of the last rows of the grid, from soft to held.
SparseMatrix laws(int n, double stiffness, double coupling = 0.0) {
  SparseMatrix h(2 * n * n, 2 * n * n);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 2 * n * (n - 1); i < 2 * n * n; ++i) {
    entries.emplace_back(i, i, i % 3 == 0 ? stiffness : 0.1 * std::abs(stiffness));
    if (i % 2 == 0) entries.emplace_back(i, i + 1, coupling);
  }
  h.setFromTriplets(entries.begin(), entries.end());
  return h;
}

Vector random_vector(Eigen::Index n) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  Vector out(n);
  for (double& v : out) v = draw(random);
  return out;
}

/// With the module, or skipped.
#define OPEN(name, k, symmetric, unknowns)                                                         \
  std::unique_ptr<IterativeSolver> name;                                                           \
  try {                                                                                            \
    name = petsc_solver(k, symmetric, unknowns);                                                   \
  } catch (const Failure& failure) {                                                               \
    ASSERT_EQ(failure.kind, FailureKind::missing_file);                                            \
    GTEST_SKIP() << failure.what();                                                                \
  }

double error(const SparseMatrix& sum, const Vector& b, const Vector& x) {
  const Vector exact = DenseMatrix(sum).lu().solve(b);
  return (x - exact).lpNorm<Eigen::Infinity>() / exact.lpNorm<Eigen::Infinity>();
}

TEST(Iterative, SolvesWithLawsFromSoftToHeld) {
  const SparseMatrix k = springs(14, 10.0);
  OPEN(solver, k, true, nodes_of(14));
  const Vector b = random_vector(k.rows());
  Vector x;
  for (const double stiffness : {0.0, 1e-3, 1.0, 1e3, 1e13}) {
    const SparseMatrix h = laws(14, stiffness);
    ASSERT_TRUE(solver->set_laws(h, true));
    const IterativeAnswer answer = solver->solve(b, 1e-12, x);
    EXPECT_TRUE(answer.solved()) << answer.reason;
    EXPECT_LT(answer.iterations, 40) << stiffness;
    EXPECT_LT(error(k + h, b, x), 1e-9) << stiffness;
  }
  EXPECT_EQ(solver->statistics().setups, 1);
}

/// Cycles have matrices in single precision, whose numbers end at 1e38; several levels.
TEST(Iterative, EntriesOfAnySize) {
  for (const double size : {1.0, 1e60, 1e-60}) {
    const SparseMatrix k = springs(60, 10.0) * size;
    OPEN(solver, k, true, nodes_of(60));
    const Vector b = random_vector(k.rows());
    Vector x;
    const IterativeAnswer answer = solver->solve(b, 1e-12, x);
    EXPECT_TRUE(answer.solved()) << answer.reason;
    EXPECT_LT(answer.iterations, 30) << size;
    EXPECT_LT((k * x - b).norm(), 1e-11 * b.norm()) << size;
  }
}

TEST(Iterative, NodesWithoutAllTheirComponents) {
  const SparseMatrix whole = springs(12, 10.0);
  const UnknownsOfNodes all = nodes_of(12);
  std::vector<int> kept;
  UnknownsOfNodes some;
  some.components = 2, some.nodes = 12 * 12;
  for (int i = 0; i < whole.rows(); ++i)
    if (i % 5 != 1) {
      kept.push_back(i);
      some.node.push_back(i / 2), some.component.push_back(i % 2);
    }
  some.motions = all.motions(kept, Eigen::all);
  const SparseMatrix k = leave_out(whole, kept), h = leave_out(laws(12, 1e13), kept);
  OPEN(solver, k, true, some);
  ASSERT_TRUE(solver->set_laws(h, true));
  const Vector b = random_vector(k.rows());
  Vector x;
  EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
  EXPECT_LT(error(k + h, b, x), 1e-9);
}

TEST(Iterative, MatricesThatAreNotSymmetric) {
  const SparseMatrix k = springs(12, 10.0, 0.2), h = laws(12, 1e6, 3e5);
  OPEN(solver, k, false, nodes_of(12));
  const Vector b = random_vector(k.rows());
  Vector x;
  EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
  EXPECT_LT(error(k, b, x), 1e-9);
  ASSERT_TRUE(solver->set_laws(h, false));
  EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
  EXPECT_LT(error(k + h, b, x), 1e-9);
}

/// A law that is not symmetric on a symmetric matrix: Coulomb's.
TEST(Iterative, LawsThatAreNotSymmetric) {
  const SparseMatrix k = springs(12, 10.0), h = laws(12, 1e6, 3e5), soft = laws(12, 0.01);
  OPEN(solver, k, true, nodes_of(12));
  const Vector b = random_vector(k.rows());
  Vector x;
  ASSERT_TRUE(solver->set_laws(h, false));
  EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
  EXPECT_LT(error(k + h, b, x), 1e-9);
  ASSERT_TRUE(solver->set_laws(soft, true));
  EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
  EXPECT_LT(error(k + soft, b, x), 1e-9);
}

/// The multigrid of the first matrix serves the others, or is made anew where it is too slow.
TEST(Iterative, MatricesThatChange) {
  SparseMatrix k = springs(14, 10.0);
  OPEN(solver, k, true, nodes_of(14));
  const Vector b = random_vector(k.rows());
  Vector x;
  for (const double more : {1.0, 1.5, 40.0, 1.0}) {
    const SparseMatrix now = springs(14, 10.0 * more) * more;
    std::copy_n(now.valuePtr(), now.nonZeros(), k.valuePtr());
    solver->matrix_changed();
    EXPECT_TRUE(solver->solve(b, 1e-12, x).solved());
    EXPECT_LT(error(k, b, x), 1e-9) << more;
  }
}

TEST(Iterative, FindsThatASumIsNotPositiveDefinite) {
  const SparseMatrix k = springs(12, 10.0);
  OPEN(solver, k, true, nodes_of(12));
  const Vector b = random_vector(k.rows());
  Vector x;
  const SparseMatrix steep = laws(12, -1e3); // the layers have no factor
  EXPECT_FALSE(solver->set_laws(steep, true));
  SparseMatrix slight = laws(12, 0.0); // too soft for layers of their own
  for (int i = 0; i < slight.rows(); ++i)
    for (SparseMatrix::InnerIterator it(slight, i); it; ++it)
      it.valueRef() = it.col() == i ? -0.9 : 0.0;
  ASSERT_TRUE(solver->set_laws(slight, true));
  ASSERT_LT(symmetric_eigenvalues(DenseMatrix(k + slight))[0], 0.0);
  EXPECT_EQ(solver->solve(b, 1e-8, x).outcome, IterativeAnswer::Outcome::indefinite);
}

/// Springs of two components with pressures that make differences along the grid from node to node,
/// each `stiff` of its own, in units `unit` times those of the springs; by nodes.
struct Coupled {
  SparseMatrix k;
  UnknownsOfNodes unknowns;
};
Coupled with_pressures(int n, const std::vector<double>& stiff, double unit, double back) {
  const SparseMatrix u = springs(n, 10.0);
  const int pressures = static_cast<int>(stiff.size()), all = 2 + pressures;
  std::vector<Eigen::Triplet<double>> entries;
  const auto place = [&](int node, int c) { return node * all + c; };
  for (int i = 0; i < u.rows(); ++i)
    for (SparseMatrix::InnerIterator it(u, i); it; ++it)
      entries.emplace_back(place(i / 2, i % 2),
                           place(static_cast<int>(it.col() / 2), static_cast<int>(it.col() % 2)),
                           it.value());
  for (int p = 0; p < pressures; ++p)
    for (int i = 0; i < n * n; ++i) {
      entries.emplace_back(place(i, 2 + p), place(i, 2 + p), unit * unit * stiff[p]);
      for (const int c : {0, 1}) {
        const int next = c == 0 ? i + 1 : i + n;
        if (next >= n * n || (c == 0 && next % n == 0)) continue;
        const double pull = unit * (1.0 + 0.5 * p);
        entries.emplace_back(place(next, c), place(i, 2 + p), -pull);
        entries.emplace_back(place(i, c), place(i, 2 + p), pull);
        entries.emplace_back(place(i, 2 + p), place(next, c), back * pull);
        entries.emplace_back(place(i, 2 + p), place(i, c), -back * pull);
      }
    }
  Coupled out;
  out.k.resize(all * n * n, all * n * n);
  out.k.setFromTriplets(entries.begin(), entries.end());
  out.unknowns.components = all, out.unknowns.nodes = n * n;
  for (int p = 0; p < pressures; ++p) out.unknowns.first_component.push_back(2 + p);
  out.unknowns.motions = DenseMatrix::Zero(out.k.rows(), all);
  for (int i = 0; i < out.k.rows(); ++i) {
    out.unknowns.node.push_back(i / all), out.unknowns.component.push_back(i % all);
    out.unknowns.motions(i, i % all) = 1.0;
  }
  return out;
}

/// Each row by what it is made of.
double worst_row(const SparseMatrix& k, const Vector& b, const Vector& x) {
  double out = 0.0;
  for (int i = 0; i < k.rows(); ++i) {
    double left = b[i], size = std::abs(b[i]);
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      left -= it.value() * x[it.col()], size += std::abs(it.value() * x[it.col()]);
    out = std::max(out, size > 0.0 ? std::abs(left) / size : 0.0);
  }
  return out;
}

/// One way and both, with and without forms of their own, in any units; two pressures that make
/// the same forces but for a factor, of which the first one hardly gives way.
TEST(Iterative, SeveralUnknowns) {
  for (const std::vector<double>& stiff :
       {std::vector<double>{1.0}, {1e-6}, {1e3}, {1e-6, 1.0}, {0.1, 1e-4}})
    for (const double unit : {1.0, 1e-6, 1e6})
      for (const double back : {0.0, 1.0, 0.2}) {
        const auto [k, unknowns] = with_pressures(10, stiff, unit, back);
        OPEN(solver, k, false, unknowns);
        const Vector b = random_vector(k.rows());
        Vector x = Vector::Zero(k.rows()), more;
        int most = 0;
        for (int round = 0; round < 4; ++round) {
          const IterativeAnswer answer = solver->solve(b - k * x, 1e-9, more);
          ASSERT_TRUE(answer.solved()) << answer.reason;
          most = std::max(most, answer.iterations);
          x += more;
        }
        EXPECT_LT(worst_row(k, b, x), 1e-10) << unit << " " << back;
        EXPECT_LT(most, 150) << stiff.size() << " " << stiff[0] << " " << unit << " " << back;
      }
}

/// Each unknown's number is 1e-3 of that before it: the norm of a residual sees a few of them.
TEST(Iterative, RowsAsSmallAsRoundingOfOthers) {
  constexpr int n = 60;
  SparseMatrix k(n, n);
  UnknownsOfNodes unknowns;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1.0);
    if (i > 0) entries.insert(entries.end(), {{i, i - 1, -1e-3}, {i - 1, i, -1e-3}});
    unknowns.node.push_back(i), unknowns.component.push_back(0);
  }
  k.setFromTriplets(entries.begin(), entries.end());
  unknowns.nodes = n;
  unknowns.motions = DenseMatrix::Ones(n, 1);
  OPEN(solver, k, true, unknowns);
  const HeldRows rows(k, {});
  const auto factor = iterative_factorisation(*solver, rows);
  factor->factor(k);
  Vector x = Vector::Zero(n);
  x[0] = 1.0;
  const Vector b = x;
  factor->back(x, Columns::interior);
  EXPECT_LT(worst_row(k, b, x), 1e-9);
  EXPECT_NEAR(x[n / 2] / x[n / 2 - 1], 1e-3, 1e-8); // analytic, but for 1e-9 of it
}

/// Springs that nothing holds, under a force that no displacement balances.
TEST(Iterative, SaysThatItStagnates) {
  const SparseMatrix k = springs(10, 0.0);
  OPEN(solver, k, true, nodes_of(10));
  Vector x;
  const IterativeAnswer answer = solver->solve(Vector::Ones(k.rows()), 1e-8, x);
  EXPECT_FALSE(answer.solved());
  EXPECT_FALSE(answer.reason.empty());
}

/// By conjugate gradients and by GMRES; the next solve is one as ever.
TEST(Iterative, EndsWhereItIsAskedToStop) {
  for (const double wind : {0.0, 0.3}) {
    const SparseMatrix k = springs(16, 1e-3, wind);
    OPEN(solver, k, wind == 0.0, nodes_of(16));
    const Vector b = random_vector(k.rows());
    Vector x;
    int calls = 0;
    solver->call_between_iterations([&] {
      if (++calls == 3) throw Failure(FailureKind::interrupted, {}, "enough");
    });
    try {
      solver->solve(b, 1e-12, x);
      FAIL() << "it went on";
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.kind, FailureKind::interrupted);
    }
    EXPECT_EQ(calls, 3);
    const IterativeAnswer answer = solver->solve(b, 1e-12, x);
    EXPECT_TRUE(answer.solved()) << answer.reason;
    EXPECT_GT(answer.iterations, 3);
    EXPECT_LT(error(k, b, x), 1e-8);
    EXPECT_GE(calls, 3 + answer.iterations);
  }
}

TEST(Iterative, AModuleThatIsNotThereIsNamed) {
  ASSERT_EQ(setenv("HVI_PETSC_MODULE", "/nowhere/libhvi_petsc.so", 1), 0);
  try {
    petsc_solver(springs(2, 1.0), true, nodes_of(2));
    FAIL() << "it was opened";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::missing_file);
    EXPECT_NE(std::string(failure.what()).find("/nowhere/libhvi_petsc.so: not there"),
              std::string::npos);
    EXPECT_NE(failure.help.find("libpetsc-real-dev"), std::string::npos);
  }
  unsetenv("HVI_PETSC_MODULE");
}

} // namespace
} // namespace hvi::solver
