// See matrices.hpp.
#include "matrices.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <random>

namespace hvi::solver::test {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

SparseMatrix build(int n, const Triplets& entries) {
  SparseMatrix k(n, n);
  k.setFromTriplets(entries.begin(), entries.end());
  k.makeCompressed();
  return k;
}

/// Adds the P1 element matrix of lambda tr(e) I + 2 mu e on a simplex with D + 1 corners.
template <int D>
void add_element(const std::array<std::array<double, D>, D + 1>& corner,
                 const std::array<int, D + 1>& unknown, double lambda, double mu,
                 Triplets& entries) {
  Eigen::Matrix<double, D, D> edges;
  for (int i = 0; i < D; ++i)
    for (int j = 0; j < D; ++j) edges(i, j) = corner[i + 1][j] - corner[0][j];
  const double volume = std::abs(edges.determinant()) / (D == 2 ? 2.0 : 6.0);
  Eigen::Matrix<double, D, D + 1> gradient;
  gradient.template rightCols<D>() = edges.inverse();
  gradient.col(0) = -gradient.template rightCols<D>().rowwise().sum();
  for (int a = 0; a <= D; ++a)
    for (int b = 0; b <= D; ++b) {
      if (unknown[a] < 0 || unknown[b] < 0) continue;
      const double dot = gradient.col(a).dot(gradient.col(b));
      for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
          entries.emplace_back(unknown[a] + i, unknown[b] + j,
                               volume * (lambda * gradient(i, a) * gradient(j, b) +
                                         mu * gradient(j, a) * gradient(i, b) +
                                         (i == j ? mu * dot : 0.0)));
    }
}

} // namespace

Problem slab(int n, double lambda, double mu) {
  const int across = 2 * n + 1;
  const double h = 1.0 / n;
  const auto unknown = [&](int i, int j) { return j == n ? -1 : 2 * (j * across + i); };
  Triplets entries;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < 2 * n; ++i)
      for (const auto& [di, dj] : {std::pair{1, 0}, std::pair{0, 1}})
        add_element<2>({{{i * h, j * h}, {(i + di) * h, (j + dj) * h}, {(i + 1) * h, (j + 1) * h}}},
                       {unknown(i, j), unknown(i + di, j + dj), unknown(i + 1, j + 1)}, lambda, mu,
                       entries);
  Problem problem{build(2 * across * n, entries), {}};
  for (int c = 0; c < 2 * across; ++c) problem.contact.push_back(c);
  return problem;
}

Problem cube(int n, double lambda, double mu) {
  const int across = n + 1;
  const double h = 1.0 / n;
  using Node = std::array<int, 3>;
  const auto unknown = [&](const Node& p) {
    return p[2] == n ? -1 : 3 * ((p[2] * across + p[1]) * across + p[0]);
  };
  Triplets entries;
  for (int cell = 0; cell < n * n * n; ++cell) {
    std::array<int, 3> axis{0, 1, 2};
    do {
      std::array<std::array<double, 3>, 4> corner{};
      std::array<int, 4> at{};
      Node p{cell % n, cell / n % n, cell / n / n};
      for (int v = 0; v < 4; ++v) {
        if (v > 0) ++p[axis[v - 1]];
        for (int d = 0; d < 3; ++d) corner[v][d] = p[d] * h;
        at[v] = unknown(p);
      }
      add_element<3>(corner, at, lambda, mu, entries);
    } while (std::next_permutation(axis.begin(), axis.end()));
  }
  Problem problem{build(3 * across * across * n, entries), {}};
  for (int c = 0; c < 3 * across * across; ++c) problem.contact.push_back(c);
  return problem;
}

SparseMatrix grid_laplacian(int n, double shift) {
  Triplets entries;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int at = j * n + i;
      entries.emplace_back(at, at, 4.0 + shift);
      if (i > 0) entries.emplace_back(at, at - 1, -1.0);
      if (i + 1 < n) entries.emplace_back(at, at + 1, -1.0);
      if (j > 0) entries.emplace_back(at, at - n, -1.0);
      if (j + 1 < n) entries.emplace_back(at, at + n, -1.0);
    }
  return build(n * n, entries);
}

SparseMatrix random_definite(int n, double density, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0), chance(0.0, 1.0);
  std::vector<double> row_sum(static_cast<std::size_t>(n), 0.1);
  Triplets entries;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      if (chance(random) > density) continue;
      const double entry = value(random);
      entries.emplace_back(i, j, entry);
      entries.emplace_back(j, i, entry);
      row_sum[i] += std::abs(entry);
      row_sum[j] += std::abs(entry);
    }
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, row_sum[i]);
  return build(n, entries);
}

SparseMatrix with_skew_part(const SparseMatrix& k, double factor, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-factor, factor);
  SparseMatrix result = k;
  for (int row = 0; row < k.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(k, row); entry; ++entry) {
      if (entry.col() >= row) continue;
      const double skew = value(random);
      result.coeffRef(row, entry.col()) += skew;
      result.coeffRef(entry.col(), row) -= skew;
    }
  return result;
}

SparseMatrix side_by_side(const SparseMatrix& a, const SparseMatrix& b) {
  Triplets entries;
  const int shift = static_cast<int>(a.rows());
  for (int row = 0; row < a.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(a, row); entry; ++entry)
      entries.emplace_back(row, entry.col(), entry.value());
  for (int row = 0; row < b.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(b, row); entry; ++entry)
      entries.emplace_back(row + shift, entry.col() + shift, entry.value());
  return build(shift + static_cast<int>(b.rows()), entries);
}

Vector random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  return Vector::NullaryExpr(n, [&] { return value(random); });
}

double largest_error(const Vector& a, const Vector& b) {
  return (a - b).cwiseQuotient(b).lpNorm<Eigen::Infinity>();
}

} // namespace hvi::solver::test
