// Poles of loads in space; see load_space.hpp. Called by hypotheses.cpp, and by what warns of them.
#include "solver/hypotheses/load_space.hpp"

#include "solver/fem/geometry.hpp"
#include "solver/hypotheses/load_time.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/kernel/interval.hpp"
#include "solver/kernel/tape.hpp"
#include "solver/linear/dense.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace hvi::solver {
namespace {

constexpr std::size_t most_times = 33;
/// What a measured exponent may be short of: it is a slope of logarithms.
constexpr double measured = 0.005;

bool is_coordinate(Slot s) { return s >= slot::x(0) && s <= slot::x(2); }
bool reads_coordinates(const Expr& e) { return std::ranges::any_of(e.slots(), is_coordinate); }
bool of_place_and_time(const Expr& e) {
  return std::ranges::all_of(e.slots(), [](Slot s) { return is_coordinate(s) || s == slot::t; });
}

bool is_membership(Slot s) { return s >= slot::first_inside && s < slot::first_state; }
bool is_normal(Slot s) { return s >= slot::normal(0) && s <= slot::normal(2); }

bool is_affine(const Expr& e) {
  Expr slopes = 0.0;
  for (int j = 0; j < 3; ++j) slopes = slopes + abs(derivative(e, slot::x(j)));
  return !reads_coordinates(slopes);
}

/// Functions whose common zeros may be poles: one, or several that are affine.
using Zeros = std::vector<Expr>;

/// The affine functions whose squares are added up in e; nothing where it is another sum.
Zeros squares_in(const Expr& e) {
  Zeros out;
  for (const Expr& term : addends(e)) {
    bool square = false;
    for (const Expr& factor : factors(term)) {
      if (factor.is_constant() && factor.value() > 0.0) continue;
      const bool even = factor.op() == Op::pow && factor.args()[1].is_constant() &&
                        std::fmod(factor.args()[1].value(), 2.0) == 0.0;
      const bool size = factor.op() == Op::abs;
      if (square || !(even || size) || !is_affine(factor.args()[0])) return {};
      out.push_back(factor.args()[0]);
      square = true;
    }
    if (!square) return {};
  }
  return out;
}

void add_zeros(const Expr& e, std::vector<Zeros>& out) {
  if (!reads_coordinates(e)) return;
  const bool positive_power =
      e.op() == Op::pow && e.args()[1].is_constant() && e.args()[1].value() > 0.0;
  if (e.op() == Op::abs || e.op() == Op::neg || e.op() == Op::sqrt || e.op() == Op::div ||
      positive_power)
    return add_zeros(e.args()[0], out);
  if (e.op() == Op::mul) {
    for (const Expr& factor : e.args()) add_zeros(factor, out);
    return;
  }
  Zeros squares = e.op() == Op::add ? squares_in(e) : Zeros();
  out.push_back(squares.empty() ? Zeros{e} : std::move(squares));
}

void collect_zeros(const Expr& e, std::vector<Zeros>& out) {
  const auto args = e.args();
  if (e.op() == Op::div) add_zeros(args[1], out);
  if (e.op() == Op::pow && args[1].is_constant() && args[1].value() < 0.0) add_zeros(args[0], out);
  for (const Expr& arg : args) collect_zeros(arg, out);
}

/// A cell or facet of a part: its corners, and their nodes.
struct Corners {
  std::array<Point, 4> x{};
  std::array<std::int32_t, 4> nodes{};
  std::size_t n = 0;
};

Corners corners_of(const Mesh& mesh, Group::Kind kind, std::int32_t entity) {
  Corners out;
  const bool cells = kind == Group::Kind::cells;
  out.n = static_cast<std::size_t>(cells ? mesh.nodes_per_cell() : mesh.nodes_per_facet());
  for (std::size_t k = 0; k < out.n; ++k) {
    out.nodes[k] = cells ? mesh.cells[static_cast<std::size_t>(entity)][k]
                         : mesh.facets[static_cast<std::size_t>(entity)].nodes[k];
    out.x[k] = mesh.nodes[static_cast<std::size_t>(out.nodes[k])];
  }
  return out;
}

Point between(const Point& a, const Point& b, double share) {
  Point out;
  for (std::size_t j = 0; j < 3; ++j) out[j] = a[j] + share * (b[j] - a[j]);
  return out;
}

double distance(const Point& a, const Point& b) {
  return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
}

/// A place of a set of poles, the points that are looked at from there, and the set's codimension.
struct Place {
  Point at{};
  std::vector<Point> one_side, other_side;
  int codimension = 1;
  bool on_side = false; ///< of the cell or facet: on its other side another one may be
  std::vector<std::int32_t> nodes{};
};

/// Of functions, at the nodes of the mesh.
using NodeValues = std::vector<std::vector<double>>;

class PoleSearch {
public:
  PoleSearch(const Problem& problem, const Discretisation& d, const LoadTerm& load)
      : problem_(problem), d_(d), load_(load),
        region_(d.parts[static_cast<std::size_t>(load.part)]) {}

  std::optional<SpacePole> worst() {
    if (region_.kind == Group::Kind::points || region_.is_pair()) return {};
    std::optional<SpacePole> out;
    for (const LoadTerm::Entry& entry : load_.entries) {
      if (!reads_coordinates(entry.value) || !may_be_read(entry.value)) continue;
      std::vector<Zeros> zeros;
      collect_zeros(entry.value, zeros);
      std::erase_if(zeros,
                    [](const Zeros& of) { return !std::ranges::all_of(of, of_place_and_time); });
      for (const Zeros& of : zeros)
        if (const auto pole = look_at(entry, of); pole && (!out || pole->exponent > out->exponent))
          out = pole;
    }
    return out;
  }

private:
  std::vector<double> times(bool moves) const {
    const auto& grid = problem_.time.grid;
    if (grid.size() < 2) return {0.0};
    if (!moves) return {grid[1], grid.back()}; // a factor may be 0 at one of them
    std::vector<double> out;
    const std::size_t stride = std::max<std::size_t>(1, grid.size() / most_times);
    for (std::size_t n = 1; n < grid.size(); n += stride) out.push_back(grid[n]);
    return out;
  }

  std::optional<SpacePole> look_at(const LoadTerm::Entry& entry, const Zeros& zeros) {
    if (std::ranges::any_of(zeros, [&](const Expr& e) { return is_nowhere_zero(e); })) return {};
    const bool moves =
        std::ranges::any_of(zeros, [](const Expr& e) { return e.depends_on(slot::t); });
    for (const double t : times(moves)) {
      NodeValues values;
      for (const Expr& e : zeros) values.push_back(at_nodes(e, t));
      for (const auto cell : region_.entities) {
        const Corners corners = corners_of(d_.mesh, region_.kind, cell);
        const auto place = zeros.size() == 1 ? crossing(zeros.front(), values.front(), corners, t)
                                             : common(values, corners);
        if (!place) continue;
        const double exponent = exponent_at(within(entry.value, cell), *place, t);
        if (exponent < bound(entry, *place) - measured) continue;
        return SpacePole{place->at, moves ? std::optional(t) : std::nullopt, exponent};
      }
    }
    return {};
  }

  bool may_be_read(const Expr& e) const {
    return std::ranges::all_of(e.slots(), [&](Slot s) {
      return is_coordinate(s) || s == slot::t ||
             (is_membership(s) && d_.space.indicators != nullptr) ||
             (is_normal(s) && region_.kind == Group::Kind::facets);
    });
  }

  /// In this cell or on this facet, where memberships and the normal are the same throughout.
  Expr within(const Expr& e, std::int32_t entity) const {
    std::vector<std::pair<Slot, Expr>> change;
    for (const Slot s : e.slots())
      if (is_membership(s) || is_normal(s)) change.emplace_back(s, Expr(fixed_value(s, entity)));
    return change.empty() ? e : substitute(e, change);
  }

  double fixed_value(Slot s, std::int32_t entity) const {
    if (is_normal(s))
      return facet_normal(d_.mesh, entity)[static_cast<std::size_t>(s - slot::normal(0))];
    const std::int32_t cell = region_.kind == Group::Kind::cells
                                  ? entity
                                  : d_.mesh.facets[static_cast<std::size_t>(entity)].cell;
    return d_.space.indicators->value(s - slot::first_inside, region_.kind, entity, cell);
  }

  /// On the whole mesh and at all times, by intervals.
  bool is_nowhere_zero(const Expr& e) const {
    const auto& grid = problem_.time.grid;
    const Bounds found = bounds(e, [&](Slot s) {
      if (s == slot::t)
        return grid.size() < 2 ? Bounds{0.0, 0.0} : Bounds{grid.front(), grid.back()};
      const auto j = static_cast<std::size_t>(s - slot::x(0));
      const auto [low, high] =
          std::ranges::minmax(d_.mesh.nodes, {}, [j](const Point& x) { return x[j]; });
      return Bounds{low[j], high[j]};
    });
    return found.known && found.defined && (found.low > 0.0 || found.high < 0.0);
  }

  std::vector<double> at_nodes(const Expr& e, double t) const {
    const std::size_t n = d_.mesh.nodes.size();
    const Tape tape = compile({&e, 1});
    std::vector<std::vector<double>> columns;
    for (const Slot s : tape.inputs) {
      columns.emplace_back(n, t);
      for (std::size_t i = 0; i < n && s != slot::t; ++i)
        columns.back()[i] = d_.mesh.nodes[i][static_cast<std::size_t>(s - slot::x(0))];
    }
    std::vector<const double*> inputs;
    for (const auto& column : columns) inputs.push_back(column.data());
    std::vector<double> out(n);
    TapeWorkspace workspace;
    evaluate(tape, inputs, n, out, workspace);
    return out;
  }

  /// Where a function changes its sign along an edge, or is 0 on a side.
  std::optional<Place> crossing(const Expr& f, const std::vector<double>& at_node, const Corners& c,
                                double t) const {
    std::array<double, 4> values{};
    double size = 0.0;
    for (std::size_t k = 0; k < c.n; ++k) {
      values[k] = at_node[static_cast<std::size_t>(c.nodes[k])];
      if (!std::isfinite(values[k])) return {};
      size = std::max(size, std::abs(values[k]));
    }
    std::size_t low = c.n, high = c.n, rest = c.n, zero = 0;
    for (std::size_t k = 0; k < c.n; ++k) {
      if (std::abs(values[k]) <= 1e-12 * size)
        ++zero;
      else
        (values[k] < 0.0 ? low : high) = rest = k;
    }
    if (low < c.n && high < c.n) {
      const Point at = root(f, c.x[low], c.x[high], t);
      return Place{at, {c.x[low]}, {c.x[high]}};
    }
    if (rest == c.n || zero == 0 || zero + 1 != c.n) return {};
    Place out{{}, {c.x[rest]}, {}, 1, true};
    for (std::size_t k = 0; k < c.n; ++k) {
      if (k == rest) continue;
      out.nodes.push_back(c.nodes[k]);
      for (std::size_t j = 0; j < 3; ++j) out.at[j] += c.x[k][j] / static_cast<double>(zero);
    }
    return out;
  }

  Point root(const Expr& f, Point a, Point b, double t) const {
    for (int k = 0; k < 200; ++k) {
      const Point middle = between(a, b, 0.5);
      if (middle == a || middle == b) break;
      const double v = value(f, middle, t);
      if (v == 0.0) return middle;
      (v < 0.0 ? a : b) = middle;
    }
    return std::abs(value(f, a, t)) < std::abs(value(f, b, t)) ? a : b;
  }

  /// Where affine functions are 0 together: on faces of as many corners as make that a point.
  static std::optional<Place> common(const NodeValues& at_node, const Corners& c) {
    DenseMatrix values(static_cast<Eigen::Index>(at_node.size()) + 1,
                       static_cast<Eigen::Index>(c.n));
    for (std::size_t k = 0; k < c.n; ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      for (std::size_t i = 0; i < at_node.size(); ++i)
        values(static_cast<Eigen::Index>(i), column) =
            at_node[i][static_cast<std::size_t>(c.nodes[k])];
      values(values.rows() - 1, column) = 1.0;
    }
    if (!values.allFinite()) return {};
    const auto rank = static_cast<std::size_t>(values.colPivHouseholderQr().rank());
    if (rank < 2 || rank > c.n) return {};
    const auto points = points_of_faces(values, rank, c);
    if (points.size() < c.n - rank + 1) return {}; // an edge or a corner is touched
    Place out;
    out.codimension = static_cast<int>(rank) - 1;
    for (const Point& x : points)
      for (std::size_t j = 0; j < 3; ++j) out.at[j] += x[j] / static_cast<double>(points.size());
    for (double& x : out.at)
      if (std::abs(x) < 1e-12 * distance(c.x[0], c.x[1])) x = 0.0; // rounding
    for (std::size_t k = 0; k < c.n; ++k)
      if (distance(c.x[k], out.at) > 1e-9 * distance(c.x[0], c.x[1]))
        out.one_side.push_back(c.x[k]);
    return out;
  }

  /// The different points l >= 0, sum l = 1, with which faces of `rank` corners solve the
  /// equations.
  static std::vector<Point> points_of_faces(const DenseMatrix& values, std::size_t rank,
                                            const Corners& c) {
    std::vector<Point> out;
    Vector right = Vector::Zero(values.rows());
    right[right.size() - 1] = 1.0;
    for (unsigned face = 0; face < (1U << c.n); ++face) {
      std::vector<Eigen::Index> own;
      for (std::size_t k = 0; k < c.n; ++k)
        if ((face >> k) & 1U) own.push_back(static_cast<Eigen::Index>(k));
      if (own.size() != rank) continue;
      const DenseMatrix part = values(Eigen::all, own);
      const Vector shares = part.colPivHouseholderQr().solve(right);
      const double scale = part.lpNorm<Eigen::Infinity>() + 1.0;
      if ((part * shares - right).lpNorm<Eigen::Infinity>() > 1e-9 * scale) continue;
      if (shares.minCoeff() < -1e-9) continue;
      Point at{};
      for (std::size_t i = 0; i < own.size(); ++i)
        for (std::size_t j = 0; j < 3; ++j)
          at[j] += shares[static_cast<Eigen::Index>(i)] * c.x[static_cast<std::size_t>(own[i])][j];
      if (std::ranges::none_of(out, [&](const Point& x) {
            return distance(x, at) < 1e-9 * distance(c.x[0], c.x[1]);
          }))
        out.push_back(at);
    }
    return out;
  }

  /// Beside a surface the larger one of its two sides; else the least of all directions.
  double exponent_at(const Expr& f, const Place& place, double t) const {
    const auto least = [&](const std::vector<Point>& ends) {
      double out = ends.empty() ? 0.0 : std::numeric_limits<double>::infinity();
      for (const Point& end : ends) out = std::min(out, exponent_towards(f, place.at, end, t));
      return out;
    };
    return std::max(least(place.one_side), least(place.other_side));
  }

  double exponent_towards(const Expr& f, const Point& at, const Point& end, double t) const {
    const double length = distance(at, end);
    std::vector<std::pair<Slot, Expr>> change{{slot::t, Expr(t)}};
    for (int j = 0; j < 3; ++j) {
      const auto i = static_cast<std::size_t>(j);
      change.emplace_back(slot::x(j), Expr(at[i]) + Expr((end[i] - at[i]) / length) *
                                                        Expr::variable(slot::argument(0)));
    }
    // On bodies of revolution the integral has the weight x.
    const Expr whole = d_.mesh.axisymmetric ? f * Expr::variable(slot::x(0)) : f;
    return exponent_of_growth(substitute(whole, change));
  }

  double bound(const LoadTerm::Entry& entry, const Place& place) {
    const double c = place.codimension;
    if (!slot::is_value(entry.test)) return 0.5 * c;
    return place.on_side && is_held(entry, place) ? 1.5 : c;
  }

  /// Are functions of the space 0 on the side where the poles are?
  bool is_held(const LoadTerm::Entry& entry, const Place& place) {
    if (held_.empty())
      for (const Eliminated& e : d_.dofs.eliminated) held_.insert(e.dof);
    const int component = decode(d_.space, entry.test, load_.origin).component;
    return std::ranges::all_of(place.nodes, [&](std::int32_t node) {
      return held_.contains(d_.space.dof(node, component));
    });
  }

  static double value(const Expr& f, const Point& x, double t) {
    return evaluate(
        f, [&](Slot s) { return s == slot::t ? t : x[static_cast<std::size_t>(s - slot::x(0))]; });
  }

  const Problem& problem_;
  const Discretisation& d_;
  const LoadTerm& load_;
  const Region& region_;
  std::set<std::int32_t> held_;
};

} // namespace

std::string describe_pole(const SpacePole& pole, int dim) {
  return fmt::format("it grows like d^-{:.4g} at the distance d from poles at {}{}", pole.exponent,
                     describe_point(pole.at, dim),
                     pole.t ? fmt::format(", t = {:.6g}", *pole.t) : std::string());
}

std::optional<SpacePole> space_pole(const Problem& problem, const Discretisation& d,
                                    const LoadTerm& load) {
  return PoleSearch(problem, d, load).worst();
}

} // namespace hvi::solver
