// See mesh_tags.hpp.
#include "lang/mesh_tags.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

namespace hvi::lang {

namespace {

using Kind = solver::Group::Kind;

solver::Point middle_of(const solver::Mesh& mesh, std::span<const std::int32_t> nodes) {
  solver::Point out{};
  for (const auto n : nodes)
    for (std::size_t a = 0; a < 3; ++a)
      out[a] += mesh.nodes[static_cast<std::size_t>(n)][a] / static_cast<double>(nodes.size());
  return out;
}

std::span<const std::int32_t> nodes_of(const solver::Mesh& mesh, Kind kind, const std::int32_t& e) {
  const auto i = static_cast<std::size_t>(e);
  const auto dim = static_cast<std::size_t>(mesh.dim);
  if (kind == Kind::cells) return std::span(mesh.cells[i]).first(dim + 1);
  if (kind == Kind::facets) return std::span(mesh.facets[i].nodes).first(dim);
  return {&e, 1};
}

double distance(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

/// Chooses the places of names, one part after the other.
class Tags {
public:
  Tags(const solver::Discretisation& d, const MeshSight& sight, const draw::Plane& plane)
      : d_(d), mesh_(d.mesh), sight_(sight), pixels_(plane.width / (plane.x_high - plane.x_low)),
        box_(view_box(d.mesh)) {
    for (const solver::Region& region : d.parts)
      if (region.kind == Kind::facets)
        for (const auto* side : {&region.entities, &region.second})
          sides_.insert(side->begin(), side->end());
  }

  std::optional<Tag> of_part(std::size_t part, const std::string& name,
                             std::span<const std::optional<Tag>> others) const {
    const solver::Region& region = d_.parts[part];
    return region.kind == Kind::cells ? of_piece(region, name) : of_side(region, others);
  }

private:
  /// Is a facet's outer side turned to us, and nothing before its middle?
  bool is_seen(std::int32_t facet, const Place& middle) const {
    return mesh_.dim < 3 || sight_.in_front(middle) == facet;
  }

  /// Away from the middle of the body.
  Place away_from_body(const Place& at) const {
    const Place away{at[0] - 0.5 * (box_.low[0] + box_.high[0]),
                     at[1] - 0.5 * (box_.low[1] + box_.high[1])};
    const double length = std::hypot(away[0], away[1]);
    return length > 1e-3 * box_.size() ? Place{away[0] / length, away[1] / length}
                                       : Place{0.0, 1.0};
  }

  /// At the entity nearest to the middle of the part, of those that are seen. Away from names that
  /// stand already, and in space where the normal is not seen from its tip, if there is such a
  /// place.
  std::optional<Tag> of_side(const solver::Region& region,
                             std::span<const std::optional<Tag>> others) const {
    constexpr double long_enough = 0.5, apart = 0.25; // of the normal, of the box
    const bool facets = region.kind == Kind::facets;
    std::vector<Tag> shown;
    for (const auto e : region.entities) {
      const Place at = flat(middle_of(mesh_, nodes_of(mesh_, region.kind, e)), mesh_.dim);
      if (!facets)
        shown.push_back({at, away_from_body(at), Tag::Kind::line});
      else if (is_seen(e, at))
        shown.push_back({at, flat(solver::facet_normal(mesh_, e), mesh_.dim), Tag::Kind::normal});
    }
    const auto cost = [&](const Tag& tag) {
      const bool crowded = std::ranges::any_of(others, [&](const std::optional<Tag>& other) {
        return other && distance(other->at, tag.at) < apart * box_.size();
      });
      const bool is_short = facets && std::hypot(tag.outward[0], tag.outward[1]) < long_enough;
      return (crowded ? 10.0 : 0.0) + (is_short ? 100.0 : 0.0);
    };
    return best(shown, cost);
  }

  /// Of a piece of the body, in its own colour if it is seen: where its name lies on it, or where
  /// a line leads off the body.
  std::optional<Tag> of_piece(const solver::Region& region, const std::string& name) const {
    const std::unordered_set<std::int32_t> cells(region.entities.begin(), region.entities.end());
    const auto in_piece = [&](std::int32_t e) {
      if (e < 0 || mesh_.dim < 3) return cells.contains(e);
      return cells.contains(mesh_.facets[static_cast<std::size_t>(e)].cell);
    };
    const auto out = place_of_piece(region, name, [&](std::int32_t e) {
      return in_piece(e) && (mesh_.dim < 3 || !sides_.contains(e));
    });
    return out ? out : place_of_piece(region, name, in_piece);
  }

  template <class OnPiece>
  std::optional<Tag> place_of_piece(const solver::Region& region, const std::string& name,
                                    const OnPiece& on_piece) const {
    std::vector<Tag> on, beside;
    const auto add = [&](const Place& at) {
      if (mesh_.dim > 1 && !on_piece(sight_.in_front(at))) return;
      on.push_back({at, {}, Tag::Kind::none});
      beside.push_back({at, away_from_body(at), Tag::Kind::line});
    };
    for (const auto c : mesh_.dim < 3 ? region.entities : std::vector<std::int32_t>{})
      add(flat(middle_of(mesh_, nodes_of(mesh_, Kind::cells, c)), mesh_.dim));
    for (std::size_t f = 0; mesh_.dim == 3 && f < mesh_.facets.size(); ++f)
      if (on_piece(static_cast<std::int32_t>(f)))
        add(flat(middle_of(mesh_, std::span(mesh_.facets[f].nodes)), 3));
    const auto covers = [&](const Tag& tag) {
      return tag.kind == Tag::Kind::none ? off(tag, name, on_piece)
                                         : off(tag, name, [](std::int32_t e) { return e < 0; });
    };
    const auto inside = best(on, covers);
    return !inside || covers(*inside) == 0.0 ? inside : best(beside, covers);
  }

  /// The share of the places under a name that are not what they should be.
  template <class Wanted>
  double off(const Tag& tag, const std::string& name, const Wanted& wanted) const {
    const double reach = (tag.kind == Tag::Kind::none ? 0.0 : tag_arrow + 8.0) / pixels_;
    const double wide = 0.5 * 0.62 * tag_size * static_cast<double>(name.size()) / pixels_;
    const double high = 0.5 * tag_size / pixels_, aside = tag.outward[0];
    const double shift = aside > 0.4 ? wide : aside < -0.4 ? -wide : 0.0;
    int wrong = 0, n = 0;
    for (const double x : {-1.0, -0.5, 0.0, 0.5, 1.0})
      for (const double y : {-1.0, 1.0}) {
        const Place at{tag.at[0] + reach * tag.outward[0] + shift + x * wide,
                       tag.at[1] + reach * tag.outward[1] + y * high};
        wrong += !wanted(sight_.in_front(at)), ++n;
      }
    return static_cast<double>(wrong) / n;
  }

  /// The one of least cost; of equals, the one nearest to the middle of all.
  template <class Cost>
  std::optional<Tag> best(const std::vector<Tag>& shown, const Cost& cost) const {
    if (shown.empty()) return std::nullopt;
    Place middle{};
    for (const Tag& tag : shown)
      for (std::size_t a = 0; a < 2; ++a)
        middle[a] += tag.at[a] / static_cast<double>(shown.size());
    return *std::ranges::min_element(
        shown, {}, [&](const Tag& tag) { return std::pair(cost(tag), distance(tag.at, middle)); });
  }

  const solver::Discretisation& d_;
  const solver::Mesh& mesh_;
  const MeshSight& sight_;
  double pixels_; ///< to a unit
  ViewBox box_;
  std::unordered_set<std::int32_t> sides_; ///< facets that have the colour of a part
};

} // namespace

std::vector<std::optional<Tag>> tags_of(const solver::Discretisation& d,
                                        std::span<const std::string> names, const MeshSight& sight,
                                        const draw::Plane& plane) {
  const Tags tags(d, sight, plane);
  std::vector<std::optional<Tag>> out(d.parts.size());
  for (const bool points : {true, false}) // points first, since they have no other place
    for (std::size_t p = 0; p < d.parts.size(); ++p)
      if (points == (d.parts[p].kind == Kind::points))
        out[p] = tags.of_part(p, names[p], points ? std::span(out).first(0) : std::span(out));
  return out;
}

} // namespace hvi::lang
