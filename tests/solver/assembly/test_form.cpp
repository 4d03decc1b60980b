// Bilinear forms against a slow assembler, closed forms, and the rules of the pattern.
#include "tests/solver/assembly/reference.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace hvi::solver {
namespace {

using namespace test;

double distance(const SparseMatrix& fast, const Eigen::MatrixXd& slow) {
  const Eigen::MatrixXd dense(fast);
  return (dense - slow).cwiseAbs().maxCoeff() / slow.cwiseAbs().maxCoeff();
}

/// Every pair of derivatives of a space, each with its own coefficient.
FormTerm all_pairs(const Space& space, bool gradients,
                   const std::function<Expr(int)>& coefficient) {
  std::vector<int> indices;
  for (int i = 0; i < space.components; ++i) {
    indices.push_back(slot::value(i));
    for (int j = 0; gradients && j < space.mesh->dim; ++j) indices.push_back(slot::gradient(i, j));
  }
  FormTerm term;
  int count = 0;
  for (const int a : indices) {
    for (const int b : indices) term.entries.push_back({a, b, coefficient(++count)});
  }
  return term;
}

TEST(Form, AllDerivativesWithConstantsMatchTheSlowAssembler) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      for (const int components : {1, dim}) {
        const Mesh mesh = skew_mesh(dim, dim == 3 ? 1 : 2);
        const Space space = make_space(mesh, order, components);
        const auto term = all_pairs(space, true, [](int k) { return Expr(0.3 + std::sin(k)); });
        const auto slow = slow_form(space, all_cells(mesh), term);
        EXPECT_LT(distance(assemble_form(space, all_cells(mesh), term), slow), 1e-13);
      }
    }
  }
}

bool same_bits(const SparseMatrix& a, const SparseMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
         std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

TEST(Form, SeveralInOnePassHaveTheBitsOfEachAlone) {
  const Expr x = Expr::variable(slot::x(0));
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 2);
      const Space space = make_space(mesh, order, dim);
      const FormTerm forms[] = {elasticity(dim, 1.7, 0.6),
                                all_pairs(space, false, [](int k) { return Expr(std::sin(k)); }),
                                elasticity(dim, x, 0.3), elasticity(dim, 0.2, 2.5)};
      const FormTerm* const terms[] = {&forms[0], &forms[1], &forms[2], &forms[3]};
      const auto together = assemble_forms(space, all_cells(mesh), terms);
      for (std::size_t f = 0; f < together.size(); ++f)
        EXPECT_TRUE(same_bits(together[f], assemble_form(space, all_cells(mesh), forms[f])));
    }
  }
}

// Every third dof is left out, every fifth has a column behind the others.
TEST(Form, OfASelectionIsTheFullOneCutToIt) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    const Space space = make_space(mesh, dim == 3 ? 1 : 2, dim);
    std::vector<std::int32_t> entry_of(space.n_dofs(), -1);
    DofSelection dofs;
    for (int i = 0; i < space.n_dofs(); ++i)
      if (i % 3 != 0 && i % 5 != 0) entry_of[i] = dofs.n_rows++;
    dofs.n_columns = dofs.n_rows;
    for (int i = 0; i < space.n_dofs(); ++i)
      if (i % 3 != 0 && i % 5 == 0) entry_of[i] = dofs.n_columns++;
    dofs.entry_of = entry_of;
    const auto term = all_pairs(space, true, [](int k) { return Expr(0.3 + std::sin(k)); });
    const Eigen::MatrixXd full(assemble_form(space, all_cells(mesh), term));
    const SparseMatrix cut = assemble_form(space, all_cells(mesh), term, dofs);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(dofs.n_rows, dofs.n_columns);
    for (int i = 0; i < space.n_dofs(); ++i)
      for (int j = 0; j < space.n_dofs(); ++j)
        if (entry_of[i] >= 0 && entry_of[i] < dofs.n_rows && entry_of[j] >= 0)
          expected(entry_of[i], entry_of[j]) = full(i, j);
    EXPECT_EQ((Eigen::MatrixXd(cut) - expected).cwiseAbs().maxCoeff(), 0.0);
    for (int i = 0; i < cut.rows(); ++i)
      EXPECT_TRUE(std::is_sorted(cut.innerIndexPtr() + cut.outerIndexPtr()[i],
                                 cut.innerIndexPtr() + cut.outerIndexPtr()[i + 1]));
  }
}

TEST(Form, ElasticityMatchesTheSlowAssembler) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, dim == 3 ? 1 : 3);
      const Space space = make_space(mesh, order, dim);
      const auto term = elasticity(dim, 1.7, 0.6);
      const SparseMatrix k = assemble_form(space, all_cells(mesh), term);
      EXPECT_LT(distance(k, slow_form(space, all_cells(mesh), term)), 1e-13);
      const SparseMatrix transposed = k.transpose();
      EXPECT_LT((Eigen::MatrixXd(k) - Eigen::MatrixXd(transposed)).cwiseAbs().maxCoeff(), 1e-14);
    }
  }
}

TEST(Form, PolynomialCoefficientsAreIntegratedExactly) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 1);
      const Space space = make_space(mesh, order, dim);
      const Expr last = dim == 1 ? x : dim == 2 ? y : z;
      const auto term = all_pairs(space, true, [&](int k) {
        return Expr(1.0) + Expr(0.1 * k) * x * x * last - Expr(0.2) * last * last * last * last;
      });
      const auto slow = slow_form(space, all_cells(mesh), term);
      EXPECT_LT(distance(assemble_form(space, all_cells(mesh), term), slow), 1e-13);
    }
  }
}

TEST(Form, SmoothCoefficientsConverge) {
  // The rule of degree 2 (order + 1): the error of one cell falls with that power of its size.
  const Mesh coarse = skew_mesh(2, 2), fine = refine(coarse);
  for (int order = 1; order <= 2; ++order) {
    double error[2];
    int k = 0;
    for (const Mesh* mesh : {&coarse, &fine}) {
      const Space space = make_space(*mesh, order, 1);
      FormTerm term;
      term.entries.push_back({slot::value(0), slot::value(0), exp(Expr(3.0) * x * y)});
      const SparseMatrix m = assemble_form(space, all_cells(*mesh), term);
      const auto slow = slow_form(space, all_cells(*mesh), term);
      const Vector one = Vector::Ones(space.n_dofs());
      error[k++] = std::abs(one.dot(m * one) - one.dot(slow * one));
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 2 * (order + 1));
  }
}

TEST(Form, FacetsWithNormalsAndGradientsOfTheCellBehind) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, dim == 3 ? 1 : 2);
      const Space space = make_space(mesh, order, dim);
      for (const bool gradients : {false, true}) {
        const auto term = all_pairs(space, gradients, [&](int k) {
          return Expr(0.2 * k) + x * Expr::variable(slot::normal(k % dim));
        });
        const SparseMatrix fast = assemble_form(space, skin(mesh), term);
        EXPECT_LT(distance(fast, slow_form(space, skin(mesh), term)), 1e-13);
        SparseMatrix sum =
            0.0 * assemble_form(space, all_cells(mesh),
                                all_pairs(space, true, [](int) { return Expr(1.0); }));
        add_scaled(sum, 2.0, fast); // its pattern is part of the cells'
        EXPECT_LT((Eigen::MatrixXd(sum) - 2 * Eigen::MatrixXd(fast)).norm(), 1e-15);
      }
    }
  }
}

TEST(Form, InteriorFacetsCountOnce) {
  Mesh mesh = box_mesh(2, {2, 2, 0});
  const auto a = node_region(mesh, {0.5, 0, 0}).entities[0];
  const auto b = node_region(mesh, {0.5, 0.5, 0}).entities[0];
  mesh.facets.clear();
  const auto named = build_facets(mesh, {{a, b, -1}});
  const Region line{Group::Kind::facets, {named[0]}, 0};
  ASSERT_GE(mesh.facets[named[0]].other, 0);
  const Space space = make_space(mesh, 2, 1);
  const Vector one = Vector::Ones(space.n_dofs());
  EXPECT_NEAR(one.dot(boundary_mass(space, line, Rule::exact, Trace::full) * one), 0.5, 1e-15);
}

TEST(Form, CellFormsShareOnePattern) {
  const Mesh mesh = skew_mesh(2, 3);
  const Space space = make_space(mesh, 2, 2);
  const SparseMatrix a = assemble_form(space, all_cells(mesh), elasticity(2, 1.0, 1.0));
  Region half = all_cells(mesh);
  half.entities.resize(half.entities.size() / 2);
  const SparseMatrix b = assemble_form(space, half, elasticity(2, x, y + Expr(2.0)));
  ASSERT_EQ(a.nonZeros(), b.nonZeros());
  EXPECT_TRUE(std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()));
  EXPECT_TRUE(std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()));
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    EXPECT_TRUE(std::is_sorted(a.innerIndexPtr() + a.outerIndexPtr()[i],
                               a.innerIndexPtr() + a.outerIndexPtr()[i + 1]));
  }
}

TEST(Form, AddScaledRefusesEntriesOutsideThePattern) {
  const Mesh mesh = box_mesh(2, {3, 3, 0});
  const Space space = make_space(mesh, 1, 1);
  SparseMatrix small = boundary_mass(space, group(mesh, "left"), Rule::exact, Trace::full);
  EXPECT_THROW(add_scaled(small, 1.0, mass(space)), std::invalid_argument);
  const Space vectors = make_space(mesh, 1, 2);
  SparseMatrix other = assemble_form(vectors, all_cells(mesh), elasticity(2, 1.0, 1.0));
  EXPECT_THROW(add_scaled(other, 1.0, small), std::invalid_argument);
}

TEST(Form, PatchesOfPolynomialsHaveTheirEnergy) {
  // P2, u = (x^2, x y), v = (y^2, x): eps(u) = (2x, y/2; y/2, x), eps(v) = (0, y + 1/2; ., 0) on
  // the unit square: int 2 mu eps(u):eps(v) = 2 mu int (y^2 + y/2) = 2 mu 7/12 (analytic).
  const Mesh mesh = box_mesh(2, {3, 3, 0});
  const Space space = make_space(mesh, 2, 2);
  const Vector u = interpolate(space, std::vector<Expr>{x * x, x * y}, 0, Origin{});
  const Vector v = interpolate(space, std::vector<Expr>{y * y, x}, 0, Origin{});
  const double mu = 0.8;
  const SparseMatrix k = assemble_form(space, all_cells(mesh), elasticity(2, 3.0, mu));
  EXPECT_NEAR(v.dot(k * u), 2 * mu * 7.0 / 12, 1e-14);
  // int (div u)^2 = int (3 x)^2 = 3, eps(u):eps(u) = 5/3 + 1/6.
  EXPECT_NEAR(u.dot(k * u), 3 * 3 + 2 * mu * (5.0 / 3 + 1.0 / 6), 1e-13);
  EXPECT_NEAR(u.dot(gram_of_unknown(space, 0, false) * u), 5.0 / 3 + 1.0 / 6, 1e-14);
  // int x^4 + x^2 y^2 = 1/5 + 1/9.
  EXPECT_NEAR(u.dot(mass(space) * u), 0.2 + 1.0 / 9, 1e-14);
  EXPECT_NEAR(u.dot(gram_of_unknown(space, 0, true) * u), 11.0 / 6 + 0.2 + 1.0 / 9, 1e-14);
}

TEST(Form, LinearPatchIsInEquilibrium) {
  // A constant stress does no work on a field that vanishes on the boundary.
  for (int dim = 2; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 3);
      const Space space = make_space(mesh, order, dim);
      const std::vector<Expr> affine{x + Expr(2.0) * y, Expr(0.3) * x - y, z + x};
      const Vector u = interpolate(space, std::span(affine).first(dim), 0, Origin{});
      const Vector r = assemble_form(space, all_cells(mesh), elasticity(dim, 1.3, 0.4)) * u;
      const auto on_skin = nodes_on(space, skin(mesh));
      for (int i = 0; i < static_cast<int>(space.nodes.size()); ++i) {
        if (std::binary_search(on_skin.begin(), on_skin.end(), i)) continue;
        for (int c = 0; c < dim; ++c) EXPECT_NEAR(r[space.dof(i, c)], 0, 1e-13);
      }
    }
  }
}

TEST(Form, RigidMotionsHaveNoEnergy) {
  const Mesh mesh = skew_mesh(3, 2);
  const Space space = make_space(mesh, 1, 3);
  const SparseMatrix k = assemble_form(space, all_cells(mesh), elasticity(3, 1.0, 1.0));
  const Vector turn = interpolate(space, std::vector<Expr>{-y, x, Expr(1.0)}, 0, Origin{});
  EXPECT_LT((k * turn).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Form, NodalRuleLumpsTheMass) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    const Space space = make_space(mesh, 1, 1);
    FormTerm term;
    term.rule = Rule::nodal;
    term.entries.push_back({slot::value(0), slot::value(0), Expr(1.0)});
    const SparseMatrix lumped = assemble_form(space, all_cells(mesh), term);
    const Vector row_sums = mass(space) * Vector::Ones(space.n_dofs());
    EXPECT_LT((Eigen::MatrixXd(lumped) - Eigen::MatrixXd(row_sums.asDiagonal())).norm(), 1e-15);
  }
}

TEST(Form, TracesOfTheBoundaryMass) {
  const Mesh mesh = skew_mesh(3, 1);
  const Space space = make_space(mesh, 1, 3);
  const auto by = [&](Trace trace) {
    return Eigen::MatrixXd(boundary_mass(space, skin(mesh), Rule::exact, trace));
  };
  EXPECT_LT((by(Trace::full) - by(Trace::normal) - by(Trace::tangential)).norm(), 1e-14);
  // On a plane side z' = const in a box: u = e_z is normal to the top and tangential to the sides.
  const Mesh box = box_mesh(3, {2, 2, 2}, {1, 2, 3});
  const Space space2 = make_space(box, 1, 3);
  const std::vector<Expr> up{Expr(0.0), Expr(0.0), Expr(1.0)};
  const Vector e = interpolate(space2, up, 0, Origin{});
  EXPECT_NEAR(e.dot(boundary_mass(space2, skin(box), Rule::exact, Trace::normal) * e), 4, 1e-13);
  EXPECT_NEAR(e.dot(boundary_mass(space2, skin(box), Rule::exact, Trace::tangential) * e), 18,
              1e-12);
}

TEST(Form, PointRegionsSumValues) {
  const Mesh mesh = box_mesh(2, {2, 2, 0});
  const Space space = make_space(mesh, 2, 2);
  FormTerm spring;
  spring.entries.push_back({slot::value(1), slot::value(1), x * Expr(3.0)});
  const Region corner = node_region(mesh, {1, 1, 0});
  const SparseMatrix k = assemble_form(space, corner, spring);
  EXPECT_EQ(k.sum(), 3.0);
  const int dof = space.dof(corner.entities[0], 1);
  EXPECT_EQ(k.coeff(dof, dof), 3.0);
  spring.entries.push_back({slot::gradient(0, 0), slot::value(0), Expr(1.0)});
  EXPECT_THROW(assemble_form(space, corner, spring), Failure);
}

TEST(Form, IndicatorsOfParts) {
  const Mesh mesh = box_mesh(2, {2, 2, 0});
  Region left;
  for (const auto c : all_cells(mesh).entities) {
    double middle = 0;
    for (int k = 0; k < 3; ++k) middle += mesh.nodes[mesh.cells[c][k]][0] / 3;
    if (middle < 0.5) left.entities.push_back(c);
  }
  const std::vector<Region> parts{all_cells(mesh), left, group(mesh, "top")};
  const Space space = make_space(mesh, 1, 1, parts);
  const Expr in_left = Expr::variable(slot::inside(1)), on_top = Expr::variable(slot::inside(2));
  const Vector one = Vector::Ones(space.n_dofs());
  const auto total = [&](const Region& where, const Expr& e) {
    FormTerm term;
    term.entries.push_back({slot::value(0), slot::value(0), e});
    return one.dot(assemble_form(space, where, term) * one);
  };
  EXPECT_NEAR(total(parts[0], Expr(2.0) + in_left), 2.5, 1e-14);
  EXPECT_NEAR(total(parts[0], on_top), 0, 1e-15);
  EXPECT_NEAR(total(skin(mesh), on_top), 1, 1e-14);
  EXPECT_NEAR(total(skin(mesh), in_left), 2, 1e-14); // half of bottom and top, and the left side
}

TEST(Form, BadCoefficientsNameThePoint) {
  const Mesh mesh = box_mesh(2, {2, 2, 0});
  const Space space = make_space(mesh, 1, 2);
  auto term = elasticity(2, sqrt(x - Expr(0.5)), Expr(1.0));
  term.origin = Origin{42};
  try {
    assemble_form(space, all_cells(mesh), term);
    FAIL();
  } catch (const Failure& f) {
    EXPECT_EQ(f.kind, FailureKind::bad_value);
    EXPECT_EQ(f.origin.id, 42);
    EXPECT_NE(std::string(f.what()).find("nan at ("), std::string::npos) << f.what();
  }
  EXPECT_THROW(assemble_form(space, all_cells(mesh),
                             elasticity(2, std::numeric_limits<double>::infinity(), 1.0)),
               Failure);
  FormTerm wrong;
  wrong.entries.push_back({slot::gradient(0, 2), slot::value(0), Expr(1.0)});
  EXPECT_THROW(assemble_form(space, all_cells(mesh), wrong), Failure);
  wrong.entries[0] = {slot::value(2), slot::value(0), Expr(1.0)};
  EXPECT_THROW(assemble_form(space, all_cells(mesh), wrong), Failure);
}

} // namespace
} // namespace hvi::solver
