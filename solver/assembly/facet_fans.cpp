// See facet_fans.hpp.
#include "solver/assembly/facet_fans.hpp"

#include "solver/common/triples.hpp"
#include "solver/fem/element.hpp"
#include "solver/linear/dense.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// Facets at a node whose normals have a smaller cosine have a crease between them.
constexpr double crease = 0.7071;
/// Edges at an end that span a second direction by less than this part see one only.
constexpr double parallel = 0.1;

Point difference(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Point unit(const Point& v) {
  const double length = norm(v);
  return {v[0] / length, v[1] / length, v[2] / length};
}

/// Of a facet's normal at its node `local`, corners first.
double weight_at(const Mesh& mesh, int facet, int local, double measure) {
  if (mesh.dim < 3 || local >= 3) return 1.0 / measure;
  const auto& nodes = mesh.facets[static_cast<std::size_t>(facet)].nodes;
  const auto corner = [&](int k) -> const Point& {
    return mesh.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k % 3)])];
  };
  const Point a = difference(corner(local + 1), corner(local)),
              b = difference(corner(local + 2), corner(local));
  return 2.0 * measure / dot(a, a) / dot(b, b);
}

} // namespace

FacetFans::FacetFans(const Space& space, std::span<const std::int32_t> facets)
    : space_(space), facets_(facets.begin(), facets.end()) {
  const Mesh& mesh = *space.mesh;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    normals_.push_back(facet_normal(mesh, facets[f]));
    measures_.push_back(facet_measure(mesh, facets[f]));
    for (int k = 0; k < std::ssize(space.nodes_of_facet(facets[f])); ++k)
      at_node_[node(static_cast<int>(f), k)].push_back(
          {static_cast<int>(f), weight_at(mesh, facets[f], k, measures_.back())});
  }
  for (int f = 0; f < std::ssize(facets_); ++f)
    for (int k = 0; k < mesh.dim; ++k) {
      const auto fan = about(f, node(f, k));
      const auto [known, fresh] =
          corners_.try_emplace({node(f, k), fan.front()}, mean(fan, node(f, k)));
      corner_of_.push_back(&known->second);
    }
  while (turn_ends()) {
  }
}

/// Corners at ends with edges to known ones, once: those along the whole surface; where there are
/// none, all. Is there more to do?
bool FacetFans::turn_ends() {
  std::vector<std::pair<Corner*, End>> found;
  bool whole = false;
  for (auto& [key, corner] : corners_) {
    if (corner.known) continue;
    if (const auto end = at_end(corner, about(key.second, key.first), key.first)) {
      found.emplace_back(&corner, *end);
      whole = whole || end->whole;
    }
  }
  for (const auto& [corner, end] : found)
    if (end.whole == whole) *corner = {end.normal, true};
  return !found.empty();
}

std::int32_t FacetFans::node(int f, int local) const {
  return space_.nodes_of_facet(
      facets_[static_cast<std::size_t>(f)])[static_cast<std::size_t>(local)];
}

const Point& FacetFans::place(int f, int local) const {
  const auto& facet =
      space_.mesh->facets[static_cast<std::size_t>(facets_[static_cast<std::size_t>(f)])];
  return space_.mesh->nodes[static_cast<std::size_t>(facet.nodes[static_cast<std::size_t>(local)])];
}

const FacetFans::Corner& FacetFans::corner(int f, int local) const {
  return *corner_of_[static_cast<std::size_t>(f * space_.mesh->dim + local)];
}

std::vector<int> FacetFans::about(int f, std::int32_t node) const {
  const auto& here = at_node_.at(node);
  std::vector<int> found{f};
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const auto& [other, weight] : here)
      if (std::ranges::find(found, other) == found.end() &&
          dot(normals_[static_cast<std::size_t>(found[i])],
              normals_[static_cast<std::size_t>(other)]) >= crease)
        found.push_back(other);
  std::ranges::sort(found);
  Point sum{};
  double all = 0.0;
  for (const auto& [other, weight] : here) {
    if (!std::ranges::binary_search(found, other)) continue;
    all += weight;
    for (std::size_t i = 0; i < 3; ++i)
      sum[i] += weight * normals_[static_cast<std::size_t>(other)][i];
  }
  if (norm(sum) < crease * all) return {f};
  return found;
}

FacetFans::Corner FacetFans::mean(const std::vector<int>& fan, std::int32_t node) const {
  Point sum{};
  for (const auto& [f, weight] : at_node_.at(node))
    for (std::size_t i = 0; std::ranges::binary_search(fan, f) && i < 3; ++i)
      sum[i] += weight * normals_[static_cast<std::size_t>(f)][i];
  return {unit(sum), is_closed(fan, node)};
}

/// In 2D two facets, in 3D each edge at the node has one on both of its sides.
bool FacetFans::is_closed(const std::vector<int>& fan, std::int32_t at) const {
  if (space_.mesh->dim < 3) return fan.size() > 1;
  std::map<std::int32_t, int> sides;
  for (const int f : fan)
    for (int k = 0; k < 3; ++k)
      if (node(f, k) != at) ++sides[node(f, k)];
  return std::ranges::all_of(sides, [](const auto& edge) { return edge.second == 2; });
}

std::optional<FacetFans::End> FacetFans::at_end(const Corner& mean, const std::vector<int>& fan,
                                                std::int32_t at) const {
  const Point& m = mean.normal;
  std::vector<Point> along;
  std::vector<double> missing;
  for (const int f : fan) {
    int here = 0;
    while (node(f, here) != at) ++here;
    for (int k = 0; k < space_.mesh->dim; ++k) {
      if (k == here || !corner(f, k).known) continue;
      const Point edge = unit(difference(place(f, k), place(f, here)));
      const double off = dot(edge, m);
      along.push_back({edge[0] - off * m[0], edge[1] - off * m[1], edge[2] - off * m[2]});
      missing.push_back(-off - dot(edge, corner(f, k).normal));
    }
  }
  if (along.empty()) return std::nullopt;
  DenseMatrix rows(std::ssize(along), 3);
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    for (Eigen::Index i = 0; i < 3; ++i)
      rows(r, i) = along[static_cast<std::size_t>(r)][static_cast<std::size_t>(i)];
  const Vector sizes = left_singular(rows.transpose()).values; // the third one is 0
  const bool whole = space_.mesh->dim < 3 || (sizes.size() > 1 && sizes[1] > parallel * sizes[0]);
  const DenseMatrix turn =
      least_squares(rows, Eigen::Map<const Vector>(missing.data(), rows.rows()), parallel);
  return End{unit({m[0] + turn(0, 0), m[1] + turn(1, 0), m[2] + turn(2, 0)}), whole};
}

Point FacetFans::normal_at(int f, int local) const {
  const int dim = space_.mesh->dim;
  if (local < dim) return corner(f, local).normal;
  const auto [a, b] = simplex_edges(dim - 1)[static_cast<std::size_t>(local - dim)];
  const Point &first = corner(f, a).normal, &second = corner(f, b).normal;
  return unit({first[0] + second[0], first[1] + second[1], first[2] + second[2]});
}

} // namespace hvi::solver
