// See rigid_motions.hpp.
#include "solver/discrete/rigid_motions.hpp"

#include "solver/common/joined.hpp"
#include "solver/discrete/strain.hpp"
#include "solver/fem/geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hvi::solver {
namespace {

/// Beyond this no motions are looked for: their number is that of unknowns of a dense matrix.
constexpr int most_pieces = 60;
/// What a condition adds to those before it counts from this part of its size on.
constexpr double smallest_new = 1e-10;
/// Parts of a motion that are not told.
constexpr double not_told = 1e-6;
/// Of the motions of nodes that periodic parts make one.
constexpr double same_motion = 1e-6;
/// A centre that many sizes away makes a turn a translation.
constexpr double far_away = 1e4;

int amplitudes_per_piece(const Space& space, const SpaceBlock& block) {
  if (block.components == 1 || has_hoop(space, block)) return 1;
  return block.components == 2 ? 3 : 6;
}

/// An orthonormal basis of what these orthonormal columns span, near to unit vectors.
DenseMatrix aligned(const DenseMatrix& columns) {
  constexpr double clearly = 1e-9;
  DenseMatrix rest = columns * columns.transpose(), out(columns.rows(), columns.cols());
  for (Eigen::Index found = 0; found < out.cols(); ++found) {
    Eigen::Index most = 0;
    for (Eigen::Index i = 1; i < rest.cols(); ++i)
      if (rest.col(i).norm() > (1.0 + clearly) * rest.col(most).norm()) most = i;
    out.col(found) = rest.col(most).normalized();
    for (int twice = 0; twice < 2; ++twice)
      rest -= out.col(found) * (out.col(found).transpose() * rest);
  }
  return out;
}

/// An orthonormal basis of what the rows added so far span.
class RowSpace {
public:
  explicit RowSpace(Eigen::Index n) : n_(n) {}
  bool full() const { return static_cast<Eigen::Index>(rows_.size()) == n_; }
  void add(Vector row) {
    const double before = row.norm();
    for (int twice = 0; twice < 2; ++twice)
      for (const Vector& known : rows_) row -= known.dot(row) * known;
    if (const double left = row.norm(); left > smallest_new * before) rows_.push_back(row / left);
  }
  /// Of the vectors that all rows take to 0.
  DenseMatrix kernel() const {
    DenseMatrix rest = DenseMatrix::Identity(n_, n_); // what the rows leave of unit vectors
    const auto remove = [&](const Vector& known) { rest -= known * (known.transpose() * rest); };
    for (int twice = 0; twice < 2; ++twice) std::ranges::for_each(rows_, remove);
    DenseMatrix out(n_, n_ - static_cast<Eigen::Index>(rows_.size()));
    for (Eigen::Index found = 0; found < out.cols(); ++found) {
      Eigen::Index most = 0;
      for (Eigen::Index i = 1; i < n_; ++i)
        if (rest.col(i).norm() > (1.0 + smallest_new) * rest.col(most).norm()) most = i;
      out.col(found) = rest.col(most).normalized();
      for (int twice = 0; twice < 2; ++twice) remove(out.col(found));
    }
    return out;
  }

private:
  Eigen::Index n_;
  std::vector<Vector> rows_;
};

/// The group that is these cells and no others.
std::string name_of(const Mesh& mesh, const std::vector<std::int32_t>& cells) {
  for (const auto& [name, group] : mesh.groups)
    if (group.kind == Group::Kind::cells && group.entities == cells) return name;
  return {};
}

std::string direction(const Vector& v) {
  constexpr const char* axes[] = {"x", "y", "z"};
  const Vector unit = v / v.norm();
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (std::abs(unit[i]) > 1.0 - not_told * not_told)
      return fmt::format("{}{}", unit[i] < 0.0 ? "-" : "", axes[i]);
  std::vector<double> rounded;
  for (const double x : unit) rounded.push_back(std::abs(x) < not_told ? 0.0 : x);
  return fmt::format("[{}]", joined(rounded, static_cast<int>(rounded.size()), 4));
}

/// A coordinate that is zero but for rounding.
double cut(double x, double size) { return std::abs(x) < not_told * size ? 0.0 : x; }

} // namespace

DenseMatrix kernel(const DenseMatrix& a, double small) {
  const Eigen::Index n = a.cols();
  DenseMatrix square = DenseMatrix::Zero(n, n);
  if (a.rows() > n)
    square = solve_by_qr(a, Vector::Zero(a.rows())).r;
  else
    square.topRows(a.rows()) = a;
  const auto found = left_singular(DenseMatrix(square.transpose()));
  const auto seen = (found.values.array() > small).count();
  return aligned(found.vectors.rightCols(n - seen));
}

MotionForces forces_of(const SparseMatrix& k, const DenseMatrix& motions) {
  return {k * motions, k.cwiseAbs() * motions.cwiseAbs()};
}

double mean_size(const DenseMatrix& sizes) {
  return sizes.norm() / std::sqrt(static_cast<double>(sizes.cols()));
}

RigidMotions::RigidMotions(const Discretisation& d, int unknown)
    : space_(&d.space), block_(d.space.blocks[static_cast<std::size_t>(unknown)]),
      components_(block_.components), per_piece_(amplitudes_per_piece(d.space, block_)) {
  const auto piece_of_cell = pieces_of(d.mesh);
  find_pieces(d, piece_of_cell);
  find_basis(d, piece_of_cell);
}

void RigidMotions::find_pieces(const Discretisation& d,
                               std::span<const std::int32_t> piece_of_cell) {
  const int n = 1 + *std::max_element(piece_of_cell.begin(), piece_of_cell.end());
  piece_of_node_.assign(d.space.nodes.size(), -1);
  pieces_.resize(static_cast<std::size_t>(n));
  std::vector<std::vector<std::int32_t>> cells(pieces_.size());
  std::vector<int> nodes(pieces_.size(), 0);
  for (int cell = 0; cell < n_cells(d.space); ++cell) {
    const auto piece = piece_of_cell[static_cast<std::size_t>(cell)];
    cells[static_cast<std::size_t>(piece)].push_back(cell);
    if (!block_.lives_in(cell)) continue; // a node that pieces share is of one that the unknown has
    for (const auto node : d.space.nodes_of_cell(cell)) {
      if (piece_of_node_[static_cast<std::size_t>(node)] >= 0) continue;
      piece_of_node_[static_cast<std::size_t>(node)] = piece;
      ++nodes[static_cast<std::size_t>(piece)];
    }
  }
  const auto piece_at = [&](std::size_t node) -> Piece& {
    return pieces_[static_cast<std::size_t>(piece_of_node_[node])];
  };
  const auto has_piece = [&](std::size_t node) { return piece_of_node_[node] >= 0; };
  for (std::size_t p = 0; p < d.space.nodes.size(); ++p)
    for (std::size_t i = 0; i < 3 && has_piece(p); ++i)
      piece_at(p).centre[i] +=
          d.space.nodes[p][i] / nodes[static_cast<std::size_t>(piece_of_node_[p])];
  for (std::size_t p = 0; p < d.space.nodes.size(); ++p) {
    if (!has_piece(p)) continue;
    const Point &x = d.space.nodes[p], &c = piece_at(p).centre;
    piece_at(p).size =
        std::max(piece_at(p).size, std::hypot(x[0] - c[0], x[1] - c[1], x[2] - c[2]));
  }
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const std::string name = n > 1 ? name_of(d.mesh, cells[k]) : std::string();
    pieces_[k].name = n == 1 ? "the body"
                      : name.empty()
                          ? "the piece around " + describe_point(pieces_[k].centre, d.mesh.dim)
                          : "the piece `" + name + "`";
  }
}

Vector RigidMotions::row(int piece, const Point& x, int c) const {
  Vector out = Vector::Zero(per_piece_);
  if (per_piece_ == 1) {
    out[0] = components_ == 1 || c == 1 ? 1.0 : 0.0;
    return out;
  }
  const Piece& of = pieces_[static_cast<std::size_t>(piece)];
  const auto arm = [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    return (x[k] - of.centre[k]) / of.size;
  };
  out[c] = 1.0;
  if (components_ == 2)
    out[2] = c == 0 ? -arm(1) : arm(0);
  else // w x arm
    out[3 + (c + 1) % 3] = arm((c + 2) % 3), out[3 + (c + 2) % 3] = -arm((c + 1) % 3);
  return out;
}

int RigidMotions::component_of(std::int32_t dof) const {
  if (dof < 0) return -1;
  const int c = dof % space_->components - block_.first;
  return c >= 0 && c < components_ && has_node(*space_, block_, dof / space_->components) ? c : -1;
}

void RigidMotions::find_basis(const Discretisation& d,
                              std::span<const std::int32_t> piece_of_cell) {
  const auto n = static_cast<int>(pieces_.size());
  const Eigen::Index size = Eigen::Index{per_piece_} * n;
  basis_.resize(size, 0);
  if (n > most_pieces) return;
  RowSpace conditions(size);
  std::vector<char> lives(pieces_.size(), 0);
  for (int cell = 0; cell < n_cells(d.space); ++cell)
    if (block_.lives_in(cell)) lives[static_cast<std::size_t>(piece_of_cell[cell])] = 1;
  for (int piece = 0; piece < n; ++piece)
    for (int k = 0; k < per_piece_ && lives[static_cast<std::size_t>(piece)] == 0; ++k)
      conditions.add(Vector::Unit(size, first(piece) + k)); // nothing moves there
  for (const auto& e : d.dofs.eliminated) {
    if (conditions.full()) return;
    const int c = component_of(e.dof);
    if (c < 0) continue;
    const auto node = static_cast<std::size_t>(e.dof / space_->components);
    Vector all = Vector::Zero(size);
    all.segment(first(piece_of_node_[node]), per_piece_) =
        row(piece_of_node_[node], d.space.nodes[node], c);
    if (!all.isZero(0.0)) conditions.add(std::move(all));
  }
  for (const DofLink& link : d.dofs.links) {
    if (conditions.full()) return;
    const int c = component_of(link.dof);
    if (c < 0) continue;
    Vector all = Vector::Zero(size);
    for (const auto& [dof, sign] : {std::pair(link.dof, 1.0), std::pair(link.to, -1.0)}) {
      const auto node = static_cast<std::size_t>(dof / space_->components);
      all.segment(first(piece_of_node_[node]), per_piece_) +=
          sign * row(piece_of_node_[node], d.space.nodes[node], c);
    }
    if (all.cwiseAbs().maxCoeff() > same_motion) conditions.add(std::move(all));
  }
  if (n > 1) {
    for (int cell = 0; cell < n_cells(d.space) && !conditions.full(); ++cell) {
      if (!block_.lives_in(cell)) continue;
      for (const auto node : d.space.nodes_of_cell(cell)) {
        const auto other = piece_of_node_[static_cast<std::size_t>(node)],
                   own = piece_of_cell[static_cast<std::size_t>(cell)];
        if (other == own) continue;
        if (!has_node(d.space, block_, node)) continue;
        const Point& x = d.space.nodes[static_cast<std::size_t>(node)];
        for (int c = 0; c < components_; ++c) {
          Vector all = Vector::Zero(size);
          all.segment(first(own), per_piece_) = row(own, x, c);
          all.segment(first(other), per_piece_) -= row(other, x, c);
          if (!all.isZero(0.0)) conditions.add(std::move(all));
        }
      }
    }
  }
  if (!conditions.full()) basis_ = conditions.kernel();
}

DenseMatrix RigidMotions::on(std::span<const std::int32_t> dofs) const {
  DenseMatrix out = DenseMatrix::Zero(static_cast<Eigen::Index>(dofs.size()), basis_.cols());
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const int c = component_of(dofs[i]);
    if (c < 0) continue;
    const auto node = static_cast<std::size_t>(dofs[i] / space_->components);
    const int piece = piece_of_node_[node];
    out.row(static_cast<Eigen::Index>(i)) = row(piece, space_->nodes[node], c).transpose() *
                                            basis_.middleRows(first(piece), per_piece_);
  }
  return out;
}

std::string RigidMotions::words(const Piece& piece, const Vector& a) const {
  if (components_ == 1) return fmt::format("a constant {} added", a[0] < 0.0 ? "< 0 is" : "is");
  if (per_piece_ == 1) return fmt::format("moves along {}y", a[0] < 0.0 ? "-" : "");
  const Vector shift = a.head(components_), turn = a.tail(per_piece_ - components_) / piece.size;
  const double spin = turn.norm();
  if (spin * piece.size <= not_told * shift.norm() || shift.norm() > far_away * spin * piece.size)
    return "moves along " + direction(shift);
  Point centre = piece.centre; // shift + turn x (centre - piece.centre) has no part across turn
  if (components_ == 2) {
    centre[0] = cut(centre[0] - shift[1] / turn[0], piece.size);
    centre[1] = cut(centre[1] + shift[0] / turn[0], piece.size);
    return fmt::format("turns about {}{}", describe_point(centre, 2),
                       turn[0] < 0.0 ? " clockwise" : "");
  }
  const double square = spin * spin;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double across = turn[j] * shift[k] - turn[k] * shift[j];
    auto& at = centre[static_cast<std::size_t>(i)];
    at = cut(at + across / square, piece.size);
  }
  const double along = turn.dot(shift) / spin;
  return fmt::format("turns about the line through {} along {}{}", describe_point(centre, 3),
                     direction(turn),
                     std::abs(along) > not_told * spin * piece.size ? ", moving along it" : "");
}

std::string RigidMotions::describe(const Vector& motion) const {
  const Vector all = basis_ * motion;
  double largest = 0.0;
  for (std::size_t k = 0; k < pieces_.size(); ++k)
    largest = std::max(largest, all.segment(first(static_cast<int>(k)), per_piece_).norm());
  std::vector<std::string> out;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Vector a = all.segment(first(static_cast<int>(k)), per_piece_);
    if (a.norm() > not_told * largest)
      out.push_back(components_ == 1 ? words(pieces_[k], a) + " to " + pieces_[k].name
                                     : pieces_[k].name + " " + words(pieces_[k], a));
  }
  const std::string of = space_->is_product() ? fmt::format("`{}`: ", block_.name) : std::string();
  return of + joined(out, " and ");
}

std::vector<RigidMotions> motions_of_unknowns(const Discretisation& d) {
  std::vector<RigidMotions> out;
  for (int b = 0; b < n_unknowns(d.space); ++b) {
    RigidMotions motions(d, b);
    if (motions.count() > 0) out.push_back(std::move(motions));
  }
  return out;
}

DenseMatrix resistance(const MotionForces& of, const Space& space,
                       std::span<const std::int32_t> dofs) {
  const Eigen::Index n = of.forces.rows();
  DenseMatrix out = DenseMatrix::Zero(n * n_unknowns(space), of.forces.cols());
  for (int b = 0; b < n_unknowns(space); ++b) {
    DenseMatrix sizes = DenseMatrix::Zero(n, of.sizes.cols());
    const auto is_of = [&](Eigen::Index row) {
      return space.block_of(dofs[static_cast<std::size_t>(row)] % space.components) == b;
    };
    for (Eigen::Index row = 0; row < n; ++row)
      if (is_of(row)) sizes.row(row) = of.sizes.row(row);
    const double size = mean_size(sizes);
    for (Eigen::Index row = 0; row < n && size > 0.0; ++row)
      if (is_of(row)) out.row(b * n + row) = of.forces.row(row) / size;
  }
  return out;
}

} // namespace hvi::solver
