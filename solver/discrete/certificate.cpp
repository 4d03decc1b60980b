// Is a step solved? See certificate.hpp.
#include "solver/discrete/certificate.hpp"

#include "solver/inequality/shared_scales.hpp"
#include "solver/linear/matrix_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hvi::solver {

namespace {

struct RowSums {
  double sum = 0.0, size = 0.0; ///< of the products, and of their absolute values
};

RowSums row_sums(const double* values, const int* columns, int count, const double* x) {
  double sum[4] = {}, size[4] = {};
  int e = 0;
  for (; e + 4 <= count; e += 4)
    for (int k = 0; k < 4; ++k) {
      const double product = values[e + k] * x[columns[e + k]];
      sum[k] += product;
      size[k] += std::abs(product);
    }
  for (; e < count; ++e) {
    const double product = values[e] * x[columns[e]];
    sum[0] += product;
    size[0] += std::abs(product);
  }
  return {(sum[0] + sum[1]) + (sum[2] + sum[3]), (size[0] + size[1]) + (size[2] + size[3])};
}

/// (force xi)_i and (|force| |xi|)_i
RowSums reaction_of(const SparseMatrix& force, int i, const Vector& xi) {
  RowSums out;
  for (SparseMatrix::InnerIterator it(force, i); it; ++it) {
    const double term = it.value() * xi[it.col()];
    out.sum += term;
    out.size += std::abs(term);
  }
  return out;
}

/// Calls row(i, reaction) for every row i < n, in order; only contact rows have a force.
template <class Row>
void for_each_row(int n, std::span<const int> contact, const SparseMatrix& force, const Vector& xi,
                  const Row& row) {
  int next = 0;
  for (const int c : contact) {
    for (; next < c; ++next) row(next, RowSums{});
    row(next++, reaction_of(force, c, xi));
  }
  for (; next < n; ++next) row(next, RowSums{});
}

/// The worst of all rows' errors.
class WorstRow {
public:
  WorstRow(std::function<double(int)> whole_size, const Reactions& reactions, const Vector& xi)
      : whole_size_(std::move(whole_size)), xi_(xi), force_(reactions.force),
        several_(!reactions.of_unknown.empty()),
        largest_xi_(xi.size() > 0 ? xi.lpNorm<Eigen::Infinity>() : 0.0) {}
  /// Divides only where it is the worst so far; a NaN is worse than anything. A residual without
  /// any scale has an infinite error.
  void take(int i, double residual, double size) {
    if (residual <= worst_ * size) return;
    size += part_of_turned_row * whole_scale(i);
    if (residual <= worst_ * size) return;
    worst_ = residual / size;
    if (std::isnan(worst_)) worst_ = std::numeric_limits<double>::infinity();
  }
  double worst() const { return worst_; }

private:
  /// K_ii max |d_j| over the row's columns + sum |force_ij| max |xi|: the size of the row's terms
  /// with rotated axes. Entries of K are sums over elements, known up to rounding of the diagonal,
  /// and components of a multiplier up to rounding of its norm: a row where nothing acts holds
  /// rounding of the others, and which rows these are depends on the axes. Of several unknowns each
  /// has its own size and multipliers.
  double whole_scale(int i) const {
    const double of_body = whole_size_(i);
    if (several_) return of_body + reaction_of(force_, i, xi_).size;
    double weight = 0.0;
    if (largest_xi_ > 0.0)
      for (SparseMatrix::InnerIterator it(force_, i); it; ++it) weight += std::abs(it.value());
    return of_body + weight * largest_xi_;
  }

  std::function<double(int)> whole_size_;
  const Vector& xi_;
  const SparseMatrix& force_;
  bool several_;
  double largest_xi_;
  double worst_ = 0.0;
};

} // namespace

void subtract_product(const SparseMatrix& a, const Vector& x, Vector& y) {
  const int* starts = a.outerIndexPtr();
  const int* columns = a.innerIndexPtr();
  const double* values = a.valuePtr();
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    double sum[4] = {};
    int e = starts[i];
    for (; e + 4 <= starts[i + 1]; e += 4)
      for (int k = 0; k < 4; ++k) sum[k] += values[e + k] * x[columns[e + k]];
    for (; e < starts[i + 1]; ++e) sum[0] += values[e] * x[columns[e]];
    y[i] -= (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

void gap_and_scale(const SparseMatrix& k, const Vector& d, const Vector& b, Vector& gap,
                   Vector& scale) {
  const int* starts = k.outerIndexPtr();
  const int* columns = k.innerIndexPtr();
  const double* values = k.valuePtr();
  const double* x = d.data();
  for (Eigen::Index i = 0; i < k.rows(); ++i) {
    double sum = 0, size = 0;
    for (int e = starts[i]; e < starts[i + 1]; ++e) {
      const double product = values[e] * x[columns[e]];
      sum += product;
      size += std::abs(product);
    }
    gap[i] = b[i] - sum;
    scale[i] = size + std::abs(b[i]);
  }
}

double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& gap,
                         const Vector& scale, const Reactions& reactions, const Vector& xi) {
  const HeldRows rows(k, reactions.of_unknown);
  return equilibrium_error(rows.whole_sizes(d), gap, scale, reactions, xi);
}

double equilibrium_error(const std::function<double(int)>& whole_size, const Vector& gap,
                         const Vector& scale, const Reactions& reactions, const Vector& xi) {
  WorstRow worst(whole_size, reactions, xi);
  for (int i = 0; i < gap.size(); ++i) {
    const auto reaction = xi.size() > 0 ? reaction_of(reactions.force, i, xi) : RowSums{};
    worst.take(i, std::abs(gap[i] - reaction.sum), scale[i] + reaction.size);
  }
  return worst.worst();
}

double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& b,
                         std::span<const int> contact, const Reactions& reactions, const Vector& xi,
                         Vector& gap) {
  const int* starts = k.outerIndexPtr();
  const int* columns = k.innerIndexPtr();
  const double* values = k.valuePtr();
  const double* x = d.data();
  const HeldRows held(k, reactions.of_unknown);
  WorstRow worst(held.whole_sizes(d), reactions, xi);
  for_each_row(
      static_cast<int>(k.rows()), contact, reactions.force, xi, [&](int i, RowSums reaction) {
        const auto [sum, size] =
            row_sums(values + starts[i], columns + starts[i], starts[i + 1] - starts[i], x);
        gap[i] = b[i] - sum;
        worst.take(i, std::abs(gap[i] - reaction.sum), size + std::abs(b[i]) + reaction.size);
      });
  return worst.worst();
}

double equilibrium_error(const SparseMatrix& k, const Vector& diagonal, const Vector& kd,
                         const Vector& d, const Vector& b, std::span<const int> contact,
                         const Reactions& reactions, const Vector& xi, Vector& gap) {
  const HeldRows held(k, reactions.of_unknown);
  WorstRow worst(held.whole_sizes(d), reactions, xi);
  for_each_row(
      static_cast<int>(k.rows()), contact, reactions.force, xi, [&](int i, RowSums reaction) {
        gap[i] = b[i] - kd[i];
        const double error = std::abs(gap[i] - reaction.sum), own = diagonal[i] * d[i];
        const double others = std::abs(b[i]) + reaction.size;
        if (error <= worst.worst() * (std::abs(own) + std::abs(kd[i] - own) + others)) return;
        const int start = k.outerIndexPtr()[i], count = k.outerIndexPtr()[i + 1] - start;
        const double size =
            row_sums(k.valuePtr() + start, k.innerIndexPtr() + start, count, d.data()).size;
        worst.take(i, error, size + others);
      });
  return worst.worst();
}

/// And a part of the largest: where nothing acts, the displacement is rounding of the others.
void find_reach(const Vector& diagonal, const Vector& kd, const Vector& d, const Vector& b,
                Contact& contact) {
  contact.reach.setZero(contact.g.cols());
  ByUnknown largest{};
  for (Eigen::Index c = 0; c < diagonal.size(); ++c) {
    const int i = contact.loaded[static_cast<std::size_t>(c)];
    const double own = std::abs(diagonal[c]);
    contact.reach[i] = std::abs(d[i]);
    if (own > 0.0) contact.reach[i] += (std::abs(kd[i] - own * d[i]) + std::abs(b[i])) / own;
    double& most = largest[contact.unknown_of(i)];
    most = std::max(most, contact.reach[i]);
  }
  for (const int i : contact.loaded)
    contact.reach[i] += part_of_largest_reach * largest[contact.unknown_of(i)] +
                        contact.least_reach[contact.unknown_of(i)];
}

namespace {

/// The largest entry of a term's rows.
double largest(const ContactTerm& term, const Vector& rows) {
  return term.n_rows() == 0 ? 0.0
                            : rows.segment(term.first_row, term.n_rows()).lpNorm<Eigen::Infinity>();
}

} // namespace

double argument_scale(const Contact& contact, const ContactTerm& term, const ContactPoint& point,
                      const LawFields& fields) {
  double largest = 0.0;
  for (int row = point.first_row; row < point.first_row + point.rows; ++row) {
    double size = std::abs(contact.offset[row]);
    term.for_seen(row - point.first_row, [&](int field, double times) {
      const Vector& values = fields[field];
      const double factor = fields.factor(field);
      for (SparseMatrix::InnerIterator it(contact.g, row); it; ++it)
        size += std::abs(times * it.value()) *
                (std::abs(values[it.col()]) + factor * contact.reach[it.col()]);
    });
    largest = std::max(largest, size);
  }
  return largest;
}

double multiplier_scale(const Contact& contact, const ContactTerm& term, const LawFields& fields,
                        const Vector& xi) {
  double out = largest(term, xi);
  if (contact.reach.size() != contact.g.cols()) return out; // not known yet
  for (int p = 0; p < term.n_points(); ++p) {
    const auto& point = contact.problem.points[static_cast<std::size_t>(term.first_point + p)];
    const Law& law = *contact.laws[point.law];
    const LawGraph& graph = contact.problem.graphs[point.graph];
    const double size = argument_scale(contact, term, point, fields);
    double made = 0.0; // within pieces: a jump is no rounding
    for (int i = 0; i < graph.pieces(); ++i) {
      const double low = std::max(piece_low(graph, i, law.spec().radial), -size),
                   high = std::min(piece_high(graph, i), size);
      if (!(low < high)) continue;
      const double change = std::abs(law.slope(graph, i, high) - law.slope(graph, i, low));
      if (change < unbounded_slope) made += change;
    }
    out = std::max(out, made);
  }
  return out;
}

Inclusion inclusion_error(const Contact& contact, const LawFields& fields, const Vector& xi,
                          double tolerance, Vector& z) {
  Inclusion out;
  z = contact.offset;
  add_arguments(contact, fields, z);
  for (const auto& term : contact.terms) {
    const double largest_xi = largest(term, xi);
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      const double scale = std::max(largest_xi, contact.scales[point.law]);
      const double distance = inclusion_distance(
          *contact.laws[point.law], contact.problem.graphs[point.graph], &z[point.first_row],
          &xi[point.first_row], point.rows,
          tolerance * argument_scale(contact, term, point, fields), out.worst * scale);
      if (distance == 0.0) continue;
      const double error = distance / scale;
      if (error <= out.worst) continue;
      out = {error, term.points.law_term, term.first_point + p};
    }
  }
  return out;
}

} // namespace hvi::solver
