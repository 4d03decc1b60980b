// Pairs: two sides whose meshes do not match. Patch tests of the rows, gaps, partners.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/pairing.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/pieces.hpp"
#include "tests/solver/assembly/reference.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace hvi::solver {
namespace {

using Matrix3 = Eigen::Matrix3d;

struct Case {
  int dim, order;
  bool upper_first;
};

class Pairs : public testing::TestWithParam<Case> {
protected:
  /// [0.1, 0.1 + width] x [1 + gap, 2] x .. on [0, 1]^dim, turned.
  void make(double width, double gap, unsigned seed) {
    const auto& [dim, order, upper_first] = GetParam();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(-3.0, 3.0);
    const auto lines = [&](double low, double high, int cells) {
      return uniform_coordinates(low, high, cells);
    };
    const double start = width < 1.0 ? 0.1 : 0.0;
    std::vector<Mesh> meshes{
        structured_mesh(dim, {lines(start, start + width, 3), lines(1.0 + gap, 2.0, 1),
                              dim == 3 ? lines(0.0, 1.0, 2) : std::vector<double>{}}),
        structured_mesh(dim, {lines(0.0, 1.0, 5), lines(0.0, 1.0, 2),
                              dim == 3 ? lines(0.0, 1.0, 3) : std::vector<double>{}})};
    turn_ = Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    if (dim == 3)
      turn_ = turn_ * Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitX()).toRotationMatrix();
    for (Mesh& mesh : meshes)
      for (Point& x : mesh.nodes) {
        const Eigen::Vector3d y = turn_ * Eigen::Vector3d(x[0], x[1], x[2]);
        x = {y[0], y[1], y[2]};
      }
    const std::vector<std::string> names{"upper", "lower"};
    mesh_ = side_by_side(meshes, names);
    space_ = make_space(mesh_, order, dim);
    upper_ = facets("upper.bottom"), lower_ = facets("lower.top");
    region_ = {Group::Kind::facets, upper_first ? upper_ : lower_, 0, upper_first ? lower_ : upper_,
               0.0};
  }
  std::vector<std::int32_t> facets(const std::string& name) const {
    return mesh_.groups.at(name).entities;
  }
  /// int phi_j over facets.
  Vector integrals(const std::vector<std::int32_t>& facets_of_side) const {
    Vector out = Vector::Zero(static_cast<Eigen::Index>(space_.nodes.size()));
    const int dim = mesh_.dim - 1;
    const Quadrature rule = simplex_rule(dim, space_.order);
    std::array<double, max_cell_nodes> values{};
    for (const auto f : facets_of_side) {
      const auto nodes = space_.nodes_of_facet(f);
      for (std::size_t q = 0; q < rule.size(); ++q) {
        lagrange_values(dim, space_.order, rule.points[q], values.data());
        for (std::size_t k = 0; k < nodes.size(); ++k)
          out[nodes[k]] += rule.weights[q] * facet_measure(mesh_, f) * values[k];
      }
    }
    return out;
  }
  Vector weights(const Pairing& pairing) const {
    return Eigen::Map<const Vector>(pairing.weight.data(),
                                    static_cast<Eigen::Index>(pairing.weight.size()));
  }

  Mesh mesh_;
  Space space_;
  Region region_;
  std::vector<std::int32_t> upper_, lower_;
  Matrix3 turn_;
};

SparseMatrix jumps_of(const Pairing& pairing) {
  return pairing.jump.topRows(static_cast<Eigen::Index>(pairing.x.size()));
}
SparseMatrix means_of(const Pairing& pairing) {
  return pairing.jump.bottomRows(static_cast<Eigen::Index>(pairing.x.size()));
}

/// Linear fields are continuous, and a constant pressure is that of each side's own loads. What
/// acts on means is half of it on either side.
TEST_P(Pairs, PassThePatchTest) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    make(1.0, 0.0, seed);
    const Pairing pairing = make_pairing(space_, region_, space_.order);
    EXPECT_EQ(pairing.alone, 0);
    Vector linear(static_cast<Eigen::Index>(space_.nodes.size()));
    for (std::size_t i = 0; i < space_.nodes.size(); ++i) {
      const Point& x = space_.nodes[i];
      linear[static_cast<Eigen::Index>(i)] = 1.0 + 2.0 * x[0] - 3.0 * x[1] + 0.7 * x[2];
    }
    EXPECT_LT((jumps_of(pairing) * linear).cwiseAbs().maxCoeff(), 1e-13);
    const Vector force = jumps_of(pairing).transpose() * weights(pairing);
    const Vector expected = integrals(region_.entities) - integrals(region_.second);
    EXPECT_LT((force - expected).cwiseAbs().maxCoeff(), 1e-13);
    const Vector shared = means_of(pairing).transpose() * weights(pairing);
    const Vector halves = 0.5 * (integrals(region_.entities) + integrals(region_.second));
    EXPECT_LT((shared - halves).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(weights(pairing).sum(), 1.0, 1e-13);
    for (const double gap : pairing.gap) EXPECT_NEAR(gap, 0.0, 1e-13);
  }
}

/// Point i sees of its own side node i only: biorthogonality.
TEST_P(Pairs, SeeTheirOwnNode) {
  if (GetParam().dim == 3 && GetParam().order == 2) return; // points at corners: hats
  make(1.0, 0.0, 3);
  const Pairing pairing = make_pairing(space_, region_, space_.order);
  const auto own = nodes_on(space_, {Group::Kind::facets, region_.entities, 0});
  EXPECT_EQ(pairing.x.size(), own.size());
  for (int p = 0; p < static_cast<int>(pairing.x.size()); ++p) {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator it(pairing.jump, p); it; ++it) {
      sum += it.value();
      if (!std::ranges::binary_search(own, static_cast<std::int32_t>(it.col()))) continue;
      const bool itself = it.col() == pairing.node[static_cast<std::size_t>(p)];
      EXPECT_NEAR(it.value(), itself ? 1.0 : 0.0, 1e-14);
    }
    EXPECT_NEAR(sum, 0.0, 1e-13); // the rest is an average of the other side
  }
}

/// Where only a part of the first side has partners, that part carries the integral.
TEST_P(Pairs, IntegrateOverWhatTheyShare) {
  make(0.57, 0.25, 5);
  const Pairing pairing = make_pairing(space_, region_, space_.order);
  EXPECT_NEAR(weights(pairing).sum(), 0.57, 1e-13);
  const Vector force = jumps_of(pairing).transpose() * weights(pairing);
  const auto narrow = integrals(upper_);
  const double sign = GetParam().upper_first ? 1.0 : -1.0;
  for (const auto n : nodes_on(space_, {Group::Kind::facets, upper_, 0}))
    EXPECT_NEAR(force[n], sign * narrow[n], 1e-13);
  for (std::size_t p = 0; p < pairing.gap.size(); ++p) EXPECT_NEAR(pairing.gap[p], 0.25, 1e-13);
  const double up = GetParam().upper_first ? -1.0 : 1.0; // out of the first side
  for (const Point& n : pairing.normal)
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(n[static_cast<std::size_t>(a)], up * turn_(a, 1), 1e-14);
  EXPECT_EQ(pairing.alone > 0, !GetParam().upper_first);
  region_.reach = 0.2;
  EXPECT_THROW(make_pairing(space_, region_, space_.order), Failure);
  region_.second = region_.entities;
  EXPECT_THROW(make_pairing(space_, region_, space_.order), Failure);
}

INSTANTIATE_TEST_SUITE_P(All, Pairs,
                         testing::Values(Case{2, 1, true}, Case{2, 1, false}, Case{2, 2, true},
                                         Case{2, 2, false}, Case{3, 1, true}, Case{3, 1, false},
                                         Case{3, 2, true}, Case{3, 2, false}));

/// Two rings [0, R] that lie on each other, or a disc on a longer one, whichever side is the first:
/// weights of points are areas of rings, all positive, that of the axis among them, and constant
/// pressures and linear fields are exact.
TEST(PairsOfRings, HaveTheAreasOfTheirFacets) {
  constexpr double pi = 3.14159265358979323846;
  for (const int order : {1, 2})
    for (const bool upper_first : {true, false})
      for (const double radius : {1.0, 0.7}) { // of the upper one
        SCOPED_TRACE(fmt::format("order {}, upper {}, radius {}", order, upper_first, radius));
        const std::vector<Mesh> meshes{
            structured_mesh(2, {uniform_coordinates(0.0, radius, 3), {1.0, 2.0}, {}}),
            structured_mesh(2, {uniform_coordinates(0.0, 1.0, 4), {0.0, 1.0}, {}})};
        Mesh mesh = side_by_side(meshes, std::vector<std::string>{"upper", "lower"});
        mesh.axisymmetric = true;
        const Space space = make_space(mesh, order, 2);
        const auto facets = [&](const char* name) { return mesh.groups.at(name).entities; };
        const auto upper = facets("upper.bottom"), lower = facets("lower.top");
        const Region region{Group::Kind::facets, upper_first ? upper : lower, 0,
                            upper_first ? lower : upper, 0.0};
        const Pairing pairing = make_pairing(space, region, order);
        double area = 0.0, moment = 0.0;
        bool at_axis = false;
        Vector radial(static_cast<Eigen::Index>(space.nodes.size()));
        for (std::size_t i = 0; i < space.nodes.size(); ++i)
          radial[static_cast<Eigen::Index>(i)] = 3.0 + 2.0 * space.nodes[i][0];
        const Vector jump = jumps_of(pairing) * radial;
        for (std::size_t p = 0; p < pairing.x.size(); ++p) {
          EXPECT_GT(pairing.weight[p], 0.0);
          area += pairing.weight[p];
          at_axis = at_axis || pairing.x[p][0] == 0.0;
          EXPECT_NEAR(jump[static_cast<Eigen::Index>(p)], 0.0, 1e-13);
        }
        const Vector force =
            jumps_of(pairing).transpose() *
            Eigen::Map<const Vector>(pairing.weight.data(),
                                     static_cast<Eigen::Index>(pairing.weight.size()));
        // On the first side a constant pressure does the work int 2 pi r r dr on the field r.
        for (const auto i : nodes_on(space, {Group::Kind::facets, region.entities, 0}))
          moment += force[i] * space.nodes[static_cast<std::size_t>(i)][0];
        EXPECT_NEAR(area, pi * radius * radius, 1e-12);
        EXPECT_NEAR(moment, 2.0 * pi / 3.0 * std::pow(radius, 3), 1e-12);
        EXPECT_TRUE(at_axis);
      }
}

/// Two layers behind each other.
TEST(PairsOfSides, LieOverEachOtherOnce) {
  const auto lines = [](double low, double high) { return uniform_coordinates(low, high, 2); };
  const std::vector<Mesh> meshes{structured_mesh(2, {lines(0, 1), lines(1, 2)}),
                                 structured_mesh(2, {lines(0, 1), lines(0, 1)}),
                                 structured_mesh(2, {lines(0, 1), lines(-0.5, -0.2)})};
  const std::vector<std::string> names{"a", "b", "c"};
  const Mesh mesh = side_by_side(meshes, names);
  const Space space = make_space(mesh, 1, 2);
  Region region{Group::Kind::facets, mesh.groups.at("a.bottom").entities, 0,
                mesh.groups.at("b.top").entities, 3.0};
  EXPECT_EQ(make_pairing(space, region, space.order).alone, 0);
  const auto& under = mesh.groups.at("c.top").entities;
  region.second.insert(region.second.end(), under.begin(), under.end());
  EXPECT_THROW(make_pairing(space, region, space.order), Failure);
  region.reach = 0.5;
  EXPECT_EQ(make_pairing(space, region, space.order).x.size(), 3u);
}

/// Two layers over one small part of a facet, which are less than the facet together.
TEST(PairsOfSides, LieOnceOverPartsOfFacets) {
  for (const int dim : {2, 3}) {
    const auto box = [&](double left, double right, double low, double high) {
      return structured_mesh(
          dim, {uniform_coordinates(left, right, 1), uniform_coordinates(low, high, 1),
                dim == 3 ? uniform_coordinates(0.1, 0.5, 1) : std::vector<double>{}});
    };
    for (const double left : {0.3, 0.7}) { // over each other, and side by side
      const std::vector<Mesh> meshes{box(0, 2, 1, 2), box(0.2, 0.7, 0.5, 1), box(left, 1, -1, 0)};
      const std::vector<std::string> names{"a", "b", "c"};
      const Mesh mesh = side_by_side(meshes, names);
      const Space space = make_space(mesh, 1, dim);
      Region region{Group::Kind::facets, mesh.groups.at("a.bottom").entities, 0,
                    mesh.groups.at("b.top").entities, 3.0};
      const auto& under = mesh.groups.at("c.top").entities;
      region.second.insert(region.second.end(), under.begin(), under.end());
      if (left < 0.7) {
        EXPECT_THROW(make_pairing(space, region, space.order), Failure) << dim;
        continue;
      }
      const Pairing pairing = make_pairing(space, region, space.order);
      const double sum = std::accumulate(pairing.weight.begin(), pairing.weight.end(), 0.0);
      EXPECT_NEAR(sum, dim == 3 ? 0.8 * 0.4 : 0.8, 1e-13);
    }
  }
}

/// The whole boundaries of two flat bodies, apart or pressed in: the far sides of both face each
/// other, too, but for the bodies between them.
TEST(PairsOfSides, DoNotMeetThroughBodies) {
  for (const int dim : {2, 3})
    for (const double gap : {0.01, 0.0, -0.01}) {
      const auto depth = dim == 3 ? uniform_coordinates(0, 2, 2) : std::vector<double>{};
      const std::vector<Mesh> meshes{
          structured_mesh(
              dim, {uniform_coordinates(0.4, 1.6, 3), uniform_coordinates(0, 0.2, 2), depth}),
          structured_mesh(dim, {uniform_coordinates(0, 2, 5),
                                uniform_coordinates(-0.3 - gap, -gap, 1), depth})};
      const std::vector<std::string> names{"block", "plate"};
      const Mesh mesh = side_by_side(meshes, names);
      const Space space = make_space(mesh, 1, dim);
      const auto pairing = [&](const char* first, const char* second) {
        return make_pairing(space,
                            {Group::Kind::facets, mesh.groups.at(first).entities, 0,
                             mesh.groups.at(second).entities, 5.0},
                            space.order);
      };
      const Pairing all = pairing("block.boundary", "plate.boundary");
      const Pairing sides = pairing("block.bottom", "plate.top");
      ASSERT_EQ(all.x.size(), sides.x.size());
      for (std::size_t p = 0; p < all.x.size(); ++p) EXPECT_NEAR(all.gap[p], gap, 1e-14);
      EXPECT_NEAR(std::accumulate(all.weight.begin(), all.weight.end(), 0.0),
                  std::accumulate(sides.weight.begin(), sides.weight.end(), 0.0), 1e-13);
      EXPECT_EQ(pairing("plate.boundary", "block.boundary").x.size(),
                pairing("plate.top", "block.bottom").x.size());
      EXPECT_THROW(pairing("block.bottom", "block.top"), Failure);
    }
}

/// A corner is a point of each of its sides, with the normal of that side.
TEST(PairsOfSides, KeepNormalsAtCreases) {
  const auto lines = [](double low, double high) { return uniform_coordinates(low, high, 2); };
  const std::vector<Mesh> meshes{structured_mesh(2, {lines(0, 1), lines(0, 1)}),
                                 structured_mesh(2, {lines(-1, 0), lines(-1, 2)}),
                                 structured_mesh(2, {lines(0, 2), lines(-1, 0)})};
  const std::vector<std::string> names{"body", "wall", "floor"};
  const Mesh mesh = side_by_side(meshes, names);
  const Space space = make_space(mesh, 1, 2);
  const auto both = [&](const char* a, const char* b) {
    auto out = mesh.groups.at(a).entities;
    const auto& more = mesh.groups.at(b).entities;
    out.insert(out.end(), more.begin(), more.end());
    std::ranges::sort(out);
    return out;
  };
  const Region region{Group::Kind::facets, both("body.left", "body.bottom"), 0,
                      both("wall.right", "floor.top"), 0.0};
  const Pairing pairing = make_pairing(space, region, space.order);
  EXPECT_EQ(pairing.x.size(), 6u);
  for (std::size_t p = 0; p < 6; ++p) {
    const double largest = std::max(std::abs(pairing.normal[p][0]), std::abs(pairing.normal[p][1]));
    EXPECT_NEAR(largest, 1.0, 1e-14);
    EXPECT_NEAR(pairing.gap[p], 0.0, 1e-14);
  }
}

/// Sides at 60 degrees to each other, which go through each other where x < 0.2/slope: gaps are the
/// distances along the normal of the first side, negative there, and linear fields jump by them. A
/// facet has partners where its middle is within reach, not its nearest corner.
TEST(PairsOfSides, MayBeSlanted) {
  const double slope = std::sqrt(3.0);
  for (const int dim : {2, 3}) {
    const auto depth = dim == 3 ? uniform_coordinates(0, 1, 2) : std::vector<double>{};
    std::vector<Mesh> meshes{
        structured_mesh(dim, {uniform_coordinates(0, 1, 4), uniform_coordinates(0, 1, 1), depth}),
        structured_mesh(dim, {uniform_coordinates(0, 1, 4), uniform_coordinates(-4, 0, 1), depth})};
    for (Point& x : meshes[1].nodes) x[1] += (0.2 - slope * x[0]) * (1.0 + x[1] / 4.0);
    const std::vector<std::string> names{"flat", "slanted"};
    const Mesh mesh = side_by_side(meshes, names);
    const Space space = make_space(mesh, 1, dim);
    Region region{Group::Kind::facets, mesh.groups.at("flat.bottom").entities, 0,
                  mesh.groups.at("slanted.top").entities, 3.0};
    const Pairing pairing = make_pairing(space, region, space.order);
    Vector height(static_cast<Eigen::Index>(space.nodes.size()));
    for (std::size_t i = 0; i < space.nodes.size(); ++i)
      height[static_cast<Eigen::Index>(i)] = space.nodes[i][1];
    const Vector jumps = jumps_of(pairing) * height;
    EXPECT_EQ(pairing.alone, 0);
    for (std::size_t p = 0; p < pairing.x.size(); ++p) {
      const double apart = slope * pairing.x[p][0] - 0.2;
      EXPECT_NEAR(pairing.gap[p], apart, 1e-13);
      EXPECT_NEAR(jumps[static_cast<Eigen::Index>(p)], apart, 1e-13);
    }
    if (dim == 3) continue; // pieces are triangles
    region.reach = 1.2;     // from the last facet: 1.1 to 1.53
    const Pairing near = make_pairing(space, region, space.order);
    EXPECT_NEAR(std::accumulate(near.weight.begin(), near.weight.end(), 0.0), 0.75, 1e-14);
  }
}

/// A facet of which a tiny part in the middle has a partner: rows stay bounded.
TEST(PairsOfSides, AreBoundedOnSmallParts) {
  for (const double size : {1e-1, 1e-3, 1e-6}) {
    const std::vector<Mesh> meshes{
        structured_mesh(2, {uniform_coordinates(0, 1, 1), uniform_coordinates(1, 2, 1)}),
        structured_mesh(2,
                        {uniform_coordinates(0.4, 0.4 + size, 3), uniform_coordinates(0, 1, 1)})};
    const std::vector<std::string> names{"wide", "narrow"};
    const Mesh mesh = side_by_side(meshes, names);
    const Space space = make_space(mesh, 1, 2);
    const Region region{Group::Kind::facets, mesh.groups.at("wide.bottom").entities, 0,
                        mesh.groups.at("narrow.top").entities, 0.0};
    const Pairing pairing = make_pairing(space, region, space.order);
    double sum = 0.0, largest = 0.0;
    for (const double w : pairing.weight) sum += w;
    for (int e = 0; e < pairing.jump.nonZeros(); ++e)
      largest = std::max(largest, std::abs(pairing.jump.valuePtr()[e]));
    EXPECT_NEAR(sum, size, 1e-15);
    EXPECT_LT(largest, 40.0);
  }
}

} // namespace
} // namespace hvi::solver
