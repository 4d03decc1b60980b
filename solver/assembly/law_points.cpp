// Quadrature points of a superpotential: int factor j^0( arg(u); arg'(v) ), with
// arg(u)_c = sum_i rows[c].u[i] u_i + offset_c, as a sparse matrix G from dofs to arguments.
//
// A radial law sees its vector argument through the norm only. Its rows are replaced by Q^T rows,
// with Q an orthonormal basis of their range at the point: |Q^T R u| = |R u|, and 2D friction on
// u.tau becomes one scalar row, 3D friction two.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/pairing.hpp"
#include "solver/assembly/range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace hvi::solver {
namespace {

/// Normals and rows closer than this are the same; far from the origin their own rounding adds to
/// it.
constexpr double as_one = 1e-12;

/// One point before merging. rows: R, arguments x components.
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

const SpaceBlock& block_of(const Space& space, const LawTerm& term) {
  return space.blocks[static_cast<std::size_t>(term.unknown)];
}

/// Of the elements that the term's points are of.
int order_of_points(const Space& space, const LawTerm& term) {
  return space.blocks[static_cast<std::size_t>(term.rule_of.value_or(term.unknown))].order;
}

void check_shape(const SpaceBlock& block, const LawTerm& term, bool radial) {
  const bool scalar = !radial && term.rows.size() == 1;
  if (!scalar && !(radial && !term.rows.empty() && term.rows.size() <= 3)) {
    throw Failure(
        FailureKind::bad_value, term.origin,
        fmt::format("a {} law with {} arguments", radial ? "radial" : "scalar", term.rows.size()));
  }
  for (const auto& row : term.rows) {
    for (int i = block.components; i < 3; ++i) {
      if (row.u[i].is(0.0)) {
        continue;
      }
      throw Failure(FailureKind::bad_value, term.origin,
                    fmt::format("the argument of the law uses component {} of a field with {}",
                                i + 1, block.components));
    }
  }
}

/// Evaluates factor and rows at all points of the region that have a weight.
class Collector {
public:
  Collector(const Space& space, const Region& region, const LawTerm& term)
      : space_(space), block_(block_of(space, term)), order_(order_of_points(space, term)),
        region_(region), term_(term), tape_(expressions(term)) {}

  std::vector<RawPoint> collect(const Pairing& pairing) {
    add(as_block(space_, pairing), pairing.x.size());
    for (std::size_t p = 0; p < raw_.size(); ++p) raw_[p].node = pairing.node[p];
    return std::move(raw_);
  }

  std::vector<RawPoint> collect() {
    const int dim = dimension_of(*space_.mesh, region_);
    local_nodes_ = nodal_rule_nodes(dim, dim == 0 ? 1 : order_);
    const RegionPoints points(space_, region_, term_.rule, 2 * (order_ + 1), order_);
    points.for_blocks([&](const PointBlock& block) { add(block, points.per_entity()); });
    return std::move(raw_);
  }

private:
  static std::vector<Expr> expressions(const LawTerm& term) {
    std::vector<Expr> all{term.factor};
    for (const auto& row : term.rows) {
      all.insert(all.end(), row.u.begin(), row.u.end());
    }
    return all;
  }
  void add(const PointBlock& block, std::size_t per_entity) {
    const std::size_t n = block.size();
    values_.resize(n * (1 + 3 * term_.rows.size()));
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
      point.rows.resize(static_cast<Eigen::Index>(term_.rows.size()), block_.components);
      for (Eigen::Index c = 0; c < point.rows.rows(); ++c) {
        for (int i = 0; i < block_.components; ++i) {
          point.rows(c, i) = values_[(1 + 3 * std::size_t(c) + i) * n + p];
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
  Pointwise tape_;
  std::vector<int> local_nodes_;
  std::vector<double> values_;
  std::vector<RawPoint> raw_;
};

bool is_same(const RawPoint& a, const RawPoint& b) {
  const double near = as_one + a.rounding + b.rounding;
  for (int j = 0; j < 3; ++j) {
    if (std::abs(a.normal[j] - b.normal[j]) > near) {
      return false;
    }
  }
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

/// Row (p, c), column dof (i, k): rows_p(c, k) phi_i(x_p), k among the components of an unknown.
void add_rows(const Space& space, const SpaceBlock& block, const std::vector<RawPoint>& raw,
              const RowPlaces& places, Triplets& triplets) {
  ShapeTable shapes;
  const int values = block.order < space.order ? linear_rows : 0;
  for (std::size_t p = 0; p < raw.size(); ++p) {
    const RawPoint& point = raw[p];
    evaluate_shapes(space, {}, point.barycentric, false, shapes);
    const auto nodes = space.nodes_of_cell(point.cell);
    for (int i = 0; i < shapes.size; ++i) {
      // Nodal points: shape functions of other nodes are zero there up to rounding.
      // (Of P1 beside P2 they have values at every node.)
      const bool own_node = point.node >= 0 && block.order == space.order;
      const double phi = own_node ? (nodes[i] == point.node ? 1.0 : 0.0) : shapes.at(values, i);
      for (Eigen::Index c = 0; c < point.rows.rows() && phi != 0.0; ++c) {
        for (int k = 0; k < block.components; ++k) {
          const double value = phi * point.rows(c, k);
          if (value == 0.0) {
            continue;
          }
          triplets.emplace_back(places.of(p, c), space.dof(nodes[i], block.first + k), value);
        }
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
  const auto add = [&](const SpaceBlock& of, bool mean, const RowPlaces& places) {
    const SparseMatrix* const jump = of.order < space.order ? &straight : out.jump.get();
    out.jump ? add_rows_across(space, of, *jump, mean, raw, places, triplets)
             : add_rows(space, of, raw, places, triplets);
  };
  add(block, term.mean, {out.rows, 0});
  out.g = from_triplets(space, raw.size() * static_cast<std::size_t>(out.rows), triplets);
  if (with_trace) {
    const int per_point =
        LawPoints::traced(slot::of_unknown(static_cast<int>(space.blocks.size()), 0));
    triplets.clear();
    for (std::size_t b = 0; b < space.blocks.size(); ++b) {
      const int n = space.blocks[b].components;
      for (RawPoint& point : raw) point.rows = DenseMatrix::Identity(n, n);
      const auto first = static_cast<int>(b);
      add(space.blocks[b], false, {per_point, LawPoints::traced(slot::of_unknown(first, 0))});
      if (out.jump)
        add(space.blocks[b], true,
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
