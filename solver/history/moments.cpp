// Chebyshev interpolation and moments on blocks of time; see moments.hpp.
#include "solver/history/moments.hpp"

#include "solver/history/fields.hpp"

#include <boost/math/quadrature/gauss.hpp>

#include <cmath>
#include <numbers>

namespace hvi::solver {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// T_0(x) .. T_{count-1}(x).
VectorXd chebyshev(int count, double x) { // count > 1
  VectorXd t(count);
  t[0] = 1, t[1] = x;
  for (int k = 2; k < count; ++k) t[k] = 2 * x * t[k - 1] - t[k - 2];
  return t;
}

double middle(const TimeBlock& block) { return 0.5 * (block.a + block.b); }
double half(const TimeBlock& block) { return 0.5 * (block.b - block.a); }

/// t - s with s = middle + half x, formed from the distance to the block's end.
double lag_of(const TimeBlock& block, double t, double x) {
  return (t - block.b) + half(block) * (1 - x);
}

} // namespace

ChebyshevMoments::ChebyshevMoments(int count) : count_(count), to_coefficients_(count, count) {
  for (int i = 0; i < count; ++i) nodes_.push_back(std::cos(std::numbers::pi * (i + 0.5) / count));
  for (int i = 0; i < count; ++i) {
    to_coefficients_.col(i) = chebyshev(count, nodes_[static_cast<std::size_t>(i)]) * (2.0 / count);
  }
  to_coefficients_.row(0) *= 0.5;
  for (int i = 0; i <= count; ++i) check_points_.push_back(std::cos(std::numbers::pi * i / count));
  to_checks_.resize(count + 1, count);
  for (int i = 0; i <= count; ++i) {
    to_checks_.row(i) =
        chebyshev(count, check_points_[static_cast<std::size_t>(i)]).transpose() * to_coefficients_;
  }
}

void ChebyshevMoments::add_nodes(const TimeBlock& block, double t,
                                 std::vector<double>& lags) const {
  for (const double x : nodes_) lags.push_back(lag_of(block, t, x));
}

void ChebyshevMoments::apply(const double* values, double* weights) const {
  Eigen::Map<VectorXd>(weights, count_).noalias() =
      to_coefficients_ * Eigen::Map<const VectorXd>(values, count_);
}

MatrixXd ChebyshevMoments::of_intervals(const TimeBlock& block, std::span<const double> times,
                                        int order) const {
  using Rule = boost::math::quadrature::gauss<double, 15>; // exact up to degree 29
  const auto intervals = static_cast<Eigen::Index>(times.size()) - 1;
  MatrixXd m = MatrixXd::Zero(count_, intervals + (order == 1 ? 1 : 0));
  for (Eigen::Index j = 0; j < intervals; ++j) {
    const double low = times[static_cast<std::size_t>(j)],
                 high = times[static_cast<std::size_t>(j) + 1];
    for (std::size_t p = 0; p < Rule::abscissa().size(); ++p) {
      for (const double sign : {-1.0, 1.0}) {
        if (p == 0 && sign < 0) continue; // the middle point once
        const double y = 0.5 * (1 + sign * Rule::abscissa()[p]);
        const double s = low + y * (high - low);
        const double w = 0.5 * Rule::weights()[p] * (high - low);
        const VectorXd t = chebyshev(count_, (s - middle(block)) / half(block));
        if (order == 0) {
          m.col(j) += w * t;
        } else {
          m.col(j) += w * (1 - y) * t;
          m.col(j + 1) += w * y * t;
        }
      }
    }
  }
  return m;
}

MatrixXd ChebyshevMoments::to_parent(const TimeBlock& child, const TimeBlock& parent) const {
  MatrixXd values(count_, count_); // T_k(x_parent) at the child's nodes
  for (int i = 0; i < count_; ++i) {
    const double s = middle(child) + half(child) * nodes_[static_cast<std::size_t>(i)];
    values.col(i) = chebyshev(count_, (s - middle(parent)) / half(parent));
  }
  return values * to_coefficients_.transpose();
}

double ChebyshevMoments::interpolation_error(const KernelFunction& kernel, const TimeBlock& block,
                                             double t) const {
  std::vector<double> lags;
  add_nodes(block, t, lags);
  for (const double x : check_points_) lags.push_back(lag_of(block, t, x));
  std::vector<double> q(lags.size());
  kernel.evaluate(t, lags, q);
  const Eigen::Map<const VectorXd> at_nodes(q.data(), count_),
      at_checks(q.data() + count_, count_ + 1);
  const VectorXd difference = to_checks_ * at_nodes - at_checks;
  return difference.allFinite() ? difference.cwiseAbs().maxCoeff()
                                : std::numeric_limits<double>::quiet_NaN();
}

void add_product(const MatrixXd& matrix, const double* source, double* target, std::size_t n) {
  std::vector<double> row(static_cast<std::size_t>(matrix.cols()));
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      row[static_cast<std::size_t>(j)] = matrix(k, j);
    add_combination(row, source, {target + static_cast<std::size_t>(k) * n, n});
  }
}

} // namespace hvi::solver
