// Non-negative least squares on a dictionary of relaxation times; see prony_fit.hpp.
#include "solver/kernel/prony_fit.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double per_decade = 20;
/// Of longer tables only a part of the points, evenly spaced, is fitted; errors are those at all
/// points.
constexpr std::size_t most_fitted = 5000;

/// Relaxation times the points can tell apart; infinity stands for the constant.
std::vector<double> candidates(const std::vector<double>& x) {
  double gap = x.back() - x.front();
  const double slowest = 10 * gap;
  for (std::size_t i = 1; i < x.size(); ++i) gap = std::min(gap, x[i] - x[i - 1]);
  const double fastest = 0.5 * gap;
  const int count = static_cast<int>(std::ceil(per_decade * std::log10(slowest / fastest)));
  std::vector<double> times{std::numeric_limits<double>::infinity()};
  for (int i = 0; i <= count; ++i)
    times.push_back(fastest * std::pow(slowest / fastest, static_cast<double>(i) / count));
  return times;
}

/// The least squares solution on the columns in `passive`, zero elsewhere.
VectorXd solve_on(const MatrixXd& a, const VectorXd& b, const std::vector<Eigen::Index>& passive) {
  const MatrixXd part = a(Eigen::all, passive);
  const VectorXd x = part.colPivHouseholderQr().solve(b);
  VectorXd full = VectorXd::Zero(a.cols());
  for (std::size_t i = 0; i < passive.size(); ++i)
    full[passive[i]] = x[static_cast<Eigen::Index>(i)];
  return full;
}

/// From x towards z as far as no entry becomes negative; what reaches zero leaves `passive`.
void step_towards(VectorXd& x, const VectorXd& z, std::vector<Eigen::Index>& passive) {
  double share = 1;
  for (const auto j : passive)
    if (z[j] <= 0) share = std::min(share, x[j] / (x[j] - z[j]));
  x += share * (z - x);
  std::erase_if(passive, [&](Eigen::Index j) { return z[j] <= 0 && x[j] <= 1e-15 * x.maxCoeff(); });
}

/// min |a x - b|, x >= 0.
VectorXd non_negative_least_squares(const MatrixXd& a, const VectorXd& b) {
  VectorXd x = VectorXd::Zero(a.cols());
  std::vector<Eigen::Index> passive;
  const double small = 1e-12 * (a.transpose() * b).cwiseAbs().maxCoeff();
  for (Eigen::Index round = 0; round < 3 * a.cols(); ++round) {
    VectorXd gradient = a.transpose() * (b - a * x);
    for (const auto j : passive) gradient[j] = 0;
    Eigen::Index next = 0;
    if (gradient.maxCoeff(&next) <= small) break;
    passive.push_back(next);
    VectorXd z = solve_on(a, b, passive);
    if (z[next] <= 0) break; // its gradient was rounding
    while (!passive.empty() && z.minCoeff() <= 0 &&
           std::any_of(passive.begin(), passive.end(), [&](auto j) { return z[j] <= 0; })) {
      step_towards(x, z, passive);
      z = solve_on(a, b, passive);
    }
    x = z;
  }
  return x;
}

} // namespace

PronyFit fit_prony(const Table& table) {
  const auto& all = table.abscissae();
  const auto times = candidates(all);
  std::vector<double> x;
  for (std::size_t i = 0; i < all.size(); i += 1 + all.size() / most_fitted) x.push_back(all[i]);
  const auto rows = static_cast<Eigen::Index>(x.size()),
             columns = static_cast<Eigen::Index>(times.size());
  MatrixXd a(rows, columns);
  VectorXd b(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    b[i] = table.value(x[static_cast<std::size_t>(i)]);
    for (Eigen::Index j = 0; j < columns; ++j)
      a(i, j) = std::exp(-x[static_cast<std::size_t>(i)] / times[static_cast<std::size_t>(j)]);
  }
  const double sign = b.sum() < 0 ? -1.0 : 1.0;
  const VectorXd found = sign * non_negative_least_squares(a, sign * b);
  PronyFit fit;
  fit.series.constant = found[0];
  for (Eigen::Index j = 1; j < columns; ++j) {
    if (found[j] == 0) continue;
    fit.series.weights.push_back(found[j]);
    fit.series.times.push_back(times[static_cast<std::size_t>(j)]);
  }
  double size = std::numeric_limits<double>::min(), squares = 0;
  for (const double at : all) {
    const double value = table.value(at), off = std::abs(fit.series.value(at) - value);
    size = std::max(size, std::abs(value));
    fit.largest = std::max(fit.largest, off);
    squares += off * off;
  }
  fit.largest /= size;
  fit.mean = std::sqrt(squares / static_cast<double>(all.size())) / size;
  return fit;
}

} // namespace hvi::solver
