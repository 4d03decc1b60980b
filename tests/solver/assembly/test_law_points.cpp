// Quadrature points of superpotentials: weights, merging, normals, frames, offsets.
#include "tests/solver/assembly/reference.hpp"

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <numbers>
#include <set>

namespace hvi::solver {
namespace {

using namespace test;

const Expr n0 = Expr::variable(slot::normal(0)), n1 = Expr::variable(slot::normal(1)),
           n2 = Expr::variable(slot::normal(2));

LawTerm normal_law(int dim, Rule rule = Rule::nodal) {
  LawTerm term;
  term.name = "layer";
  term.origin = Origin{9};
  term.rule = rule;
  LawTerm::Row row;
  const std::array<Expr, 3> n{n0, n1, n2};
  for (int i = 0; i < dim; ++i) row.u[i] = n[i];
  term.rows.push_back(row);
  return term;
}

/// u_tau = u - (u . nu) nu.
LawTerm friction(int dim, Rule rule = Rule::nodal) {
  LawTerm term = normal_law(dim, rule);
  term.rows.clear();
  const std::array<Expr, 3> n{n0, n1, n2};
  for (int c = 0; c < dim; ++c) {
    LawTerm::Row row;
    for (int i = 0; i < dim; ++i) row.u[i] = Expr(c == i ? 1.0 : 0.0) - n[c] * n[i];
    term.rows.push_back(row);
  }
  return term;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(LawPoints, WeightsAddUpToTheMeasureForEveryRule) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    for (int order = 1; order <= 2; ++order) {
      const Space space = make_space(mesh, order, dim);
      for (const Rule rule : {Rule::exact, Rule::nodal, Rule::midpoint, Rule::gauss}) {
        for (const Region& region : {skin(mesh), all_cells(mesh)}) {
          LawTerm term = normal_law(dim, rule);
          term.rows[0].u[0] = 1.0; // cells have no normal
          const LawPoints p = assemble_law(space, region, term, 3, false);
          EXPECT_NEAR(sum(p.weight), measure_of(mesh, region), 1e-13);
          EXPECT_TRUE(
              std::all_of(p.weight.begin(), p.weight.end(), [](double w) { return w > 0; }));
          EXPECT_EQ(p.law_term, 3);
          EXPECT_EQ(p.g.rows(), static_cast<Eigen::Index>(p.x.size()));
          EXPECT_EQ(p.node[0] >= 0, rule == Rule::nodal);
        }
      }
    }
  }
}

TEST(LawPoints, EvaluatesTheArgumentOfAField) {
  // G u at a point is the argument of the interpolated function there (u in the space: exact).
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    for (int order = 1; order <= 2; ++order) {
      const Space space = make_space(mesh, order, dim);
      const Expr q = order == 1 ? Expr(0.5) : x;
      const std::vector<Expr> field{x * q + Expr(1.0), Expr(2.0) * x - y, z - q};
      const Vector u = interpolate(space, std::span(field).first(dim), 0, Origin{});
      for (const Rule rule : {Rule::exact, Rule::nodal, Rule::midpoint, Rule::gauss}) {
        LawTerm term = normal_law(dim, rule);
        const LawPoints p = assemble_law(space, skin(mesh), term, 0, false);
        const Vector argument = p.g * u;
        for (std::size_t k = 0; k < p.x.size(); ++k) {
          double expected = 0;
          for (int i = 0; i < dim; ++i) {
            expected += p.normal[k][i] * slow_value(field[i], p.x[k], {}, 0);
          }
          EXPECT_NEAR(argument[Eigen::Index(k)], expected, 1e-13);
        }
      }
    }
  }
}

TEST(LawPoints, NodalPointsMergeOnPlanesAndSplitAtCorners) {
  const Mesh mesh = box_mesh(2, {4, 3, 0});
  const Space space = make_space(mesh, 1, 2);
  const Region corner = join(group(mesh, "bottom"), group(mesh, "right"));
  const LawPoints p = assemble_law(space, corner, normal_law(2), 0, false);
  EXPECT_EQ(p.x.size(), 5u + 4u); // the corner node twice
  const int node = node_region(mesh, {1, 0, 0}).entities[0];
  EXPECT_EQ(std::count(p.node.begin(), p.node.end(), node), 2);
  // Interior nodes of a side carry a whole edge, end nodes half of one.
  for (std::size_t k = 0; k < p.x.size(); ++k) {
    const bool bottom = p.normal[k][1] < -0.5;
    const double s = bottom ? p.x[k][0] : p.x[k][1], edge = bottom ? 0.25 : 1.0 / 3;
    EXPECT_NEAR(p.weight[k], s == 0 || s == 1 ? edge / 2 : edge, 1e-15);
    EXPECT_EQ(p.facet[k] >= 0, true);
  }
  // A law of a component has the same rows on both sides: the points stay apart by their normals.
  LawTerm component = normal_law(2);
  component.rows[0].u = {Expr(0.0), Expr(1.0), Expr(0.0)};
  EXPECT_EQ(assemble_law(space, corner, component, 0, false).x.size(), 9u);
  // Whole box in 3D: corner nodes three times, edge nodes twice.
  const Mesh box = box_mesh(3, {2, 2, 2});
  const Space space3 = make_space(box, 1, 3);
  EXPECT_EQ(assemble_law(space3, skin(box), normal_law(3), 0, false).x.size(), 8u * 3 + 12 * 2 + 6);
}

/// A box, its plane x y turned, scaled, and moved by so many of its sizes.
Mesh moved_box(int dim, double angle, double scale, double far) {
  Mesh mesh = box_mesh(dim, {4, 3, dim == 3 ? 2 : 0});
  for (auto& p : mesh.nodes) {
    const double x = p[0], y = p[1];
    p[0] = scale * (std::cos(angle) * x - std::sin(angle) * y + far);
    p[1] = scale * (std::sin(angle) * x + std::cos(angle) * y - 0.7 * far);
    if (dim == 3) p[2] = scale * (p[2] + 0.3 * far);
  }
  return mesh;
}

std::size_t count_points(const Mesh& mesh, const LawTerm& term) {
  const Space space = make_space(mesh, 1, mesh.dim);
  return assemble_law(space, group(mesh, "bottom"), term, 0, false).x.size();
}

// Far from the origin the nodes of a plane do not lie in one: its facets still have one normal.
TEST(LawPoints, PlanesStayPlanesWhereverTheyLie) {
  for (const double scale : {1e-9, 1.0, 1e9})
    for (const double far : {0.0, 1.0, 1e3, 1e6})
      for (const double angle : {0.0, 0.3, 1.1, 2.9}) {
        EXPECT_EQ(count_points(moved_box(2, angle, scale, far), normal_law(2)), 5u) << far;
        EXPECT_EQ(count_points(moved_box(3, angle, scale, far), normal_law(3)), 15u) << far;
      }
}

// A bend that is no rounding turns the normal, at any scale: by half of it at its nodes, and at the
// ends of the side as much the other way, since there the facet is a chord.
TEST(LawPoints, SmallBendsAreSeen) {
  for (const double scale : {1e-9, 1.0, 1e9})
    for (const double bend : {1e-10, 1e-6, 1e-2}) {
      Mesh mesh = moved_box(2, 0.0, 1.0, 0.0);
      for (auto& p : mesh.nodes)
        if (p[0] == 0.5 && p[1] == 0.0) p[1] -= bend;
      for (auto& p : mesh.nodes)
        for (double& v : p) v *= scale;
      const Space space = make_space(mesh, 1, 2);
      const LawPoints points = assemble_law(space, group(mesh, "bottom"), normal_law(2), 0, false);
      ASSERT_EQ(points.x.size(), 5u) << scale << ' ' << bend;
      for (std::size_t p = 0; p < 5; ++p) {
        const double along = std::round(4.0 * points.x[p][0] / scale);
        const std::array<double, 5> turned{2.0, -2.0, 0.0, 2.0, -2.0};
        EXPECT_NEAR(points.normal[p][0], bend * turned[std::size_t(along)], 1e-15 + 1e-2 * bend);
      }
    }
}

/// A quarter of an annulus about the origin with n cells along it, in 3D with a height.
Mesh bent_box(int dim, int n) {
  Mesh mesh = box_mesh(dim, {n, 2, dim == 3 ? 2 : 0});
  for (auto& p : mesh.nodes) {
    const double r = 1.0 + p[1], angle = 0.5 * std::numbers::pi * p[0];
    p[0] = r * std::sin(angle);
    p[1] = r * std::cos(angle);
  }
  return mesh;
}

// Nodes of a side that turns have one normal, that of the circle, at its ends too.
TEST(LawPoints, SmoothSidesHaveOneNormalAtANode) {
  for (int dim = 2; dim <= 3; ++dim)
    for (int order = 1; order <= 2; ++order) {
      const int n = 6;
      const Mesh mesh = bent_box(dim, n);
      const Space space = make_space(mesh, order, dim);
      const Region round = group(mesh, "bottom");
      const LawPoints points = assemble_law(space, round, friction(dim), 0, true);
      std::set<std::int32_t> nodes(points.node.begin(), points.node.end());
      EXPECT_EQ(nodes.size(), points.x.size()) << dim << order;
      EXPECT_NEAR(sum(points.weight), measure_of(mesh, round), 1e-13);
      Point force{};
      for (std::size_t p = 0; p < points.x.size(); ++p) {
        const Point& x = points.x[p];
        const double r = std::hypot(x[0], x[1]);
        const double along = std::abs(points.normal[p][0] * x[1] - points.normal[p][1] * x[0]) / r;
        EXPECT_NEAR(along, 0.0, 2e-3) // at ends up to the cube of a turn
            << dim << order << " at " << x[0] << " " << x[1] << " " << x[2];
        EXPECT_NEAR(std::hypot(points.normal[p][0], points.normal[p][1], points.normal[p][2]), 1.0,
                    1e-15);
        for (std::size_t i = 0; i < 3; ++i) force[i] += points.weight[p] * points.normal[p][i];
      }
      // The force of a constant pressure is that on the chord, up to the square of a turn.
      EXPECT_NEAR(force[0], -1.0, 0.03);
      EXPECT_NEAR(force[1], -1.0, 0.03);
    }
}

// At the tip of a needle facets point all about: they have no common normal, and keep their own.
TEST(LawPoints, TipsOfNeedlesKeepAllNormals) {
  const int n = 12;
  for (const double height : {0.5, 5.0}) {
    Mesh mesh;
    mesh.dim = 3;
    mesh.nodes = {{0.0, 0.0, -height}, {0.0, 0.0, 0.0}};
    std::vector<std::array<std::int32_t, 3>> side;
    for (int k = 0; k < n; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / n;
      mesh.nodes.push_back({std::cos(angle), std::sin(angle), 0.0});
      const int a = 2 + k, b = 2 + (k + 1) % n;
      mesh.cells.push_back({0, a, b, 1});
      side.push_back({0, b, a});
    }
    const auto facets = build_facets(mesh, side);
    const Region region{Group::Kind::facets, {facets.begin(), facets.end()}};
    const LawPoints points = assemble_law(make_space(mesh, 1, 3), region, normal_law(3), 0, false);
    EXPECT_EQ(std::ssize(points.x), height < 1.0 ? n + 1 : n + n) << height;
  }
}

// Sides that meet at a crease of more than 45 degrees keep a normal each.
TEST(LawPoints, CreasesKeepTheirNormals) {
  for (const double slope : {0.9, 1.1}) {
    Mesh mesh = box_mesh(2, {2, 2, 0});
    for (auto& p : mesh.nodes) p[1] -= slope * std::min(p[0], 0.5);
    const Space space = make_space(mesh, 1, 2);
    const LawPoints points = assemble_law(space, group(mesh, "bottom"), normal_law(2), 0, false);
    EXPECT_EQ(points.x.size(), slope < 1.0 ? 3u : 4u);
  }
}

TEST(LawPoints, InclinedSidesHaveTheirNormals) {
  Mesh mesh = box_mesh(2, {3, 3, 0});
  for (auto& p : mesh.nodes) p[1] += 0.5 * p[0]; // the bottom rises with slope 1/2
  const Space space = make_space(mesh, 2, 2);
  const LawPoints p = assemble_law(space, group(mesh, "bottom"), normal_law(2), 0, false);
  EXPECT_EQ(p.x.size(), 7u); // merged although each edge computes its own normal
  for (const Point& n : p.normal) {
    EXPECT_NEAR(n[0], 0.5 / std::sqrt(1.25), 1e-15);
    EXPECT_NEAR(n[1], -1 / std::sqrt(1.25), 1e-15);
  }
  EXPECT_NEAR(sum(p.weight), std::sqrt(1.25), 1e-15);
}

TEST(LawPoints, FramesAreOrthonormalAndKeepTheNorm) {
  std::mt19937 random(11);
  std::normal_distribution<double> gauss;
  for (int dim = 2; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      const Mesh mesh = skew_mesh(dim, 2);
      const Space space = make_space(mesh, order, dim);
      const LawPoints p = assemble_law(space, skin(mesh), friction(dim), 0, true);
      EXPECT_EQ(p.rows, dim - 1);
      Vector u(space.n_dofs());
      for (auto& v : u) v = gauss(random);
      const Vector reduced = p.g * u;
      for (std::size_t k = 0; k < p.x.size(); ++k) {
        const DenseMatrix& q = p.frames[k];
        ASSERT_EQ(q.rows(), dim);
        ASSERT_EQ(q.cols(), dim - 1);
        EXPECT_LT((q.transpose() * q - DenseMatrix::Identity(dim - 1, dim - 1)).norm(), 1e-14);
        Vector at_node = u.segment(space.dof(p.node[k], 0), dim), n(dim);
        for (int i = 0; i < dim; ++i) n[i] = p.normal[k][i];
        EXPECT_LT((q.transpose() * n).norm(), 1e-14);
        const Vector tangential = at_node - n * n.dot(at_node);
        const Vector mine = q * reduced.segment(Eigen::Index(k) * (dim - 1), dim - 1);
        EXPECT_LT((mine - tangential).norm(), 1e-13);
      }
    }
  }
}

/// u.x + 2 du_0/dx_j + x du_last/dx_0, j the last direction.
LawTerm gradient_law(int dim) {
  LawTerm term = normal_law(0, Rule::gauss);
  term.rows[0].u[slot::value(0)] = 1.0;
  term.rows[0].u[slot::gradient(0, dim - 1)] = 2.0;
  term.rows[0].u[slot::gradient(dim - 1, 0)] = term.rows[0].u[slot::gradient(dim - 1, 0)] + Expr(x);
  return term;
}

TEST(LawPoints, EvaluatesGradientsInsideTheCells) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh mesh = skew_mesh(dim, 2);
    for (int order = 1; order <= 2; ++order) {
      const Space space = make_space(mesh, order, dim);
      const Expr q = order == 1 ? Expr(0.5) : x;
      const std::array<Expr, 3> all{x * q + Expr(3.0) * y + z, Expr(2.0) * x - y, z - x * q};
      const std::vector<Expr> field(all.begin(), all.begin() + dim);
      const Vector u = interpolate(space, field, 0, Origin{});
      const LawTerm term = gradient_law(dim);
      const LawPoints p = assemble_law(space, all_cells(mesh), term, 0, false);
      EXPECT_NEAR(sum(p.weight), measure_of(mesh, all_cells(mesh)), 1e-13);
      const std::size_t points_of_degree_2[] = {2, 3, 4};
      EXPECT_EQ(p.x.size(), mesh.cells.size() * (order == 1 ? 1 : points_of_degree_2[dim - 1]));
      const Vector found = p.g * u;
      Expr expected = field[0];
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          expected =
              expected + term.rows[0].u[slot::gradient(i, j)] * derivative(field[i], slot::x(j));
      for (std::size_t k = 0; k < p.x.size(); ++k) {
        EXPECT_EQ(p.node[k], -1);
        EXPECT_NEAR(found[static_cast<Eigen::Index>(k)], slow_value(expected, p.x[k], {}, 0.0),
                    1e-12);
      }
    }
  }
}

TEST(LawPoints, StrainsAlongTheCirclesOfRings) {
  Mesh mesh = box_mesh(2, {2, 2, 0});
  mesh.axisymmetric = true;
  const Space space = make_space(mesh, 1, 2);
  LawTerm term = normal_law(0, Rule::gauss);
  term.rows[0].u[slot::hoop] = 1.0;
  const std::vector<Expr> field{Expr(3.0) * x, y};
  const LawPoints p = assemble_law(space, all_cells(mesh), term, 0, false);
  const Vector found = p.g * interpolate(space, field, 0, Origin{});
  for (Eigen::Index k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], 3.0, 1e-13);
}

TEST(LawPoints, FullVectorsAndScaledRowsKeepTheirRank) {
  const Mesh mesh = skew_mesh(3, 1);
  const Space space = make_space(mesh, 1, 3);
  LawTerm term = friction(3);
  for (int c = 0; c < 3; ++c) {
    term.rows[c].u = {};
    term.rows[c].u[c] = Expr(c == 0 ? 1e-4 : 2.0);
  }
  const LawPoints p = assemble_law(space, skin(mesh), term, 0, true);
  EXPECT_EQ(p.rows, 3);
  // Singular values of the rows survive: the frame is orthogonal.
  const DenseMatrix block = DenseMatrix(p.g).block(0, space.dof(p.node[0], 0), 3, 3);
  const Eigen::JacobiSVD<DenseMatrix> svd(block);
  EXPECT_NEAR(svd.singularValues()[0], 2.0, 1e-14);
  EXPECT_NEAR(svd.singularValues()[2], 1e-4, 1e-17);
}

TEST(LawPoints, ZeroRowsOfARadialLawAreAnError) {
  const Mesh mesh = skew_mesh(2, 1);
  const Space space = make_space(mesh, 1, 2);
  LawTerm term = friction(2);
  for (auto& row : term.rows) row.u = {};
  EXPECT_THROW(assemble_law(space, skin(mesh), term, 0, true), Failure);
}

/// A gap on one part of the contact only, asked for by the facet itself and by the cell behind it.
TEST(LawPoints, OffsetsOfParts) {
  const Mesh mesh = box_mesh(2, {4, 4, 0});
  Region left;
  for (const auto c : all_cells(mesh).entities) {
    double middle = 0;
    for (int k = 0; k < 3; ++k) middle += mesh.nodes[mesh.cells[c][k]][0] / 3;
    if (middle < 0.5) left.entities.push_back(c);
  }
  const std::vector<Region> parts{left, group(mesh, "top")};
  const Space space = make_space(mesh, 1, 2, parts);
  LawTerm term = normal_law(2);
  term.rule = Rule::midpoint; // no point is on both sides
  for (const int part : {0, 1}) {
    term.rows[0].offset = Expr::variable(slot::inside(part));
    const LawPoints p = assemble_law(space, skin(mesh), term, 0, false);
    Vector offsets;
    law_offsets(p, term, 0.0, offsets);
    double sum = 0;
    for (std::size_t k = 0; k < p.x.size(); ++k) {
      const bool inside = part == 0 ? p.x[k][0] < 0.5 : p.x[k][1] == 1.0;
      EXPECT_EQ(offsets[Eigen::Index(k)], inside ? 1.0 : 0.0) << p.x[k][0] << " " << p.x[k][1];
      sum += p.weight[k] * offsets[Eigen::Index(k)];
    }
    EXPECT_NEAR(sum, part == 0 ? 2.0 : 1.0, 1e-14);
  }
}

TEST(LawPoints, OffsetsOfScalarAndRadialLaws) {
  const Mesh mesh = skew_mesh(3, 2);
  const Space space = make_space(mesh, 1, 3);
  LawTerm scalar = normal_law(3);
  scalar.rows[0].offset = x * t - Expr(0.25);
  LawPoints p = assemble_law(space, skin(mesh), scalar, 0, false);
  EXPECT_TRUE(p.offset_depends_on_t);
  Vector offsets;
  law_offsets(p, scalar, 2.0, offsets);
  for (std::size_t k = 0; k < p.x.size(); ++k) {
    EXPECT_NEAR(offsets[Eigen::Index(k)], 2 * p.x[k][0] - 0.25, 1e-15);
  }
  // A moving belt: the velocity (t, 0, 0) projected on the tangent plane has no normal part.
  LawTerm belt = friction(3);
  for (int c = 0; c < 3; ++c) belt.rows[c].offset = t * belt.rows[c].u[0];
  p = assemble_law(space, skin(mesh), belt, 0, true);
  law_offsets(p, belt, 3.0, offsets);
  for (std::size_t k = 0; k < p.x.size(); ++k) {
    const double n = p.normal[k][0];
    EXPECT_NEAR(offsets.segment(Eigen::Index(k) * 2, 2).norm(), 3 * std::sqrt(1 - n * n), 1e-13);
  }
  // Not projected, it leaves the range.
  for (int c = 0; c < 3; ++c) belt.rows[c].offset = c == 0 ? t : Expr(0.0);
  p = assemble_law(space, skin(mesh), belt, 0, true);
  EXPECT_THROW(law_offsets(p, belt, 3.0, offsets), Failure);
  law_offsets(p, belt, 0.0, offsets);
  EXPECT_EQ(offsets.norm(), 0);
}

TEST(LawPoints, FactorMustBePositive) {
  const Mesh mesh = box_mesh(2, {2, 2, 0});
  const Space space = make_space(mesh, 1, 2);
  LawTerm term = normal_law(2);
  term.factor = Expr(2.0) + x;
  const LawPoints p = assemble_law(space, group(mesh, "bottom"), term, 0, false);
  EXPECT_NEAR(sum(p.weight), 2.5, 1e-15);
  term.factor = Expr(0.5) - x;
  try {
    assemble_law(space, group(mesh, "bottom"), term, 0, false);
    FAIL();
  } catch (const Failure& f) {
    EXPECT_EQ(f.kind, FailureKind::bad_value);
    EXPECT_EQ(f.origin.id, 9);
    EXPECT_NE(std::string(f.what()).find("`layer` is 0 at (0.5, 0)"), std::string::npos)
        << f.what();
  }
}

TEST(LawPoints, RejectsWrongShapes) {
  const Mesh mesh = box_mesh(2, {1, 1, 0});
  const Space space = make_space(mesh, 1, 2);
  EXPECT_THROW(assemble_law(space, skin(mesh), friction(2), 0, false), Failure);
  LawTerm term = normal_law(2);
  term.rows[0].u[2] = 1.0;
  EXPECT_THROW(assemble_law(space, skin(mesh), term, 0, false), Failure);
  term = normal_law(2);
  term.rows[0].u[0] = sqrt(x - Expr(2.0));
  EXPECT_THROW(assemble_law(space, skin(mesh), term, 0, false), Failure);
}

TEST(LawPoints, MidpointRuleAveragesTheEnds) {
  const Mesh mesh = box_mesh(2, {2, 1, 0});
  const Space space = make_space(mesh, 1, 2);
  const LawPoints p =
      assemble_law(space, group(mesh, "bottom"), normal_law(2, Rule::midpoint), 0, false);
  ASSERT_EQ(p.x.size(), 2u);
  EXPECT_EQ(p.node[0], -1);
  EXPECT_EQ(p.g.nonZeros(), 4);
  EXPECT_NEAR(p.g.coeff(0, space.dof(node_region(mesh, {0, 0, 0}).entities[0], 1)), -0.5, 1e-15);
}

TEST(LawPoints, QuadraticElementsInSpaceUseEdgeMidpoints) {
  const Mesh mesh = box_mesh(3, {2, 2, 2});
  const Space space = make_space(mesh, 2, 3);
  const LawPoints p = assemble_law(space, group(mesh, "bottom"), normal_law(3), 0, false);
  EXPECT_EQ(p.x.size(), 16u); // edges of 8 triangles on 2 x 2 squares
  for (const auto node : p.node) EXPECT_GE(node, static_cast<int>(mesh.nodes.size()));
  EXPECT_NEAR(sum(p.weight), 1, 1e-14);
}

} // namespace
} // namespace hvi::solver
