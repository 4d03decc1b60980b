// Random changes of the data by a unit in the last place; see rounding.hpp.
#include "solver/time/rounding.hpp"

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

} // namespace

double random_unit(std::uint64_t of, std::uint64_t sample) {
  const std::uint64_t bits = mixed(mixed(of + golden) + (sample + 1) * golden);
  return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-63;
}

void add_rounding(const SparseMatrix& a, const Vector& v, double unit, RoundingForces& forces,
                  Vector& size) {
  const double scale = unit * 0x1p-15;
  const Vector size_of = a.diagonal().cwiseAbs().cwiseSqrt();
  for (int i = 0; i < a.rows(); ++i) {
    std::array<double, n_samples> sums{};
    double all = 0.0;
    for (SparseMatrix::InnerIterator it(a, i); it; ++it) {
      const double value = std::abs(it.value());
      if (!(value > 0.0)) continue;
      const double other = size_of[it.col() < size_of.size() ? it.col() : i]; // imposed: no row
      const double least = std::min(value / unit, size_of[i] * other);
      const double term = std::copysign(std::max(value, least), it.value()) * v[it.col()];
      const auto draws = std::bit_cast<std::array<std::int16_t, n_samples>>(
          mixed(std::bit_cast<std::uint64_t>(value) + golden));
      for (std::size_t s = 0; s < n_samples; ++s) sums[s] += draws[s] * term;
      all += std::abs(it.value() * v[it.col()]);
    }
    for (std::size_t s = 0; s < n_samples; ++s) forces[s][i] += scale * sums[s];
    size[i] += all;
  }
}

double rounding_growth(const SparseMatrix& k, Factorisation& factor) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  const double n = static_cast<double>(k.rows());
  Vector b(k.rows()), x;
  for (int i = 0; i < k.rows(); ++i) {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) sum += std::abs(it.value());
    b[i] = random_unit(static_cast<std::uint64_t>(i), 0) < 0.0 ? -sum : sum;
  }
  double growth = 0.0;
  if (lower_factor(factor) != nullptr) { // b^T K^-1 b = |L^-1 b|^2 by a forward solve
    factor.order().gather(b, x);
    factor.forward(x, Columns::all);
    const int interior = factor.order().interior;
    const double energy =
        x.head(interior).squaredNorm() + x.tail(x.size() - interior).squaredNorm();
    growth = eps * energy * std::sqrt(n) / b.norm();
  } else {
    solve(factor, b, x);
    growth = eps * x.lpNorm<Eigen::Infinity>() * std::sqrt(n);
  }
  return std::isfinite(growth) ? growth : std::numeric_limits<double>::infinity();
}

} // namespace hvi::solver
