// Is a step solved? See certificate.hpp.
#include "solver/time/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// Calls row(i, (force xi)_i) for every row i < n, in order; only contact rows have a force.
template <class Row>
void for_each_row(int n, std::span<const int> contact, const SparseMatrix& force, const Vector& xi,
                  const Row& row) {
  int next = 0;
  for (const int c : contact) {
    for (; next < c; ++next) row(next, 0.0);
    double reaction = 0.0;
    for (SparseMatrix::InnerIterator it(force, c); it; ++it) reaction += it.value() * xi[it.col()];
    row(next++, reaction);
  }
  for (; next < n; ++next) row(next, 0.0);
}

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

double equilibrium_error(const Vector& gap, const Vector& scale, const SparseMatrix& force,
                         const Vector& xi, Vector& work) {
  work = gap;
  if (xi.size() > 0) work.noalias() -= force * xi;
  double worst = 0;
  for (Eigen::Index i = 0; i < work.size(); ++i) {
    if (work[i] == 0.0) continue;
    // A row of zeros with a residual has no scale: its error is infinite, as is one that is NaN.
    const double error = std::abs(work[i]) / scale[i];
    worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
  }
  return worst;
}

double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& b,
                         std::span<const int> contact, const SparseMatrix& force, const Vector& xi,
                         Vector& gap) {
  const int* starts = k.outerIndexPtr();
  const int* columns = k.innerIndexPtr();
  const double* values = k.valuePtr();
  const double* x = d.data();
  double worst = 0.0;
  const auto row = [&](int i, double reaction) {
    const auto [sum, size] =
        row_sums(values + starts[i], columns + starts[i], starts[i + 1] - starts[i], x);
    gap[i] = b[i] - sum;
    const double error = std::abs(gap[i] - reaction);
    // Divides only where it is the worst so far; a NaN is worse than anything.
    if (!(error <= worst * (size + std::abs(b[i])))) {
      worst = error / (size + std::abs(b[i]));
      if (std::isnan(worst)) worst = std::numeric_limits<double>::infinity();
    }
  };
  for_each_row(static_cast<int>(k.rows()), contact, force, xi, row);
  return worst;
}

double equilibrium_error(const SparseMatrix& k, const Vector& diagonal, const Vector& kd,
                         const Vector& d, const Vector& b, std::span<const int> contact,
                         const SparseMatrix& force, const Vector& xi, Vector& gap) {
  double worst = 0.0;
  const auto row = [&](int i, double reaction) {
    gap[i] = b[i] - kd[i];
    const double error = std::abs(gap[i] - reaction), own = diagonal[i] * d[i];
    if (error <= worst * (std::abs(own) + std::abs(kd[i] - own) + std::abs(b[i]))) return;
    const int start = k.outerIndexPtr()[i], count = k.outerIndexPtr()[i + 1] - start;
    const double size =
        row_sums(k.valuePtr() + start, k.innerIndexPtr() + start, count, d.data()).size +
        std::abs(b[i]);
    if (error <= worst * size) return;
    worst = error / size;
    if (std::isnan(worst)) worst = std::numeric_limits<double>::infinity();
  };
  for_each_row(static_cast<int>(k.rows()), contact, force, xi, row);
  return worst;
}

namespace {

/// The largest entry of a term's rows.
double largest(const ContactTerm& term, const Vector& rows) {
  return term.n_rows() == 0 ? 0.0
                            : rows.segment(term.first_row, term.n_rows()).lpNorm<Eigen::Infinity>();
}

} // namespace

Inclusion inclusion_error(const Contact& contact, const Vector& u, const Vector& xi,
                          double tolerance, Vector& z) {
  Inclusion out;
  z = contact.offset;
  z.noalias() += contact.g * u;
  for (const auto& term : contact.terms) {
    const double snap = tolerance * largest(term, z), largest_xi = largest(term, xi);
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      const double scale = std::max(largest_xi, contact.scales[point.law]);
      const double distance = inclusion_distance(
          *contact.laws[point.law], contact.problem.graphs[point.graph], &z[point.first_row],
          &xi[point.first_row], point.rows, snap, out.worst * scale);
      if (distance == 0.0) continue;
      const double error = distance / scale;
      if (error <= out.worst) continue;
      out = {error, term.points.law_term, term.first_point + p};
    }
  }
  return out;
}

} // namespace hvi::solver
