// See pair_unknowns.hpp.
#include "solver/formulation/pair_unknowns.hpp"

#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hvi::solver {
namespace {

/// A point's own node counts at least this much in its jump.
constexpr double least_own = 0.1;
/// A row is one of the unknowns if this part of it is new.
constexpr double least_new = 0.3;
/// A free motion makes jumps of at least this part of it.
constexpr double least_jump = 1e-3;

/// Which point an unknown belongs to.
constexpr int nobody = -1, more_than_one = -2;

/// A point of a pair, which all law terms of the pair share.
struct JumpPoint {
  const ContactTerm* term; ///< the first one there
  int point;
  std::vector<std::pair<const ContactTerm*, int>> rows; ///< of all terms: their rows of G
};

/// Points of the first term on each pair; those of other terms there are the same, but for terms of
/// unknowns of another order.
std::vector<JumpPoint> points_of_pairs(const Problem& problem, const Contact& contact,
                                       std::vector<int>& point_of_row) {
  std::vector<JumpPoint> out;
  std::map<std::pair<int, std::size_t>, int> first_of; ///< by part and number of points
  point_of_row.assign(static_cast<std::size_t>(contact.n_rows()), more_than_one);
  for (const auto& term : contact.terms) {
    const LawTerm& spec = problem.law_terms[static_cast<std::size_t>(term.points.law_term)];
    if (!term.points.jump || spec.mean) continue;
    const auto [known, fresh] = first_of.try_emplace(std::pair(spec.part, term.points.x.size()),
                                                     static_cast<int>(out.size()));
    for (int p = 0; p < term.n_points(); ++p) {
      if (fresh) out.push_back({&term, p, {}});
      const int index = known->second + p;
      for (int r = 0; r < term.points.rows; ++r) {
        const int row = term.first_row + p * term.points.rows + r;
        out[static_cast<std::size_t>(index)].rows.emplace_back(&term, row);
        point_of_row[static_cast<std::size_t>(row)] = index;
      }
    }
  }
  return out;
}

/// By unknown: the point whose rows see it.
std::vector<int> owners(const Contact& contact, const std::vector<int>& point_of_row,
                        int n_unknowns) {
  std::vector<int> out(static_cast<std::size_t>(n_unknowns), nobody);
  for (int row = 0; row < contact.n_rows(); ++row)
    for (SparseMatrix::InnerIterator it(contact.g, row); it; ++it) {
      if (it.col() >= n_unknowns) continue;
      int& owner = out[static_cast<std::size_t>(it.col())];
      const int point = point_of_row[static_cast<std::size_t>(row)];
      owner = owner == nobody || owner == point ? point : more_than_one;
    }
  return out;
}

/// The unknowns of a point's own node, and the rows that become unknowns in their place.
struct Exchange {
  std::vector<int> own;  ///< unknowns
  std::vector<int> seen; ///< rows of G, independent on `own`
  DenseMatrix of_own;    ///< x = of_own u_own + what the rows have elsewhere
};

/// Of a row at the point's node, with the components that have imposed values.
double size_at_node(const Space& space, const ContactTerm& term, int row, const JumpPoint& point) {
  const auto node = point.term->points.node[static_cast<std::size_t>(point.point)];
  double square = 0.0;
  for (int c = 0; c < space.components; ++c)
    square += std::pow(term.points.g.coeff(row - term.first_row, space.dof(node, c)), 2);
  return std::sqrt(square);
}

/// What the rows of a point see of its own node; others complete them to a basis. Without rows:
/// nothing is exchanged.
Exchange make_exchange(const Space& space, const Contact& contact, const JumpPoint& point,
                       std::vector<int> own) {
  const auto n = static_cast<Eigen::Index>(own.size());
  Exchange out{std::move(own), {}, DenseMatrix(n, n)};
  DenseMatrix basis(n, 0);
  const auto add = [&](const Vector& part, double size) {
    Vector rest = part;
    for (int twice = 0; twice < 2; ++twice) rest -= basis * (basis.transpose() * rest);
    if (basis.cols() == n || !(rest.norm() > least_new * size)) return false;
    out.of_own.row(basis.cols()) = part.transpose();
    basis.conservativeResize(n, basis.cols() + 1);
    basis.col(basis.cols() - 1) = rest.normalized();
    return true;
  };
  for (const auto& [term, row] : point.rows) {
    Vector part(n);
    for (Eigen::Index i = 0; i < n; ++i)
      part[i] = contact.g.coeff(row, out.own[static_cast<std::size_t>(i)]);
    if (add(part, size_at_node(space, *term, row, point))) out.seen.push_back(row);
  }
  if (out.seen.empty()) return out;
  // In two passes, as the longest rests are the best conditioned.
  for (const double size : {2.0, 1e-3})
    for (Eigen::Index i = 0; i < n; ++i) add(Vector::Unit(n, i), size);
  return out;
}

class Exchanges {
public:
  explicit Exchanges(const Contact& contact) : contact_(contact) {}

  /// Rows of T and T^-1: x = M u_own + N u_others, so u_own = M^-1 (x - N u_others).
  void add(const Exchange& of) {
    const DenseMatrix back =
        solve_square(of.of_own, DenseMatrix::Identity(of.of_own.rows(), of.of_own.cols()));
    const auto n = static_cast<Eigen::Index>(of.own.size());
    for (Eigen::Index i = 0; i < n; ++i) {
      Rows& here = by_unknown_[of.own[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < n; ++j) {
        const int other = of.own[static_cast<std::size_t>(j)];
        here.of_t[other] += back(i, j);
        here.of_inverse[other] += of.of_own(i, j);
      }
    }
    for (std::size_t r = 0; r < of.seen.size(); ++r)
      for (SparseMatrix::InnerIterator it(contact_.g, of.seen[r]); it; ++it) {
        const auto column = static_cast<int>(it.col());
        if (column >= contact_.force.rows() || std::ranges::find(of.own, column) != of.own.end())
          continue;
        by_unknown_[of.own[r]].of_inverse[column] += it.value();
        for (Eigen::Index i = 0; i < n; ++i)
          by_unknown_[of.own[static_cast<std::size_t>(i)]].of_t[column] -=
              back(i, static_cast<Eigen::Index>(r)) * it.value();
      }
  }

  std::shared_ptr<const BasisChange> take(int n_unknowns) const {
    std::vector<int> replaced;
    std::vector<Eigen::Triplet<double>> of_t, of_inverse;
    for (const auto& [unknown, rows] : by_unknown_) {
      const auto r = static_cast<int>(replaced.size());
      replaced.push_back(unknown);
      for (const auto& [column, value] : rows.of_t)
        if (value != 0.0) of_t.emplace_back(r, column, value);
      for (const auto& [column, value] : rows.of_inverse)
        if (value != 0.0) of_inverse.emplace_back(r, column, value);
    }
    SparseMatrix t(static_cast<Eigen::Index>(replaced.size()), n_unknowns), inverse = t;
    t.setFromTriplets(of_t.begin(), of_t.end());
    inverse.setFromTriplets(of_inverse.begin(), of_inverse.end());
    return std::make_shared<const BasisChange>(std::move(replaced), std::move(t),
                                               std::move(inverse));
  }

private:
  struct Rows {
    std::map<int, double> of_t, of_inverse;
  };
  const Contact& contact_;
  std::map<int, Rows> by_unknown_;
};

/// The unknowns of a point's node in the blocks that its rows see; empty: others see them, too.
std::vector<int> own_unknowns(const Space& space, const StateLayout& layout, const JumpPoint& point,
                              int index, const std::vector<int>& owner) {
  const auto node = point.term->points.node[static_cast<std::size_t>(point.point)];
  if (!(point.term->points.jump->coeff(point.point, node) > least_own)) return {};
  std::vector<int> out;
  for (const auto& block : space.blocks) {
    std::vector<int> here;
    bool seen = false, shared = false;
    for (int c = 0; c < block.components; ++c) {
      const int entry = layout.entry_of[static_cast<std::size_t>(space.dof(node, block.first + c))];
      if (entry < 0 || entry >= layout.n_unknowns) continue;
      const int of = owner[static_cast<std::size_t>(entry)];
      shared = shared || (of != nobody && of != index);
      seen = seen || of == index;
      here.push_back(entry);
    }
    if (seen && !shared) out.insert(out.end(), here.begin(), here.end());
  }
  return out;
}

} // namespace

JumpUnknowns jumps_as_unknowns(const Problem& problem, const Space& space,
                               const StateLayout& layout, const Contact& contact) {
  JumpUnknowns out;
  std::vector<int> point_of_row;
  const auto points = points_of_pairs(problem, contact, point_of_row);
  if (points.empty()) return out;
  const auto owner = owners(contact, point_of_row, layout.n_unknowns);
  Exchanges exchanges(contact);
  for (std::size_t p = 0; p < points.size(); ++p) {
    auto own = own_unknowns(space, layout, points[p], static_cast<int>(p), owner);
    if (own.empty()) continue;
    const Exchange exchange = make_exchange(space, contact, points[p], std::move(own));
    if (exchange.seen.empty()) continue;
    exchanges.add(exchange);
    out.rows.insert(out.rows.end(), exchange.seen.begin(), exchange.seen.end());
  }
  if (!out.rows.empty()) out.change = exchanges.take(layout.n_unknowns);
  return out;
}

bool all_make_jumps(const FreeBody& free, const Contact& contact, const std::vector<int>& rows) {
  const DenseMatrix all = contact.g.leftCols(free.on_unknowns.rows()) * free.on_unknowns;
  const DenseMatrix jumps = all(rows, Eigen::all);
  return kernel(jumps, least_jump * std::sqrt(static_cast<double>(jumps.rows()))).cols() == 0;
}

} // namespace hvi::solver
