// The 1-norm estimator of Higham and Tisseur; see condition_estimate.hpp.
#include "solver/linear/condition_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace hvi::solver {
namespace {

constexpr int block_columns = 2;
constexpr int most_iterations = 5; ///< two or three are usual

Vector signs_of(const Vector& y) {
  return y.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
}

bool parallel(const Vector& a, const Vector& b) {
  return std::abs(a.dot(b)) == static_cast<double>(a.size());
}

class Estimator {
public:
  Estimator(int n, const Operator& product, const Operator& transposed)
      : n_(n), product_(product), transposed_(transposed), used_(n, 0) {}

  double estimate() {
    std::vector<Vector> x = start();
    std::vector<int> at;
    int best = -1;
    for (int k = 0; k < most_iterations; ++k) {
      const auto y = products(x, product_);
      const auto [norm, where] = largest(y);
      if (!std::isfinite(norm)) return std::numeric_limits<double>::infinity();
      if (k > 0 && norm <= estimate_) break;
      estimate_ = norm;
      if (k > 0) best = at[where];
      if (!next_signs(y)) break;
      const Vector h = row_maxima(products(signs_, transposed_));
      at = unused(h);
      if (at.empty() || (best >= 0 && h.maxCoeff() == h[best])) break;
      x.clear();
      for (const int i : at) x.push_back(Vector::Unit(n_, i)), used_[i] = 1;
    }
    return estimate_;
  }

private:
  /// A column of ones, the others of random signs; each has the 1-norm 1.
  std::vector<Vector> start() {
    std::vector<Vector> x(std::min(block_columns, n_), Vector::Ones(n_));
    for (std::size_t j = 1; j < x.size(); ++j) x[j] = random_signs();
    for (Vector& column : x) column /= n_;
    return x;
  }

  Vector random_signs() {
    return Vector::NullaryExpr(n_, [&] { return (random_() & 1u) != 0 ? 1.0 : -1.0; });
  }

  static std::vector<Vector> products(const std::vector<Vector>& x, const Operator& product) {
    std::vector<Vector> y(x.size());
    for (std::size_t j = 0; j < x.size(); ++j) product(x[j], y[j]);
    return y;
  }

  static std::pair<double, std::size_t> largest(const std::vector<Vector>& y) {
    std::pair<double, std::size_t> out{-1.0, 0};
    for (std::size_t j = 0; j < y.size(); ++j)
      if (const double norm = y[j].lpNorm<1>(); !(norm <= out.first)) out = {norm, j};
    return out;
  }

  /// The signs of Y. False when they are those of the last iteration, up to the sign of a column:
  /// then nothing new can come. Columns parallel to another one are drawn anew.
  bool next_signs(const std::vector<Vector>& y) {
    const std::vector<Vector> before = std::move(signs_);
    signs_.clear();
    const auto known = [&](const Vector& s, const std::vector<Vector>& in) {
      return std::any_of(in.begin(), in.end(), [&](const Vector& t) { return parallel(s, t); });
    };
    bool fresh = before.empty();
    for (const Vector& column : y) {
      Vector s = signs_of(column);
      fresh = fresh || !known(s, before);
      for (int draw = 0; draw < 4 && (known(s, before) || known(s, signs_)); ++draw)
        s = random_signs();
      signs_.push_back(std::move(s));
    }
    return fresh;
  }

  /// max_j |Z_ij|
  static Vector row_maxima(const std::vector<Vector>& z) {
    Vector h = z.front().cwiseAbs();
    for (const Vector& column : z) h = h.cwiseMax(column.cwiseAbs());
    return h;
  }

  /// The rows with the largest h that no iteration used.
  std::vector<int> unused(const Vector& h) const {
    std::vector<int> order(n_);
    std::iota(order.begin(), order.end(), 0);
    std::erase_if(order, [&](int i) { return used_[i] != 0; });
    const auto count = std::min<std::ptrdiff_t>(block_columns, std::ssize(order));
    std::partial_sort(order.begin(), order.begin() + count, order.end(),
                      [&](int a, int b) { return h[a] > h[b]; });
    order.erase(order.begin() + count, order.end());
    return order;
  }

  int n_;
  const Operator &product_, &transposed_;
  std::vector<char> used_;
  std::vector<Vector> signs_;
  std::mt19937 random_{20000}; // a fixed seed
  double estimate_ = 0.0;
};

} // namespace

double norm_1(const SparseMatrix& a) {
  Vector sums = Vector::Zero(a.cols());
  for (int i = 0; i < a.rows(); ++i)
    for (SparseMatrix::InnerIterator it(a, i); it; ++it) sums[it.col()] += std::abs(it.value());
  return sums.size() > 0 ? sums.maxCoeff() : 0.0;
}

double estimate_norm_1(int n, const Operator& product, const Operator& transposed_product) {
  if (n == 0) return 0.0;
  return Estimator(n, product, transposed_product).estimate();
}

double estimate_condition(const SparseMatrix& k, Factorisation& factor) {
  return norm_1(k) *
         estimate_norm_1(
             static_cast<int>(k.rows()), [&](const Vector& b, Vector& x) { solve(factor, b, x); },
             [&](const Vector& b, Vector& x) { solve(factor, b, x, Columns::transposed); });
}

} // namespace hvi::solver
