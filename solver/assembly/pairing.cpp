// See pairing.hpp.
#include "solver/assembly/pairing.hpp"

#include "solver/assembly/facet_fans.hpp"
#include "solver/assembly/segments.hpp"
#include "solver/common/triples.hpp"
#include "solver/fem/geometry.hpp"
#include "solver/linear/dense.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

namespace hvi::solver {
namespace {

/// Dual functions whose root mean square is beyond this are replaced by the q_i themselves (facets
/// of which small parts in the middle meet the second side).
constexpr double largest_dual = 14.0;
/// Entries of a row that are rounding: where nodes of both sides match, and at the tip of a crack.
constexpr double rounding = 1e-14;
constexpr double whole = 1e-9; ///< a facet that has partners but for this share has them all

/// The points of the first side: its nodes, those on creases several times.
class FirstSide {
public:
  FirstSide(const Space& space, std::span<const std::int32_t> facets)
      : space_(space), facets_(facets), fans_(space, facets) {
    point_of_.resize(facets.size());
    for (std::size_t f = 0; f < facets.size(); ++f)
      for (int k = 0; k < std::ssize(space.nodes_of_facet(facets[f])); ++k)
        point_of_[f].push_back(point(static_cast<int>(f), k));
  }

  int size() const { return static_cast<int>(node.size()); }
  int point_of(std::size_t f, std::size_t local) const { return point_of_[f][local]; }
  double measure(std::size_t f) const { return fans_.measure(f); }
  /// The averaged normal in the middle of a facet.
  Point direction(std::size_t f) const {
    Point sum{};
    for (int k = 0; k < space_.mesh->dim; ++k)
      add(sum, 1.0, normal[static_cast<std::size_t>(point_of_[f][static_cast<std::size_t>(k)])]);
    return unit(sum);
  }
  /// About the normal of the side; if it has none, any.
  Point up() const {
    Point sum{};
    double all = 0.0;
    for (std::size_t f = 0; f < fans_.size(); ++f)
      add(sum, fans_.measure(f), fans_.normal(f)), all += fans_.measure(f);
    return norm(sum) > 0.1 * all ? unit(sum) : fans_.normal(0);
  }

  std::vector<std::int32_t> node, facet;
  std::vector<Point> normal;

private:
  static void add(Point& to, double factor, const Point& v) {
    for (std::size_t i = 0; i < 3; ++i) to[i] += factor * v[i];
  }
  static Point unit(const Point& v) {
    const double length = norm(v);
    return {v[0] / length, v[1] / length, v[2] / length};
  }

  int point(int f, int local) {
    const std::int32_t at = space_.nodes_of_facet(
        facets_[static_cast<std::size_t>(f)])[static_cast<std::size_t>(local)];
    const auto fan = fans_.about(f, at);
    const auto [known, fresh] = known_.try_emplace(std::pair(at, fan.front()), size());
    if (!fresh) return known->second;
    node.push_back(at);
    facet.push_back(facets_[static_cast<std::size_t>(fan.front())]);
    normal.push_back(fans_.normal_at(f, local));
    return size() - 1;
  }

  const Space& space_;
  std::span<const std::int32_t> facets_;
  FacetFans fans_;
  std::map<std::pair<std::int32_t, int>, int> known_; ///< node and first facet of the fan
  std::vector<std::vector<int>> point_of_;            ///< by facet and local node
};

/// One facet of the first side: the q_k and the psi_i that they span.
struct LocalDuals {
  int order = 1;            ///< of the q_k: 1: hats of the corners
  bool biorthogonal = true; ///< else psi_i = q_i
  Vector weights;           ///< int q_i, in shares of the facet
  DenseMatrix spanned;      ///< psi_i = sum_k spanned(i, k) q_k
};

/// Values of the q_k at the meetings, meetings x size.
DenseMatrix values_at(int dim, int order, const std::vector<Meeting>& meetings, bool first) {
  const int size = lagrange_size(dim, order);
  DenseMatrix out(static_cast<Eigen::Index>(meetings.size()), size);
  std::array<double, max_cell_nodes> values{};
  for (std::size_t m = 0; m < meetings.size(); ++m) {
    lagrange_values(dim, order, first ? meetings[m].first : meetings[m].second, values.data());
    for (int k = 0; k < size; ++k)
      out(static_cast<Eigen::Index>(m), k) = values[static_cast<std::size_t>(k)];
  }
  return out;
}

Vector weights_of(const std::vector<Meeting>& meetings) {
  Vector out(static_cast<Eigen::Index>(meetings.size()));
  for (std::size_t m = 0; m < meetings.size(); ++m)
    out[static_cast<Eigen::Index>(m)] = meetings[m].weight;
  return out;
}

LocalDuals make_duals(int dim, int order, const std::vector<Meeting>& meetings) {
  LocalDuals out;
  out.order = order;
  const DenseMatrix q = values_at(dim, order, meetings, true);
  const Vector w = weights_of(meetings);
  out.weights = q.transpose() * w;
  out.spanned = DenseMatrix::Identity(q.cols(), q.cols());
  const DenseMatrix mass = q.transpose() * w.asDiagonal() * q;
  const Vector scale = mass.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) {
    out.biorthogonal = false;
    return out;
  }
  const Vector down = scale.cwiseInverse();
  const DenseMatrix scaled = down.asDiagonal() * mass * down.asDiagonal();
  const DenseMatrix inverse = solve_positive(scaled, DenseMatrix::Identity(q.cols(), q.cols()));
  const DenseMatrix duals =
      out.weights.cwiseProduct(down).asDiagonal() * inverse * down.asDiagonal();
  // int psi_i^2 = duals(i, i) int q_i: integrals do not depend on how the common part is cut up.
  const Vector mean_squares = duals.diagonal().cwiseProduct(out.weights) / w.sum();
  out.biorthogonal = mean_squares.minCoeff() > 0.0 && mean_squares.allFinite() &&
                     mean_squares.maxCoeff() <= largest_dual * largest_dual;
  if (out.biorthogonal) out.spanned = duals;
  return out;
}

/// Adds up facet by facet.
class Mortar {
public:
  Mortar(const Space& space, const Region& region, int order)
      : space_(space), mesh_(*space.mesh), region_(region), order_(order),
        first_(space, region.entities),
        second_(mesh_, region.second, first_.up(), reach_of(region)),
        rule_(simplex_rule(mesh_.dim - 1, 2 * space.order + (mesh_.axisymmetric ? 1 : 0))),
        weight_(static_cast<std::size_t>(first_.size()), 0.0),
        between_(static_cast<std::size_t>(first_.size())),
        met_(static_cast<std::size_t>(first_.size()), false) {}

  Pairing take() {
    for (std::size_t f = 0; f < region_.entities.size(); ++f) add_facet(f);
    Pairing out;
    std::vector<Eigen::Triplet<double>> entries, of_means;
    for (std::size_t i = 0; i < weight_.size(); ++i) {
      if (!(weight_[i] > 0.0)) {
        if (!met_[i] && out.alone++ == 0) out.first_alone = place(i);
        continue;
      }
      const auto row = static_cast<int>(out.x.size());
      for (const auto& [node, value] : between_[i].jump)
        if (std::abs(value) > rounding * weight_[i])
          entries.emplace_back(row, node, value / weight_[i]);
      for (const auto& [node, value] : between_[i].mean)
        if (std::abs(value) > rounding * weight_[i])
          of_means.emplace_back(row, node, value / weight_[i]);
      keep(i, out);
    }
    if (out.x.empty()) throw nobody(out);
    const auto n = static_cast<int>(out.x.size());
    for (const auto& e : of_means) entries.emplace_back(n + e.row(), e.col(), e.value());
    out.jump.resize(2 * n, static_cast<Eigen::Index>(space_.nodes.size()));
    out.jump.setFromTriplets(entries.begin(), entries.end());
    return out;
  }

private:
  struct Between {
    std::map<std::int32_t, double> jump, mean;
    Point gap{};
    void add_first(std::int32_t node, double value) {
      jump[node] += value;
      mean[node] += 0.5 * value;
    }
    void add_second(std::int32_t node, double value) {
      jump[node] -= value;
      mean[node] += 0.5 * value;
    }
  };

  double reach_of(const Region& region) const {
    if (region.reach > 0.0) return region.reach;
    Box box{mesh_.nodes[0], mesh_.nodes[0]};
    bool any = false;
    for (const auto f : region.entities)
      for (int k = 0; k < mesh_.dim; ++k) {
        const Point& p = mesh_.nodes[static_cast<std::size_t>(
            mesh_.facets[static_cast<std::size_t>(f)].nodes[static_cast<std::size_t>(k)])];
        if (!any) box = {p, p};
        include(box, {p, p});
        any = true;
      }
    return box.diagonal();
  }

  Point place(std::size_t i) const {
    return space_.nodes[static_cast<std::size_t>(first_.node[i])];
  }

  void keep(std::size_t i, Pairing& out) const {
    out.x.push_back(place(i));
    out.normal.push_back(first_.normal[i]);
    out.weight.push_back(weight_[i]);
    out.gap.push_back(dot(first_.normal[i], between_[i].gap) / weight_[i]);
    out.node.push_back(first_.node[i]);
    out.facet.push_back(first_.facet[i]);
    out.cell.push_back(mesh_.facets[static_cast<std::size_t>(first_.facet[i])].cell);
  }

  void add_facet(std::size_t f) {
    const int facet = region_.entities[f];
    const Point direction = first_.direction(f);
    auto [meetings, shared_by_layers] = second_.meet(facet, direction, rule_);
    if (meetings.empty()) return;
    if (shared_by_layers > 1e-6) throw twice(f);
    const double covered =
        std::accumulate(meetings.begin(), meetings.end(), 0.0,
                        [](double sum, const Meeting& m) { return sum + m.weight; });
    // On triangles, and on parts of intervals, the corners' shape functions of order 2 are not
    // positive on average.
    const bool all = covered > 1.0 - whole;
    const bool at_axis = revolve(facet, meetings);
    const int order = mesh_.dim == 2 && all && !at_axis ? order_ : 1;
    const LocalDuals duals = make_duals(mesh_.dim - 1, order, meetings);
    for (std::size_t k = 0; k < space_.nodes_of_facet(facet).size(); ++k)
      met_[static_cast<std::size_t>(first_.point_of(f, k))] = true;
    add(f, direction, duals, meetings);
  }

  /// On axisymmetric meshes the weights carry 2 pi x. Does the facet reach the axis? The function
  /// of order 2 of its end there is 0 on average.
  bool revolve(int facet, std::vector<Meeting>& meetings) const {
    if (!mesh_.axisymmetric) return false;
    const auto& nodes = mesh_.facets[static_cast<std::size_t>(facet)].nodes;
    const double a = mesh_.nodes[static_cast<std::size_t>(nodes[0])][0],
                 b = mesh_.nodes[static_cast<std::size_t>(nodes[1])][0];
    for (Meeting& m : meetings) m.weight *= circumference(mesh_, m.first[0] * a + m.first[1] * b);
    return a == 0.0 || b == 0.0;
  }

  void add(std::size_t f, const Point& direction, const LocalDuals& duals,
           const std::vector<Meeting>& meetings) {
    const int facet = region_.entities[f];
    const int dim = mesh_.dim - 1;
    const double measure = first_.measure(f);
    const DenseMatrix psi = values_at(dim, duals.order, meetings, true) * duals.spanned.transpose();
    const DenseMatrix own = values_at(dim, space_.order, meetings, true);
    const DenseMatrix its = values_at(dim, space_.order, meetings, false);
    const DenseMatrix weighted = (measure * weights_of(meetings)).asDiagonal() * psi;
    const auto own_nodes = space_.nodes_of_facet(facet);
    const bool diagonal = duals.biorthogonal && duals.order == space_.order;
    const DenseMatrix with_own = weighted.transpose() * own;
    for (Eigen::Index i = 0; i < psi.cols(); ++i) {
      const auto point = static_cast<std::size_t>(first_.point_of(f, static_cast<std::size_t>(i)));
      weight_[point] += measure * duals.weights[i];
      Between& here = between_[point];
      if (diagonal)
        here.add_first(own_nodes[static_cast<std::size_t>(i)], measure * duals.weights[i]);
      for (Eigen::Index j = 0; !diagonal && j < with_own.cols(); ++j)
        here.add_first(own_nodes[static_cast<std::size_t>(j)], with_own(i, j));
      for (std::size_t m = 0; m < meetings.size(); ++m) {
        const double w = weighted(static_cast<Eigen::Index>(m), i);
        const auto nodes =
            space_.nodes_of_facet(region_.second[static_cast<std::size_t>(meetings[m].facet)]);
        for (std::size_t k = 0; k < nodes.size(); ++k)
          here.add_second(nodes[k],
                          w * its(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(k)));
        for (std::size_t a = 0; a < 3; ++a) here.gap[a] += w * meetings[m].distance * direction[a];
      }
    }
  }

  Failure nobody(const Pairing& out) const {
    return Failure(FailureKind::bad_value, {},
                   fmt::format("no point of the first side of the pair has a partner on the second "
                               "one: {} points, the first one at {}",
                               out.alone, describe_point(out.first_alone, mesh_.dim)),
                   "points are matched along the normal of the first side, with facets that face "
                   "it no farther away than `reach`: `pair(a, b, reach = 0.1)`");
  }
  Failure twice(std::size_t f) const {
    Point middle{};
    const auto& nodes = mesh_.facets[static_cast<std::size_t>(region_.entities[f])].nodes;
    for (int k = 0; k < mesh_.dim; ++k)
      for (std::size_t a = 0; a < 3; ++a)
        middle[a] += mesh_.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)])][a] /
                     mesh_.dim;
    return Failure(FailureKind::bad_value, {},
                   fmt::format("the second side of the pair lies twice over the first one, at {}",
                               describe_point(middle, mesh_.dim)),
                   "leave out what is not meant, or give a smaller `reach`");
  }

  const Space& space_;
  const Mesh& mesh_;
  const Region& region_;
  const int order_; ///< of the q_i, where these are positive on average
  FirstSide first_;
  SecondSide second_;
  Quadrature rule_;
  std::vector<double> weight_;
  std::vector<Between> between_;
  std::vector<bool> met_; ///< a facet of the point has partners
};

void check_sides(const Mesh& mesh, const Region& region) {
  std::vector<std::int32_t> shared;
  std::ranges::set_intersection(region.entities, region.second, std::back_inserter(shared));
  if (shared.empty() && mesh.dim > 1) return;
  throw Failure(FailureKind::bad_value, {},
                mesh.dim == 1 ? std::string("a pair is of two sides in 2D or 3D")
                              : fmt::format("the sides of the pair have {} facet{} in common",
                                            shared.size(), shared.size() == 1 ? "" : "s"));
}

} // namespace

Pairing make_pairing(const Space& space, const Region& region, int order) {
  check_sides(*space.mesh, region);
  return Mortar(space, region, order).take();
}

} // namespace hvi::solver
