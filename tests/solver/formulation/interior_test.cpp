// A body that is known from its contact unknowns, against dense algebra straight from the formulas
// of interior.hpp.
#include "solver/discrete/rounding.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/formulation/field_recovery.hpp"
#include "solver/formulation/interior_equilibrium.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace hvi::solver {
namespace {

constexpr int n = 23;

struct Body : testing::Test {
  std::mt19937_64 random{1801};
  std::vector<int> contact = {0, 3, 4, 11, 22};
  DenseMatrix t = DenseMatrix::Zero(n, n);
  std::vector<Vector> forces;
  std::unique_ptr<Interior> interior;
  DenseMatrix reaction_of; ///< G^T W
  std::unique_ptr<FieldRecovery> fields;
  std::unique_ptr<InteriorEquilibrium> equilibrium;

  Vector any(int size) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    return Vector::NullaryExpr(size, [&] { return unit(random); });
  }
  void SetUp() override {
    for (int i = 0; i < n; ++i) // a chain with springs across, positive definite
      for (const int j : {i + 1, (i * 7 + 3) % n})
        if (j < n && j != i) {
          const double k = 1.5 + any(1)[0];
          t(i, i) += k, t(j, j) += k, t(i, j) -= k, t(j, i) -= k;
        }
    t.diagonal().array() += 0.1;
    StateLayout layout{n, n, n, std::vector<std::int32_t>(n), std::vector<std::int32_t>(n), {}};
    std::iota(layout.dof_of.begin(), layout.dof_of.end(), 0);
    layout.entry_of = layout.dof_of;
    SparseMatrix sparse = t.sparseView();
    auto factor = take_factor(nullptr, sparse, contact, true);
    interior = std::make_unique<Interior>(sparse, std::move(factor), layout, contact);
    for (int k = 0; k < 3; ++k) {
      forces.push_back(any(n));
      add_mode(*interior, forces.back());
    }
    SparseMatrix force(n, 2); // the laws act on the first and the last contact unknown
    force.insert(contact.front(), 0) = 0.7;
    force.insert(contact.back(), 1) = -0.4;
    reaction_of = DenseMatrix(force);
    fields = std::make_unique<FieldRecovery>(*interior);
    equilibrium = std::make_unique<InteriorEquilibrium>(*interior, std::move(force));
  }
  /// Contact values as y has them, the others from T_II u_I = sum_k phi_k F_k,I - T_Ic c.
  Vector whole(const Vector& y) const {
    DenseMatrix k = t;
    Vector right = load(y);
    for (std::size_t c = 0; c < contact.size(); ++c) {
      k.row(contact[c]).setZero();
      k(contact[c], contact[c]) = 1.0;
      right[contact[c]] = y[static_cast<int>(c)];
    }
    return k.fullPivLu().solve(right);
  }
  Vector load(const Vector& y) const {
    Vector f = Vector::Zero(n);
    for (std::size_t k = 0; k < forces.size(); ++k)
      f += y[static_cast<int>(contact.size() + k)] * forces[k];
    return f;
  }
};

TEST_F(Body, IsWhatTheContactUnknownsAndTheModesSay) {
  const Vector y = any(interior->size());
  Vector full = Vector::Zero(n);
  fields->scatter(y, full);
  EXPECT_LT((full - whole(y)).norm(), 1e-12 * full.norm());
}

TEST_F(Body, EveryUnknownCanBeObserved) {
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  fields->observe(all);
  const Vector y = any(interior->size());
  Vector seen = Vector::Zero(n);
  fields->scatter_observed(y, seen);
  EXPECT_LT((seen - whole(y)).norm(), 1e-12 * seen.norm());
}

/// A body whose first unknown is inside.
TEST_F(Body, TheFirstUnknownCanBeObservedInside) {
  contact = {1, 3, 4, 11, 22};
  forces.clear();
  t.setZero();
  SetUp();
  const int first = 0;
  fields->observe({&first, 1});
  const Vector y = any(interior->size());
  Vector seen = Vector::Zero(n);
  fields->scatter_observed(y, seen);
  EXPECT_NEAR(seen[0], whole(y)[0], 1e-12);
}

TEST_F(Body, TheGrowthOfRoundingIsThatOfItsMatrix) {
  const SparseMatrix sparse = t.sparseView();
  const RowUnits unit(own_stiffness(sparse), {});
  const std::vector<Vector> right{growth_probe(sparse, unit), forces[0]};
  const Vector &b = right[0], answer = t.fullPivLu().solve(b);
  const double growth = std::numeric_limits<double>::epsilon() * b.dot(answer) *
                        std::sqrt(static_cast<double>(n)) * unit[0] / b.norm();
  EXPECT_NEAR(rounding_growth(sparse, unit, *interior->factor), growth, 1e-9 * growth);
  DenseMatrix y;
  std::vector<Vector> r;
  forward(*interior->factor, right, y, r);
  const Vector inside = y.row(0).head(interior->n_interior());
  EXPECT_NEAR(rounding_growth(b, unit, inside, r[0], *interior->factor), growth, 1e-9 * growth);
}

/// Of two unknowns, the second one in other units, by both kinds of factors.
TEST_F(Body, TheGrowthOfRoundingDoesNotDependOnUnits) {
  std::vector<std::uint8_t> of_unknown(n, 0);
  for (int i = 0; i < n; i += 2) of_unknown[static_cast<std::size_t>(i)] = 1;
  const auto growth = [&](double other, bool symmetric) {
    Vector units = Vector::Ones(n);
    for (int i = 0; i < n; i += 2) units[i] = other;
    const SparseMatrix k = (units.asDiagonal() * t * units.asDiagonal()).eval().sparseView();
    const auto factor = take_factor(nullptr, k, contact, symmetric);
    return rounding_growth(k, {own_stiffness(k), of_unknown}, *factor);
  };
  for (const bool symmetric : {true, false})
    for (const double other : {0x1p-20, 0x1p20})
      EXPECT_NEAR(growth(other, symmetric), growth(1.0, symmetric), 1e-9 * growth(1.0, symmetric));
}

/// Of states far from equilibrium, as of one step and as of several.
TEST_F(Body, ErrorsOfEquilibriumAreThoseOfTheFormula) {
  constexpr double any_error = std::numeric_limits<double>::infinity();
  std::vector<InteriorEquilibrium::Question> steps;
  for (int r = 0; r < 5; ++r)
    steps.push_back({any(interior->size()), any(interior->size()), any(interior->size()), any(2)});
  const Vector next = any(interior->size());
  const auto roughly = equilibrium->errors(steps, any_error);
  KnownField read_next[] = {{next, {}}};
  EXPECT_EQ(equilibrium->errors(steps, any_error, read_next), roughly);
  const auto exactly = equilibrium->errors(steps, 0.0);
  // A field has the bits that it has alone.
  Vector alone = Vector::Zero(n), full = Vector::Zero(n);
  fields->scatter(next, alone);
  EXPECT_LT((alone - whole(next)).norm(), 1e-12 * alone.norm());
  EXPECT_EQ(read_next[0].unknowns, alone);
  read_next[0].unknowns[6] += 1.0; // to see that what is kept is taken, and for its own y only
  fields->keep(read_next[0]);
  fields->scatter(next, full);
  EXPECT_EQ(full, read_next[0].unknowns);
  fields->scatter(-next, full);
  EXPECT_LT((full + alone).norm(), 1e-12 * alone.norm());
  for (std::size_t r = 0; r < steps.size(); ++r) {
    const auto& s = steps[r];
    const Vector a = whole(s.known), b = whole(s.change), f = load(s.load);
    const Vector reaction = reaction_of * s.xi;
    const Vector gap = (f - t * (a + b) - reaction).cwiseAbs();
    const auto worst = [&](const Vector& size) { return gap.cwiseQuotient(size).maxCoeff(); };
    const DenseMatrix sizes = t.cwiseAbs();
    const Vector own = f.cwiseAbs();
    EXPECT_NEAR(roughly[r], worst(sizes * (a + b).cwiseAbs() + own), 1e-9 * roughly[r]);
    const double each = worst(sizes * (a.cwiseAbs() + b.cwiseAbs()) + own + reaction.cwiseAbs());
    // A row's scale is a little more: a hundredth of what it were with other axes.
    for (const double found : {exactly[r], equilibrium->error(s, 0.0)}) {
      EXPECT_LE(found, each * (1.0 + 1e-9));
      EXPECT_GE(found, each / 1.05);
    }
  }
}

} // namespace
} // namespace hvi::solver
