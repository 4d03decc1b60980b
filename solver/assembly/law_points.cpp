// Quadrature points of a superpotential: int factor j^0( arg(u); arg'(v) ), with
// arg(u)_c = sum_i rows[c].u[i] D_i u + offset_c, as a sparse matrix G from dofs to arguments; D_i
// u are values of u and, at points inside the cells, of its gradient.
//
// A radial law sees its vector argument through the norm only. Its rows are replaced by Q^T rows,
// with Q an orthonormal basis of their range at the point: |Q^T R u| = |R u|, and 2D friction on
// u.tau becomes one scalar row, 3D friction two.
//
// Nodal points on a side that turns from facet to facet have one normal, the mean of those about
// the node. With a point for each facet a wall would hold the node along both, so that the polygon
// of a circle could not slide on its drum however fine it is (the paradox of I. Babuska).
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/facet_fans.hpp"
#include "solver/assembly/pairing.hpp"
#include "solver/assembly/range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>

namespace hvi::solver {
namespace {

/// Normals and rows closer than this are the same; far from the origin their own rounding adds to
/// it.
constexpr double as_one = 1e-12;

/// One point before merging. rows: R, arguments x derivatives of u.
struct RawPoint {
  Point x, normal;
  double weight;
  std::int32_t node, entity, cell;
  Barycentric barycentric;
  DenseMatrix rows;
  double rounding = 0.0; ///< of the normal
};

/// How far rounding of its nodes may turn a facet: a few units in the last place of the largest
/// coordinate, by its least height. Whole decimals of a mesh that lies far from the origin turn the
/// facets of a plane as much.
double rounding_of_normal(const Mesh& mesh, int facet) {
  constexpr double units = 8.0 * std::numeric_limits<double>::epsilon();
  const auto& nodes = mesh.facets[facet].nodes;
  double largest = 0.0, longest = 0.0;
  for (int a = 0; a < mesh.nodes_per_facet(); ++a) {
    const Point& p = mesh.nodes[nodes[a]];
    for (const double v : p) largest = std::max(largest, std::abs(v));
    for (int b = 0; b < a; ++b) {
      const Point& q = mesh.nodes[nodes[b]];
      longest = std::max(longest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
    }
  }
  if (mesh.dim == 1) return 0.0;
  const double height = mesh.dim == 2 ? longest : 2.0 * facet_measure(mesh, facet) / longest;
  return height > 0.0 ? units * largest / height : 0.0;
}

bool is_near(const Point& a, const Point& b, double near) {
  return std::abs(a[0] - b[0]) <= near && std::abs(a[1] - b[1]) <= near &&
         std::abs(a[2] - b[2]) <= near;
}

const SpaceBlock& block_of(const Space& space, const LawTerm& term) {
  return space.blocks[static_cast<std::size_t>(term.unknown)];
}

/// Of the elements that the term's points are of.
int order_of_points(const Space& space, const LawTerm& term) {
  return space.blocks[static_cast<std::size_t>(term.rule_of.value_or(term.unknown))].order;
}

void check_shape(const SpaceBlock& block, const LawTerm& term, bool radial) {
  const bool scalar = !radial && term.rows.size() == 1;
  if (!scalar && !(radial && !term.rows.empty() && std::ssize(term.rows) <= slot::most_arguments)) {
    throw Failure(
        FailureKind::bad_value, term.origin,
        fmt::format("a {} law with {} arguments", radial ? "radial" : "scalar", term.rows.size()));
  }
  for (const auto& row : term.rows) {
    for (int i = block.components; i < 3; ++i) { // those of the gradient: decode()
      if (row.u[i].is(0.0)) {
        continue;
      }
      throw Failure(FailureKind::bad_value, term.origin,
                    fmt::format("the argument of the law uses component {} of a field with {}",
                                i + 1, block.components));
    }
  }
}

/// The derivative indices that rows have columns for: all values, and what a row sees of the
/// gradient.
std::vector<int> derivatives_of(const SpaceBlock& block, const LawTerm& term) {
  std::vector<int> out(static_cast<std::size_t>(block.components));
  std::iota(out.begin(), out.end(), slot::value(0));
  for (int i = slot::gradient(0, 0); i < slot::own_derivatives; ++i)
    if (std::ranges::any_of(term.rows, [&](const auto& row) { return !row.u[i].is(0.0); }))
      out.push_back(i);
  return out;
}

/// Where the points of a law stand. Gradients have no values at nodes; they are of one degree less,
/// and more points than see all of them would state the same twice.
RegionPoints points_on(const Space& space, const Region& region, const LawTerm& term, int order) {
  if (!term.sees_gradient()) return {space, region, term.rule, 2 * (order + 1), order};
  const bool one = order == 1 || term.rule == Rule::midpoint;
  return {space, region, one ? Rule::midpoint : Rule::exact, 2 * (order - 1), order};
}

/// Evaluates factor and rows at all points of the region that have a weight.
class Collector {
public:
  Collector(const Space& space, const Region& region, const LawTerm& term)
      : space_(space), block_(block_of(space, term)), order_(order_of_points(space, term)),
        region_(region), term_(term), derivatives_(derivatives_of(block_, term)),
        tape_(expressions()) {}

  std::vector<RawPoint> collect(const Pairing& pairing) {
    add(as_block(space_, pairing), pairing.x.size());
    for (std::size_t p = 0; p < raw_.size(); ++p) raw_[p].node = pairing.node[p];
    return std::move(raw_);
  }

  std::vector<RawPoint> collect() {
    const int dim = dimension_of(*space_.mesh, region_);
    local_nodes_ = nodal_rule_nodes(dim, dim == 0 ? 1 : order_);
    if (term_.rule == Rule::nodal && region_.kind == Group::Kind::facets)
      fans_.emplace(space_, region_.entities);
    const RegionPoints points = points_on(space_, region_, term_, order_);
    points.for_blocks([&](const PointBlock& block) {
      fans_ ? add(turned(block, points.per_entity()), points.per_entity())
            : add(block, points.per_entity());
    });
    return std::move(raw_);
  }

private:
  std::vector<Expr> expressions() const {
    std::vector<Expr> all{term_.factor};
    for (const auto& row : term_.rows)
      for (const int i : derivatives_) all.push_back(row.u[i]);
    return all;
  }
  /// The points of the next facets with the normals at their nodes. On a plane these are the
  /// facets', to the last bit.
  PointBlock turned(PointBlock block, std::size_t per_entity) {
    for (std::size_t p = 0; p < block.size(); ++p) {
      const std::size_t f = next_facet_ + p / per_entity;
      const Point normal = fans_->normal_at(static_cast<int>(f), local_nodes_[p % per_entity]);
      const double near = as_one + 2.0 * rounding_of_normal(*space_.mesh, block.entity[p]);
      if (is_near(normal, fans_->normal(f), near)) continue;
      for (std::size_t j = 0; j < 3; ++j) block.normal[j][p] = normal[j];
    }
    next_facet_ += block.size() / per_entity;
    return block;
  }
  void add(const PointBlock& block, std::size_t per_entity) {
    const std::size_t n = block.size();
    const std::size_t columns = derivatives_.size();
    values_.resize(n * (1 + columns * term_.rows.size()));
    tape_.evaluate(block, 0.0, term_.origin, values_);
    for (std::size_t p = 0; p < n; ++p) {
      // A side on the axis has no area.
      if (block.weight[p] == 0.0 && space_.mesh->axisymmetric) continue;
      const double factor = values_[p];
      check_factor(factor, block.point(p));
      RawPoint point{
          block.point(p), {}, block.weight[p] * factor, -1, block.entity[p], block.cell[p], {}, {}};
      if (!block.barycentric.empty()) point.barycentric = block.barycentric[p];
      for (int j = 0; j < 3; ++j) {
        point.normal[j] = block.normal[j][p];
      }
      if (!region_.is_pair()) point.node = node_of(block.entity[p], p % per_entity);
      if (point.node >= 0 && region_.kind == Group::Kind::facets)
        point.rounding = rounding_of_normal(*space_.mesh, block.entity[p]);
      point.rows.resize(static_cast<Eigen::Index>(term_.rows.size()),
                        static_cast<Eigen::Index>(columns));
      for (Eigen::Index c = 0; c < point.rows.rows(); ++c) {
        for (Eigen::Index i = 0; i < point.rows.cols(); ++i) {
          point.rows(c, i) = values_[(1 + columns * std::size_t(c) + std::size_t(i)) * n + p];
        }
      }
      if (!point.rows.allFinite()) {
        throw_not_finite(term_.origin, "the argument of the law", point.rows.sum(), point.x,
                         space_.mesh->dim);
      }
      raw_.push_back(std::move(point));
    }
  }
  void check_factor(double factor, const Point& x) const {
    if (factor > 0 && std::isfinite(factor)) {
      return;
    }
    throw Failure(FailureKind::bad_value, term_.origin,
                  fmt::format("the factor of the law `{}` is {:.6g} at {}", term_.name, factor,
                              describe_point(x, space_.mesh->dim)),
                  "it must be positive: a negative one would turn the superpotential over");
  }
  std::int32_t node_of(int entity, std::size_t q) const {
    if (region_.kind == Group::Kind::points) {
      return entity;
    }
    if (term_.rule != Rule::nodal) {
      return -1;
    }
    const auto nodes = region_.kind == Group::Kind::cells ? space_.nodes_of_cell(entity)
                                                          : space_.nodes_of_facet(entity);
    return nodes[local_nodes_[q]];
  }

  const Space& space_;
  const SpaceBlock& block_;
  const int order_; ///< of the rule
  const Region& region_;
  const LawTerm& term_;
  const std::vector<int> derivatives_;
  Pointwise tape_;
  std::vector<int> local_nodes_;
  std::optional<FacetFans> fans_;
  std::size_t next_facet_ = 0; ///< of the region's list
  std::vector<double> values_;
  std::vector<RawPoint> raw_;
};

bool is_same(const RawPoint& a, const RawPoint& b) {
  const double near = as_one + a.rounding + b.rounding;
  if (!is_near(a.normal, b.normal, near)) return false;
  const double scale = std::max(a.rows.cwiseAbs().maxCoeff(), b.rows.cwiseAbs().maxCoeff());
  return (a.rows - b.rows).cwiseAbs().maxCoeff() <= 2.0 * near * scale;
}

/// Adds the weights of points on one node that are the same; keeps the order of first appearance.
std::vector<RawPoint> merge(std::vector<RawPoint> raw) {
  std::vector<RawPoint> kept;
  std::unordered_map<std::int32_t, std::vector<std::size_t>> at_node;
  for (RawPoint& point : raw) {
    if (point.node >= 0) {
      auto& here = at_node[point.node];
      const auto twin = std::find_if(here.begin(), here.end(),
                                     [&](std::size_t k) { return is_same(kept[k], point); });
      if (twin != here.end()) {
        kept[*twin].weight += point.weight;
        continue;
      }
      here.push_back(kept.size());
    }
    kept.push_back(std::move(point));
  }
  return kept;
}

/// Bases of the range of these rows at every point, with one common number of columns: the largest
/// rank.
std::vector<DenseMatrix> bases_of(const std::vector<RawPoint>& raw, const std::vector<int>& rows) {
  std::vector<DenseMatrix> out;
  int largest = 0;
  for (const RawPoint& point : raw) {
    int rank = 0;
    out.push_back(basis_of_range(point.rows(rows, Eigen::all), rank));
    largest = std::max(largest, rank);
  }
  for (DenseMatrix& basis : out) basis = basis.leftCols(largest).eval();
  return out;
}

/// The rows of a law, those together that see the same fields.
std::vector<std::vector<int>> rows_alike(const LawTerm& term) {
  std::vector<std::vector<int>> out;
  for (int c = 0; c < static_cast<int>(term.rows.size()); ++c) {
    const auto same = std::ranges::find_if(out, [&](const std::vector<int>& group) {
      return term.seen.empty() || term.seen[static_cast<std::size_t>(group.front())] ==
                                      term.seen[static_cast<std::size_t>(c)];
    });
    same == out.end() ? out.push_back({c}) : same->push_back(c);
  }
  return out;
}

/// Reduces the rows of every point to one common number, those that see different fields each among
/// themselves.
void reduce_radial(std::vector<RawPoint>& raw, const LawTerm& term, LawPoints& out) {
  const auto n_args = static_cast<Eigen::Index>(term.rows.size());
  out.rows = 0;
  out.frames.assign(raw.size(), DenseMatrix(n_args, 0));
  for (const auto& group : rows_alike(term)) {
    const auto bases = bases_of(raw, group);
    const Eigen::Index more = bases.empty() ? 0 : bases.front().cols();
    for (std::size_t p = 0; p < raw.size(); ++p) {
      DenseMatrix& frame = out.frames[p];
      frame.conservativeResize(n_args, out.rows + more);
      frame.rightCols(more).setZero();
      for (std::size_t i = 0; i < group.size(); ++i)
        frame.row(group[i]).tail(more) = bases[p].row(static_cast<Eigen::Index>(i));
    }
    if (!term.seen.empty())
      out.seen.insert(out.seen.end(), static_cast<std::size_t>(more),
                      term.seen[static_cast<std::size_t>(group.front())]);
    out.rows += static_cast<int>(more);
  }
  if (out.rows == 0) {
    throw Failure(FailureKind::bad_value, term.origin,
                  fmt::format("the argument of the law `{}` does not depend on u", term.name));
  }
  for (std::size_t p = 0; p < raw.size(); ++p)
    raw[p].rows = (out.frames[p].transpose() * raw[p].rows).eval();
}

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Where the rows of points stand: so many of each point, those in question from `first` on.
struct RowPlaces {
  int per_point, first;
  int of(std::size_t point, Eigen::Index row) const {
    return static_cast<int>(point) * per_point + first + static_cast<int>(row);
  }
};

/// What the columns of rows stand for.
struct SeenDerivatives {
  const SpaceBlock& block;
  std::vector<Derivative> of_column;
  bool gradients = false;
};

SeenDerivatives seen_derivatives(const Space& space, int unknown, const std::vector<int>& indices,
                                 Origin origin) {
  SeenDerivatives out{space.blocks[static_cast<std::size_t>(unknown)], {}};
  for (const int i : indices) {
    out.of_column.push_back(decode(space, slot::of_unknown(unknown, i), origin));
    out.gradients = out.gradients || !slot::is_value(i);
  }
  return out;
}

/// Row (p, c), column dof (i, component of D_k): rows_p(c, k) (D_k phi_i)(x_p), D_k the values and
/// derivatives of the unknown that rows have columns for.
void add_rows(const Space& space, const SeenDerivatives& seen, const std::vector<RawPoint>& raw,
              const RowPlaces& places, Triplets& triplets) {
  ShapeTable shapes;
  const SpaceBlock& block = seen.block;
  for (std::size_t p = 0; p < raw.size(); ++p) {
    const RawPoint& point = raw[p];
    const CellGeometry geometry =
        seen.gradients ? cell_geometry(*space.mesh, point.cell) : CellGeometry{};
    evaluate_shapes(space, geometry, point.barycentric, seen.gradients, shapes);
    const auto nodes = space.nodes_of_cell(point.cell);
    for (int i = 0; i < shapes.size; ++i) {
      // Nodal points: shape functions of other nodes are zero there up to rounding.
      // (Of P1 beside P2 they have values at every node.)
      const bool own_node = point.node >= 0 && block.order == space.order;
      for (std::size_t k = 0; k < seen.of_column.size(); ++k) {
        const auto [component, row] = seen.of_column[k];
        const double phi = own_node ? (nodes[i] == point.node ? 1.0 : 0.0) : shapes.at(row, i);
        for (Eigen::Index c = 0; c < point.rows.rows() && phi != 0.0; ++c)
          if (const double value = phi * point.rows(c, static_cast<Eigen::Index>(k)); value != 0.0)
            triplets.emplace_back(places.of(p, c), space.dof(nodes[i], component), value);
      }
    }
  }
}

/// The same on a pair: rows_p(c, k) times the row of u_k's jump, or of its mean.
void add_rows_across(const Space& space, const SpaceBlock& block, const SparseMatrix& jump,
                     bool mean, const std::vector<RawPoint>& raw, const RowPlaces& places,
                     Triplets& triplets) {
  const std::size_t first = mean ? raw.size() : 0;
  for (std::size_t p = 0; p < raw.size(); ++p)
    for (SparseMatrix::InnerIterator it(jump, static_cast<Eigen::Index>(first + p)); it; ++it)
      for (Eigen::Index c = 0; c < raw[p].rows.rows(); ++c)
        for (int k = 0; k < block.components; ++k)
          if (const double value = it.value() * raw[p].rows(c, k); value != 0.0)
            triplets.emplace_back(places.of(p, c),
                                  space.dof(static_cast<int>(it.col()), block.first + k), value);
}

SparseMatrix from_triplets(const Space& space, std::size_t rows, const Triplets& triplets) {
  SparseMatrix out(static_cast<Eigen::Index>(rows), space.n_dofs());
  out.setFromTriplets(triplets.begin(), triplets.end());
  return out;
}

/// The points of a term before its rows are made.
std::vector<RawPoint> raw_points(const Space& space, const Region& region, const LawTerm& term,
                                 LawPoints& out) {
  Collector collector(space, region, term);
  if (!region.is_pair()) return merge(collector.collect());
  if (term.rule != Rule::nodal)
    throw Failure(
        FailureKind::bad_value, term.origin,
        fmt::format("the law `{}` acts on a pair, at the nodes of its first side", term.name),
        "leave out `rule`");
  Pairing pairing = make_pairing(space, region, order_of_points(space, term));
  auto raw = collector.collect(pairing);
  out.gap = std::move(pairing.gap);
  out.jump = std::make_shared<const SparseMatrix>(std::move(pairing.jump));
  return raw;
}

} // namespace

LawPoints assemble_law(const Space& space, const Region& region, const LawTerm& term, int law_term,
                       bool radial, bool with_trace) {
  const SpaceBlock& block = block_of(space, term);
  check_shape(block, term, radial);
  LawPoints out;
  std::vector<RawPoint> raw = raw_points(space, region, term, out);
  out.law_term = law_term;
  out.dim = space.mesh->dim;
  out.rows = static_cast<int>(term.rows.size());
  if (!radial) out.seen = term.seen;
  if (radial) {
    reduce_radial(raw, term, out);
  }
  Triplets triplets;
  const SparseMatrix straight =
      out.jump && space.is_mixed() ? straightened(space, *out.jump) : SparseMatrix();
  const auto add = [&](int unknown, const std::vector<int>& derivatives, bool mean,
                       const RowPlaces& places) {
    const SpaceBlock& of = space.blocks[static_cast<std::size_t>(unknown)];
    const SparseMatrix* const jump = of.order < space.order ? &straight : out.jump.get();
    out.jump ? add_rows_across(space, of, *jump, mean, raw, places, triplets)
             : add_rows(space, seen_derivatives(space, unknown, derivatives, term.origin), raw,
                        places, triplets);
  };
  add(term.unknown, derivatives_of(block, term), term.mean, {out.rows, 0});
  out.g = from_triplets(space, raw.size() * static_cast<std::size_t>(out.rows), triplets);
  if (with_trace) {
    const int per_point =
        LawPoints::traced(slot::of_unknown(static_cast<int>(space.blocks.size()), 0));
    triplets.clear();
    for (std::size_t b = 0; b < space.blocks.size(); ++b) {
      const int n = space.blocks[b].components;
      for (RawPoint& point : raw) point.rows = DenseMatrix::Identity(n, n);
      const auto first = static_cast<int>(b);
      const std::vector<int> values = derivatives_of(space.blocks[b], {});
      add(first, values, false, {per_point, LawPoints::traced(slot::of_unknown(first, 0))});
      if (out.jump)
        add(first, values, true,
            {per_point, LawPoints::traced(slot::of_unknown(first, slot::mean(0)))});
    }
    out.trace = from_triplets(space, raw.size() * static_cast<std::size_t>(per_point), triplets);
  }
  for (const RawPoint& point : raw) {
    out.x.push_back(point.x);
    out.normal.push_back(point.normal);
    out.weight.push_back(point.weight);
    out.node.push_back(point.node);
    out.facet.push_back(point.entity);
    out.cell.push_back(point.cell);
  }
  out.kind = region.kind;
  out.indicators = space.indicators;
  for (const auto& row : term.rows) {
    out.offset_depends_on_t = out.offset_depends_on_t || row.offset.depends_on(slot::t);
  }
  return out;
}

} // namespace hvi::solver
