// See segments.hpp. A facet of the first side has coordinates (a, b) = (lambda_1, lambda_2) and the
// distance s from it along the direction d: x = x_0 + a (x_1 - x_0) + b (x_2 - x_0) + s d (2D: no
// b). In them the first facet is the unit simplex, and a facet of the second side is clipped to it.
#include "solver/assembly/segments.hpp"

#include "solver/common/triples.hpp"
#include "solver/fem/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr double facing = -0.1;   ///< cosine: facets seen under less are not looked at
constexpr double nothing = 1e-14; ///< a share of a facet
/// Sides that touch are this near to each other, in sizes of a facet.
constexpr double touching = 1e-6;
/// Where the way from a side to what is behind it is looked at, and how many bodies are there: two
/// between sides that are pressed into each other, one beyond either of them.
struct Look {
  double part;
  int bodies;
};
constexpr double slack = 1e-9; ///< of barycentric coordinates
constexpr Look looks[] = {{-0.5, 1}, {0.05, 2}, {0.95, 2}, {1.5, 1}};

struct Flat {
  double a = 0.0, b = 0.0;
};

/// Coordinates of a facet of the first side.
class Frame {
public:
  Frame(const Mesh& mesh, int facet, const Point& direction) : dim_(mesh.dim) {
    const auto& nodes = mesh.facets[static_cast<std::size_t>(facet)].nodes;
    origin_ = mesh.nodes[static_cast<std::size_t>(nodes[0])];
    const Point e = minus(mesh.nodes[static_cast<std::size_t>(nodes[1])], origin_);
    const Point f =
        dim_ == 3 ? minus(mesh.nodes[static_cast<std::size_t>(nodes[2])], origin_) : Point{0, 0, 1};
    // Rows of the inverse of (e, f, d).
    const double det = dot(e, cross(f, direction));
    rows_ = {cross(f, direction), cross(direction, e), cross(e, f)};
    for (Point& row : rows_)
      for (double& v : row) v /= det;
  }
  Point operator()(const Point& x) const {
    const Point r = minus(x, origin_);
    return {dot(rows_[0], r), dim_ == 3 ? dot(rows_[1], r) : 0.0, dot(rows_[2], r)};
  }

private:
  int dim_;
  Point origin_{};
  std::array<Point, 3> rows_{};
};

/// The part of a polygon where level >= 0, an affine function (Sutherland and Hodgman).
template <class Level>
void clip(std::vector<Flat>& polygon, const Level& level) {
  std::vector<Flat> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Flat &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double at_p = level(p), at_q = level(q);
    if (at_p >= 0.0) out.push_back(p);
    if ((at_p < 0.0) == (at_q < 0.0)) continue;
    const double t = at_p / (at_p - at_q);
    out.push_back({p.a + t * (q.a - p.a), p.b + t * (q.b - p.b)});
  }
  polygon = std::move(out);
}

double doubled_area(const Flat& p, const Flat& q, const Flat& r) {
  return (q.a - p.a) * (r.b - p.b) - (q.b - p.b) * (r.a - p.a);
}

/// The common simplices of the unit simplex and the one with these corners.
std::vector<std::array<Flat, 3>> common_simplices(int dim, const std::array<Point, 3>& corners) {
  if (dim == 2) {
    const double low = std::clamp(std::min(corners[0][0], corners[1][0]), 0.0, 1.0);
    const double high = std::clamp(std::max(corners[0][0], corners[1][0]), 0.0, 1.0);
    if (!(high - low > nothing)) return {};
    return {{Flat{low, 0.0}, Flat{high, 0.0}, Flat{}}};
  }
  std::vector<Flat> polygon;
  for (const Point& c : corners) polygon.push_back({c[0], c[1]});
  clip(polygon, [](const Flat& p) { return p.a; });
  clip(polygon, [](const Flat& p) { return p.b; });
  clip(polygon, [](const Flat& p) { return 1.0 - p.a - p.b; });
  std::vector<std::array<Flat, 3>> out;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    if (std::abs(doubled_area(polygon[0], polygon[i - 1], polygon[i])) > nothing)
      out.push_back({polygon[0], polygon[i - 1], polygon[i]});
  return out;
}

double share_of(int dim, const std::array<Flat, 3>& s) {
  return dim == 2 ? s[1].a - s[0].a : std::abs(doubled_area(s[0], s[1], s[2]));
}

/// A simplex in which the facet meets one of the second side.
struct Piece {
  int facet = 0;
  std::array<Flat, 3> simplex;
};

double common_share(int dim, const Piece& p, const Piece& q) {
  const auto &s = p.simplex, &t = q.simplex;
  if (dim == 2) return std::max(0.0, std::min(s[1].a, t[1].a) - std::max(s[0].a, t[0].a));
  std::vector<Flat> polygon(s.begin(), s.end());
  const double sign = doubled_area(t[0], t[1], t[2]) < 0.0 ? -1.0 : 1.0;
  for (std::size_t k = 0; k < 3; ++k)
    clip(polygon, [&](const Flat& x) { return sign * doubled_area(t[k], t[(k + 1) % 3], x); });
  double sum = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum += std::abs(doubled_area(polygon[0], polygon[i - 1], polygon[i]));
  return sum;
}

/// What pieces of different facets have in common: of one layer nothing.
double share_of_two_layers(int dim, std::vector<Piece>& pieces) {
  const auto corners = static_cast<std::ptrdiff_t>(dim);
  const auto ends = [&](const Piece& p) {
    const auto [low, high] =
        std::minmax_element(p.simplex.begin(), p.simplex.begin() + corners,
                            [](const Flat& x, const Flat& y) { return x.a < y.a; });
    return std::pair(low->a, high->a);
  };
  std::ranges::sort(pieces, {}, [&](const Piece& p) { return ends(p).first; });
  double sum = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double past = ends(pieces[i]).second;
    for (std::size_t j = i + 1; j < pieces.size() && ends(pieces[j]).first < past; ++j)
      if (pieces[i].facet != pieces[j].facet) sum += common_share(dim, pieces[i], pieces[j]);
  }
  return sum;
}

Flat at(int dim, const std::array<Flat, 3>& simplex, const Barycentric& point) {
  Flat out;
  for (int k = 0; k < dim; ++k) {
    out.a += point[static_cast<std::size_t>(k)] * simplex[static_cast<std::size_t>(k)].a;
    out.b += point[static_cast<std::size_t>(k)] * simplex[static_cast<std::size_t>(k)].b;
  }
  return out;
}

/// The middle of a facet of the second side.
Flat middle_of(int dim, const std::array<Point, 3>& corners) {
  Flat out;
  for (int k = 0; k < dim; ++k) {
    out.a += corners[static_cast<std::size_t>(k)][0] / dim;
    out.b += corners[static_cast<std::size_t>(k)][1] / dim;
  }
  return out;
}

/// The place of p on a facet with these corners.
Point point_at(int dim, const std::array<Point, 3>& corners, const Flat& p) {
  Point out = corners[0];
  for (std::size_t a = 0; a < 3; ++a)
    out[a] += p.a * (corners[1][a] - corners[0][a]) +
              (dim == 3 ? p.b * (corners[2][a] - corners[0][a]) : 0.0);
  return out;
}

/// Barycentric coordinates of p in the simplex with these corners.
Barycentric coordinates_in(int dim, const std::array<Point, 3>& corners, const Flat& p) {
  if (dim == 2) {
    const double t = (p.a - corners[0][0]) / (corners[1][0] - corners[0][0]);
    return {1.0 - t, t};
  }
  const Flat c[3] = {{corners[0][0], corners[0][1]},
                     {corners[1][0], corners[1][1]},
                     {corners[2][0], corners[2][1]}};
  const double all = doubled_area(c[0], c[1], c[2]);
  const double one = doubled_area(c[0], p, c[2]) / all, two = doubled_area(c[0], c[1], p) / all;
  return {1.0 - one - two, one, two};
}

} // namespace

SecondSide::SecondSide(const Mesh& mesh, std::span<const std::int32_t> facets, const Point& up,
                       double reach)
    : mesh_(&mesh), facets_(facets.begin(), facets.end()), reach_(reach) {
  const int least = static_cast<int>(
      std::min_element(up.begin(), up.end(),
                       [](double p, double q) { return std::abs(p) < std::abs(q); }) -
      up.begin());
  Point other{};
  other[static_cast<std::size_t>(least)] = 1.0;
  axes_[0] = cross(up, other);
  const double length = norm(axes_[0]);
  for (double& v : axes_[0]) v /= length;
  axes_[1] = cross(up, axes_[0]);
  axes_[2] = up;
  std::vector<Box> boxes;
  for (const auto f : facets_) {
    std::array<Point, 3> corners;
    for (int k = 0; k < mesh.dim; ++k)
      corners[static_cast<std::size_t>(k)] = mesh.nodes[static_cast<std::size_t>(
          mesh.facets[static_cast<std::size_t>(f)].nodes[static_cast<std::size_t>(k)])];
    boxes.push_back(box_around({corners.data(), static_cast<std::size_t>(mesh.dim)}, {}));
  }
  tree_.emplace(std::move(boxes));
}

Point SecondSide::turned(const Point& x) const {
  return {dot(axes_[0], x), dot(axes_[1], x), dot(axes_[2], x)};
}

/// Around the corners moved by -sweep and +sweep, a little larger.
Box SecondSide::box_around(std::span<const Point> corners, const Point& sweep) const {
  Box out;
  bool first = true;
  for (const Point& c : corners)
    for (const double sign : {-1.0, 1.0}) {
      const Point p =
          turned({c[0] + sign * sweep[0], c[1] + sign * sweep[1], c[2] + sign * sweep[2]});
      if (first) out = {p, p};
      include(out, {p, p});
      first = false;
    }
  const double margin =
      1e-9 * norm(minus(out.high, out.low)) + 1e-13 * (norm(out.high) + norm(out.low));
  for (std::size_t a = 0; a < 3; ++a) out.low[a] -= margin, out.high[a] += margin;
  return out;
}

/// How many bodies a point is in, as far as two: cells of two have no node in common.
int SecondSide::bodies_at(const Point& x) const {
  std::vector<std::int32_t> found;
  cells_->for_each_meeting({x, x}, [&](std::int32_t cell) {
    const Barycentric b = barycentric_in_cell(*mesh_, cell, x);
    if (std::all_of(b.begin(), b.begin() + mesh_->dim + 1, [](double v) { return v >= -slack; }))
      found.push_back(cell);
  });
  const auto corners = [&](std::int32_t cell) {
    return std::span(mesh_->cells[static_cast<std::size_t>(cell)])
        .first(static_cast<std::size_t>(mesh_->dim) + 1);
  };
  for (const auto p : found)
    for (const auto q : found)
      if (std::ranges::none_of(corners(p), [&](std::int32_t node) {
            return std::ranges::find(corners(q), node) != corners(q).end();
          }))
        return 2;
  return found.empty() ? 0 : 1;
}

/// Behind a side is the body that it is pressed into, as far as it is; else there are only far
/// sides: of its own body, and of others through that one.
bool SecondSide::is_through_bodies(const Point& from, const Point& direction, double distance,
                                   double size) {
  if (distance >= -touching * size) return false;
  if (!cells_) {
    std::vector<Box> boxes;
    for (std::size_t c = 0; c < mesh_->cells.size(); ++c) {
      Box box = box_of(*mesh_, static_cast<std::int32_t>(c));
      const double margin = 4.0 * slack * box.diagonal();
      for (std::size_t a = 0; a < 3; ++a) box.low[a] -= margin, box.high[a] += margin;
      boxes.push_back(box);
    }
    cells_.emplace(std::move(boxes));
  }
  return std::ranges::any_of(looks, [&](const Look& look) {
    Point x = from;
    for (std::size_t a = 0; a < 3; ++a) x[a] += look.part * distance * direction[a];
    return bodies_at(x) < look.bodies;
  });
}

Meetings SecondSide::meet(int facet, const Point& direction, const Quadrature& rule) {
  const int dim = mesh_->dim;
  const Frame frame(*mesh_, facet, direction);
  std::array<Point, 3> own{};
  for (int k = 0; k < dim; ++k)
    own[static_cast<std::size_t>(k)] = mesh_->nodes[static_cast<std::size_t>(
        mesh_->facets[static_cast<std::size_t>(facet)].nodes[static_cast<std::size_t>(k)])];
  const Point sweep{reach_ * direction[0], reach_ * direction[1], reach_ * direction[2]};
  std::vector<std::int32_t> near;
  tree_->for_each_meeting(box_around({own.data(), static_cast<std::size_t>(dim)}, sweep),
                          [&](std::int32_t i) { near.push_back(i); });
  std::ranges::sort(near); // whatever the tree looks like
  const double size = norm(minus(own[1], own[0]));
  const Flat middle_of_first{1.0 / dim, dim == 3 ? 1.0 / dim : 0.0};
  Meetings out;
  std::vector<Piece> pieces;
  for (const auto i : near) {
    const int other = facets_[static_cast<std::size_t>(i)];
    if (!(dot(facet_normal(*mesh_, other), direction) < facing)) continue;
    std::array<Point, 3> corners{};
    for (int k = 0; k < dim; ++k)
      corners[static_cast<std::size_t>(k)] = frame(mesh_->nodes[static_cast<std::size_t>(
          mesh_->facets[static_cast<std::size_t>(other)].nodes[static_cast<std::size_t>(k)])]);
    for (const auto& simplex : common_simplices(dim, corners)) {
      const auto distance_at = [&](const Barycentric& b) {
        return b[0] * corners[0][2] + b[1] * corners[1][2] + (dim == 3 ? b[2] * corners[2][2] : 0);
      };
      const Barycentric centre{1.0 / dim, 1.0 / dim, dim == 3 ? 1.0 / dim : 0.0};
      const Flat middle = at(dim, simplex, centre);
      const auto apart_at = [&](const Flat& p) {
        return distance_at(coordinates_in(dim, corners, p));
      };
      if (!(std::abs(apart_at(middle)) <= reach_)) continue;
      // At an edge of the bodies the way may leave them: in the middle of either facet it does not.
      const Flat places[] = {middle, middle_of_first, middle_of(dim, corners)};
      if (std::ranges::all_of(places, [&](const Flat& p) {
            return is_through_bodies(point_at(dim, own, p), direction, apart_at(p), size);
          }))
        continue;
      pieces.push_back({i, simplex});
      for (std::size_t q = 0; q < rule.size(); ++q) {
        const Flat p = at(dim, simplex, rule.points[q]);
        Meeting meeting;
        meeting.first = {1.0 - p.a - p.b, p.a, p.b};
        meeting.second = coordinates_in(dim, corners, p);
        meeting.facet = i;
        meeting.weight = rule.weights[q] * share_of(dim, simplex);
        meeting.distance = distance_at(meeting.second);
        out.points.push_back(meeting);
      }
    }
  }
  out.twice = share_of_two_layers(dim, pieces);
  return out;
}

} // namespace hvi::solver
