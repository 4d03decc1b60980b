// Random changes of the data by a unit in the last place; see rounding.hpp.
#include "solver/discrete/rounding.hpp"

#include "solver/linear/cholesky.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// The finaliser of the generator SplitMix64: every bit of the result depends on every one of x.
/// G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ULL;

/// Infinite where it is no number.
double growth_of(double answer, Eigen::Index size) {
  const double growth =
      std::numeric_limits<double>::epsilon() * answer * std::sqrt(static_cast<double>(size));
  return std::isfinite(growth) ? growth : std::numeric_limits<double>::infinity();
}

/// s_ij with its sign, and random integers that e_ij is made of.
struct RoundedEntry {
  double size;
  std::array<std::int16_t, n_samples> draws;
};

/// `sizes`: sqrt(|A_ii A_jj|); a_ij is not 0.
RoundedEntry rounded(double a_ij, double sizes, double unit) {
  const double value = std::abs(a_ij), least = std::min(value / unit, sizes);
  return {std::copysign(std::max(value, least), a_ij),
          std::bit_cast<std::array<std::int16_t, n_samples>>(
              mixed(std::bit_cast<std::uint64_t>(value) + golden))};
}

constexpr double of_draws = 0x1p-15;

} // namespace

double random_unit(std::uint64_t of, std::uint64_t sample) {
  const std::uint64_t bits = mixed(mixed(of + golden) + (sample + 1) * golden);
  return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-63;
}

void add_rounding(const SparseMatrix& a, const Vector& v, double unit, RoundingForces& forces,
                  Vector& size) {
  const double scale = unit * of_draws;
  const Vector size_of = a.diagonal().cwiseAbs().cwiseSqrt();
  for (int i = 0; i < a.rows(); ++i) {
    std::array<double, n_samples> sums{};
    double all = 0.0;
    for (SparseMatrix::InnerIterator it(a, i); it; ++it) {
      if (!(std::abs(it.value()) > 0.0)) continue;
      const double other = size_of[it.col() < size_of.size() ? it.col() : i]; // imposed: no row
      const auto [s_ij, draws] = rounded(it.value(), size_of[i] * other, unit);
      const double term = s_ij * v[it.col()];
      for (std::size_t s = 0; s < n_samples; ++s) sums[s] += draws[s] * term;
      all += std::abs(it.value() * v[it.col()]);
    }
    for (std::size_t s = 0; s < n_samples; ++s) forces[s][i] += scale * sums[s];
    size[i] += all;
  }
}

void add_rounding(const SymmetricBlocks& a, const Vector& v, double unit, RoundingForces& forces,
                  Vector& size) {
  const Vector size_of = a.diagonal().cwiseAbs().cwiseSqrt();
  a.for_entries([&](int i, int j, double a_ij) {
    if (!(std::abs(a_ij) > 0.0)) return;
    const auto [s_ij, draws] = rounded(a_ij, size_of[i] * size_of[j], unit);
    const double term = unit * of_draws * s_ij * v[j];
    for (std::size_t s = 0; s < n_samples; ++s) forces[s][i] += draws[s] * term;
    size[i] += std::abs(a_ij * v[j]);
  });
}

void rounding_of_rows(const OwnRows& rows, int matrix, std::span<const double> v,
                      std::span<const double> sizes, double unit, std::span<double> out) {
  const auto n = static_cast<std::size_t>(rows.rows());
  std::ranges::fill(out, 0.0);
  rows.for_entries(matrix, [&](int i, int j, double a_ij) {
    if (!(std::abs(a_ij) > 0.0)) return;
    const double other = sizes[j] > 0.0 ? sizes[j] : sizes[i]; // imposed: no row
    const auto [s_ij, draws] = rounded(a_ij, sizes[i] * other, unit);
    const double term = unit * of_draws * s_ij * v[j];
    for (std::size_t s = 0; s < n_samples; ++s) out[s * n + i] += draws[s] * term;
    out[n_samples * n + i] += std::abs(a_ij * v[j]);
  });
}

Vector growth_probe(const MatrixRows& k, const RowUnits& unit) {
  Vector b, d(k.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = 1.0 / unit[i];
  k.apply_magnitude(d, b);
  for (Eigen::Index i = 0; i < b.size(); ++i)
    if (random_unit(static_cast<std::uint64_t>(i), 0) < 0.0) b[i] = -b[i];
  return b;
}

Vector growth_probe(const SparseMatrix& k, const RowUnits& unit) {
  return growth_probe(HeldRows(k, {}), unit);
}

double rounding_growth(const Vector& b, const RowUnits& unit, const Vector& y, const Vector& r,
                       Factorisation& factor) {
  Vector x = Vector::Zero(factor.order().size()); // the interior has its solve: zeros cost none
  x.tail(r.size()) = r;
  factor.forward(x, Columns::all);
  const double energy = y.squaredNorm() + x.tail(r.size()).squaredNorm(); // b^T K^-1 b = |L^-1 b|^2
  double square = 0.0;
  for (Eigen::Index i = 0; i < b.size(); ++i) square += b[i] / unit[i] * (b[i] / unit[i]);
  return growth_of(energy / std::sqrt(square), b.size());
}

double rounding_growth(const SparseMatrix& k, const RowUnits& unit, Factorisation& factor) {
  if (lower_factor(factor) == nullptr) return rounding_growth(HeldRows(k, {}), unit, factor);
  const Vector b = growth_probe(k, unit);
  Vector x, r;
  forward(factor, b, x, r);
  return rounding_growth(b, unit, x.head(factor.order().interior), r, factor);
}

double rounding_growth(const MatrixRows& k, const RowUnits& unit, Factorisation& factor) {
  const Vector b = growth_probe(k, unit);
  Vector x;
  solve(factor, b, x);
  double largest = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) largest = std::max(largest, std::abs(x[i]) * unit[i]);
  return growth_of(std::isfinite(x.sum()) ? largest : x.sum(), b.size());
}

} // namespace hvi::solver
