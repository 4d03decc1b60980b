// The two numbers of the certificate on hand-made states, whichever way the ground is turned: what
// is rounding passes, what is a few hundred times as much does not.
#include "solver/discrete/certificate.hpp"
#include "tests/solver/law/laws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

using test::arg;

constexpr double tolerance = 1e-10;

/// One node with a law on its displacement along a direction: `rows` of G on the unknowns u_x, u_y.
Contact one_point(LawSpec spec, const DenseMatrix& rows) {
  Contact out;
  out.laws.push_back(std::make_unique<Law>(std::move(spec)));
  out.problem.laws = {out.laws[0].get()};
  out.problem.graphs = {out.laws[0]->graph({}, 0.0)};
  ContactPoint point;
  point.rows = static_cast<int>(rows.rows());
  point.weight = 0.5;
  out.problem.points = {point};
  ContactTerm term;
  term.points.x = {Point{}};
  term.points.rows = point.rows;
  out.terms.push_back(std::move(term));
  out.g = rows.sparseView();
  out.force = (point.weight * rows.transpose()).sparseView();
  out.unknowns = out.loaded = {0, 1};
  out.offset = Vector::Zero(rows.rows());
  out.reach = Vector::Zero(2);
  out.scales = {1.0};
  return out;
}

DenseMatrix along(double angle) {
  DenseMatrix out(1, 2);
  out << std::cos(angle), std::sin(angle);
  return out;
}

double error_at(const Contact& contact, const Vector& u, double xi) {
  Vector z;
  return inclusion_error(contact, LawFields(u), Vector::Constant(1, xi), tolerance, z).worst;
}

LawSpec sticks() { return {"sticks", Origin{1}, true, true, Expr(1.0)}; }
LawSpec stops() {
  return {"stops", Origin{1}, false, true,
          select(less_equal(arg(), Expr(0.0)), Expr(0.0), Expr(1e300))};
}

const double angles[] = {0.0, 1e-3, 0.3, 0.7853981633974483, 1.2, 2.9, 4.4};

// Sticking while the node moves across by 1e-2: z is what is left of numbers of that size.
TEST(Inclusion, ScaleIsWhatTheArgumentIsMadeOf) {
  for (const double angle : angles) {
    if (angle == 0.0) continue; // along an axis nothing cancels
    const auto stick = one_point(sticks(), along(angle)), stop = one_point(stops(), along(angle));
    const double part = 1e-2 * 2 * std::abs(std::sin(angle) * std::cos(angle));
    for (const double side : {-1.0, 1.0}) {
      const auto moved = [&](double parts) {
        Vector u(2);
        u << -std::sin(angle), std::cos(angle);
        return Vector(1e-2 * u + side * parts * tolerance * part * along(angle).transpose());
      };
      EXPECT_EQ(error_at(stick, moved(1e-6), -0.7 * side), 0.0) << angle;
      EXPECT_EQ(error_at(stick, moved(0.9), -0.7 * side), 0.0) << angle;
      EXPECT_NEAR(error_at(stick, moved(300), -0.7 * side), 1.7, 1e-9) << angle;
      EXPECT_GT(error_at(stick, moved(1.2), -0.7 * side), 1.0) << angle;
    }
    const auto opened = [&](double parts) {
      Vector u(2);
      u << -std::sin(angle), std::cos(angle);
      return Vector(1e-2 * u - parts * tolerance * part * along(angle).transpose());
    };
    EXPECT_EQ(error_at(stop, opened(0.9), 5.0), 0.0) << angle;
    EXPECT_EQ(error_at(stop, opened(300), 5.0), 1.0) << angle;
    EXPECT_EQ(error_at(stop, opened(300), 0.0), 0.0) << angle;
  }
}

// Nothing moves at all: the scale is the displacement that the forces amount to.
TEST(Inclusion, ScaleIsComplianceTimesForceWhereNothingMoves) {
  for (const double unit : {1e-6, 1.0, 1e6})
    for (const double angle : angles) {
      auto contact = one_point(sticks(), along(angle));
      const Vector k = Vector::Constant(2, 4.0 / unit);
      const Vector b = 3.0 * along(angle).transpose(), none = Vector::Zero(2);
      find_reach(k, none, none, b, contact);
      const double reach = 0.75 * unit; // 3 / 4 along the row, in each of its unknowns' shares,
      const Vector share = along(angle).cwiseAbs().transpose(); // and a hundredth of the largest
      const Vector expected = reach * (share + Vector::Constant(2, 0.01 * share.maxCoeff()));
      EXPECT_LT((contact.reach - expected).norm(), 1e-15 * reach);
      const auto at = [&](double parts) {
        return error_at(contact, parts * tolerance * reach * along(angle).transpose(), -0.7);
      };
      EXPECT_EQ(at(1e-6), 0.0) << angle;
      EXPECT_EQ(at(0.9), 0.0) << angle;
      EXPECT_NEAR(at(300), 1.7, 1e-9) << angle;
      EXPECT_GT(at(1.2), 1.0) << angle;
    }
}

// A moving support is part of the argument, too.
TEST(Inclusion, ScaleHoldsTheOffset) {
  auto contact = one_point(sticks(), along(0.0));
  contact.offset[0] = -2.0;
  Vector u(2);
  u << 2.0 + 3.0 * tolerance, 0.0; // of 4
  EXPECT_EQ(error_at(contact, u, -0.5), 0.0);
  u[0] = 2.0 + 1000 * tolerance;
  EXPECT_NEAR(error_at(contact, u, -0.5), 1.5, 1e-6);
}

// What a law makes of an argument that may be anywhere within its scale: over all its pieces there,
// without jumps.
TEST(Inclusion, MultipliersHaveWhatTheLawMakesOfTheScale) {
  const Expr r = arg();
  LawSpec bent{"bent", Origin{1}, false, true,
               select(less(r, Expr(0.0)), Expr(2.0) * r,
                      select(less(r, Expr(1.0)), Expr(3.0) * r, Expr(7.0) * r))};
  auto contact = one_point(bent, along(0.0));
  const Vector u = Vector::Zero(2), none = Vector::Zero(1);
  for (const double reach : {0.5, 1.0, 4.0}) {
    contact.reach[0] = reach;
    const double made = 2.0 * reach + 3.0 * std::min(reach, 1.0) + 7.0 * std::max(reach - 1.0, 0.0);
    EXPECT_NEAR(multiplier_scale(contact, contact.terms[0], LawFields(u), none), made, 1e-14);
    EXPECT_EQ(multiplier_scale(contact, contact.terms[0], LawFields(u), Vector::Constant(1, 99.0)),
              99.0);
  }
}

struct Row {
  SparseMatrix k{2, 2}, force{2, 2};
  Vector d = Vector::Zero(2), b = Vector::Zero(2), xi = Vector::Zero(2), gap{2};
  std::vector<std::uint8_t> of_unknown{};
  Row() {
    k.insert(0, 0) = k.insert(1, 1) = 2.0;
    force.insert(0, 0) = force.insert(1, 1) = 1.0;
  }
  /// By each of the three ways; they have to agree.
  double error() {
    k.makeCompressed(), force.makeCompressed();
    const std::vector<int> contact{0, 1};
    const Vector kd = k * d, diagonal = k.diagonal();
    const Reactions reactions{force, of_unknown};
    const double one = equilibrium_error(k, d, b, contact, reactions, xi, gap);
    const double two = equilibrium_error(k, diagonal, kd, d, b, contact, reactions, xi, gap);
    Vector scale(2);
    gap_and_scale(k, d, b, gap, scale);
    const double three = equilibrium_error(k, d, gap, scale, reactions, xi);
    EXPECT_EQ(one, two);
    EXPECT_EQ(one, three);
    return one;
  }
};

// All nodes stick and nothing pulls across: that row holds rounding of the other's multiplier.
TEST(Equilibrium, RoundingOfAMultiplierIsNoForce) {
  Row row;
  row.b << 3.0, 0.0;
  row.xi << 3.0, 3e-16;
  EXPECT_LT(row.error(), 2e-14);
  row.xi[1] = 3e-9;
  EXPECT_GT(row.error(), 9e-8);
  row.xi << 0.0, 0.0;
  row.b.setZero();
  EXPECT_EQ(row.error(), 0.0); // nothing acts at all
  row.b[1] = 1.0;
  EXPECT_EQ(row.error(), 1.0);
}

// Entries of K are known up to rounding of its diagonal, and so is a row in which they cancel.
TEST(Equilibrium, RoundingOfProductsIsNoForce) {
  Row row;
  row.k.coeffRef(1, 0) = 1e-16;
  row.d << 1.0, -3e-17;
  row.b << 2.0, 0.0;
  EXPECT_LT(row.error(), 2e-14);
  row.d[1] = 1e-9;
  EXPECT_GT(row.error(), 9e-8);
}

// A row is judged by what is of its own unknown: the others have other units.
TEST(Equilibrium, EachOfSeveralUnknownsHasItsOwnSize) {
  Row row;
  row.k.coeffRef(1, 0) = 1e-16;
  row.d << 1e9, 1.0;
  row.b << 2e9, 2.0 + 1e-6;
  const double as_one = row.error();
  row.of_unknown = {0, 1};
  EXPECT_GT(row.error(), 100.0 * as_one);
  EXPECT_GT(row.error(), 1e-7);
}

// And by its own multipliers: those of the others are large in their units.
TEST(Equilibrium, EachOfSeveralUnknownsHasItsOwnMultipliers) {
  Row row;
  row.xi << 1e9, 1.0;
  row.b << 1e9, 1.0 + 1e-6;
  const double as_one = row.error();
  row.of_unknown = {0, 1};
  EXPECT_GT(row.error(), 100.0 * as_one);
  EXPECT_NEAR(row.error(), 0.5e-6, 0.1e-6);
}

// Rows whose errors are close to each other: none of the three ways may pass over the worst.
TEST(Equilibrium, IsThatOfTheWorstOfManyRows) {
  constexpr int n = 12;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const std::vector<int> contact{2, 5, 6, 11};
  for (int scene = 0; scene < 50; ++scene) {
    const DenseMatrix k = DenseMatrix::NullaryExpr(n, n, [&] { return unit(random); });
    DenseMatrix force = DenseMatrix::Zero(n, 3);
    for (const int i : contact)
      for (int j = 0; j < 3; ++j) force(i, j) = unit(random);
    const Vector d = Vector::NullaryExpr(n, [&] { return unit(random); });
    const Vector xi = Vector::NullaryExpr(3, [&] { return unit(random); });
    Vector b = k * d + force * xi;
    for (double& value : b) value *= 1.0 + 1e-6 * unit(random);
    double worst = 0.0;
    for (int i = 0; i < n; ++i) {
      double left = b[i], size = std::abs(b[i]);
      double turned = std::abs(k(i, i)) * d.cwiseAbs().maxCoeff();
      for (int j = 0; j < n; ++j) left -= k(i, j) * d[j], size += std::abs(k(i, j) * d[j]);
      for (int j = 0; j < 3; ++j) {
        left -= force(i, j) * xi[j], size += std::abs(force(i, j) * xi[j]);
        turned += std::abs(force(i, j)) * xi.cwiseAbs().maxCoeff();
      }
      worst = std::max(worst, std::abs(left) / (size + 0.01 * turned));
    }
    const SparseMatrix rows = k.sparseView(), forces = force.sparseView();
    const std::vector<std::uint8_t> of_unknown;
    const Reactions reactions{forces, of_unknown};
    const Vector kd = rows * d, diagonal = k.diagonal();
    Vector gap(n), scale(n);
    const double one = equilibrium_error(rows, d, b, contact, reactions, xi, gap);
    const double two = equilibrium_error(rows, diagonal, kd, d, b, contact, reactions, xi, gap);
    gap_and_scale(rows, d, b, gap, scale);
    const double three = equilibrium_error(rows, d, gap, scale, reactions, xi);
    for (const double found : {one, two, three}) EXPECT_NEAR(found, worst, 1e-8 * worst);
  }
}

TEST(Equilibrium, CancellingReactionsHaveAScale) {
  Row row;
  row.force.coeffRef(0, 1) = -1.0; // a ground turned by 45 degrees
  row.xi << 1.0, 1.0 + 1e-9;
  row.b << 0.0, 1.0 + 1e-9;
  EXPECT_NEAR(row.error(), 5e-10, 1e-11);
  row.xi[0] = 1.1;
  EXPECT_GT(row.error(), 0.04);
}

// Rounding is not hidden: no tolerance below it is ever reached.
TEST(Equilibrium, RoundingOfARowWithForcesIsSeen) {
  Row row;
  row.d << 1.0, 1.0;
  row.b << 2.0, 2.0 + 0x1p-51;
  EXPECT_NEAR(row.error(), 0x1p-53, 2e-18);
}

TEST(Equilibrium, NotANumberIsInfinite) {
  Row row;
  row.b << std::nan(""), 1.0;
  EXPECT_TRUE(std::isinf(row.error()));
}

} // namespace
} // namespace hvi::solver
