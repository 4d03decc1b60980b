// Candidate poles: a real dictionary for kernels that decay, ESPRIT for those that oscillate.
#include "solver/history/pole_fit.hpp"
#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace hvi::solver {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int order = 60; ///< Hankel matrices of order + 1 rows

/// The exponentials in 2 order + 1 equidistant values at distance `step`: eigenvalues of the shift
/// on the signal space of the Hankel matrix (R. Roy, T. Kailath, ESPRIT - estimation of signal
/// parameters via rotational invariance techniques, IEEE Trans. Acoust. Speech Signal Process. 37
/// (1989) 984-995, for a single series and by least squares).
std::vector<Pole> esprit(const VectorXd& values, double step) {
  MatrixXd hankel(order + 1, order + 1);
  for (int i = 0; i <= order; ++i) hankel.col(i) = values.segment(i, order + 1);
  const auto [sigma, space] = left_singular(hankel);
  Eigen::Index rank = 0;
  while (rank < 28 && rank < order && sigma[rank] > 1e-11 * sigma[0]) ++rank;
  if (rank == 0) return {};
  const MatrixXd u = space.leftCols(rank);
  const MatrixXd shift = least_squares(MatrixXd(u.topRows(order)), MatrixXd(u.bottomRows(order)));
  std::vector<Pole> poles;
  for (const std::complex<double> value : eigenvalues(shift)) {
    if (value.imag() < 0 || std::abs(value) < 1e-7 || std::abs(value) > 1.02) continue;
    const std::complex<double> rate = std::log(value) / step;
    const bool real = std::abs(value.imag()) < 1e-9 && value.real() > 0;
    if (!real && value.imag() < 1e-9) continue; // alternating signs: nothing resolved
    poles.push_back({-rate.real(), real ? 0.0 : rate.imag()});
  }
  return poles;
}

std::size_t panels_within(const KernelSamples& samples, double low, double high) {
  const auto& ends = samples.panel_ends;
  return static_cast<std::size_t>(std::lower_bound(ends.begin(), ends.end(), high) -
                                  std::lower_bound(ends.begin(), ends.end(), low));
}

/// Distinct frequencies, the strongest spread first: within 2/window they are one.
std::vector<double> frequencies(const std::vector<Pole>& poles, double window) {
  std::vector<double> found;
  for (const Pole& p : poles) {
    if (p.frequency == 0 || p.decay > 0.2 * p.frequency + 10 / window) continue;
    const bool known = std::any_of(found.begin(), found.end(), [&](double f) {
      return std::abs(f - p.frequency) < 2 / window + 0.05 * f;
    });
    if (!known) found.push_back(p.frequency);
  }
  if (found.size() > 4) found.resize(4);
  return found;
}

} // namespace

std::vector<Pole> real_candidates(const KernelSamples& samples, double per_decade) {
  std::vector<Pole> poles{{0, 0}, {-1 / samples.high, 0}};
  const double slowest = 0.1 / samples.high, fastest = 40 / samples.low;
  const int count =
      std::max(2, static_cast<int>(std::ceil(per_decade * std::log10(fastest / slowest))));
  for (int i = 0; i <= count; ++i) {
    poles.push_back({slowest * std::pow(fastest / slowest, static_cast<double>(i) / count), 0});
  }
  return poles;
}

std::vector<Pole> window_candidates(const PreparedKernel& kernel, const KernelSamples& samples) {
  if (panels_within(samples, samples.low, samples.high) > 3 * order / 4) return {};
  const double step = (samples.high - samples.low) / (2 * order);
  VectorXd values(2 * order + 1);
  for (int i = 0; i <= 2 * order; ++i) values[i] = kernel.function(0.0, samples.low + step * i);
  return esprit(values, step);
}

std::vector<Pole> oscillating_candidates(const PreparedKernel& kernel,
                                         const KernelSamples& samples) {
  std::vector<Pole> poles;
  const auto poles_on = [&](double from, double window) {
    const double step = window / (2 * order);
    VectorXd values(2 * order + 1);
    for (int i = 0; i <= 2 * order; ++i) values[i] = kernel.function(0.0, from + step * i);
    const auto found = esprit(values, step);
    poles.insert(poles.end(), found.begin(), found.end());
    return found;
  };
  bool largest = true;
  for (double window = samples.high - samples.low; window > 8 * samples.low; window /= 4) {
    // Four samples per wave at least; a panel of the samples holds up to three waves.
    if (panels_within(samples, samples.low, samples.low + window) > order / 4) continue;
    poles_on(samples.low, window);
    if (!largest) continue;
    largest = false;
    // A wave may decay at any rate slower than this window shows. Its frequency is found best at
    // the end, where the faster terms have decayed.
    for (const double f : frequencies(poles_on(samples.high - window, window), window)) {
      for (double decay = 0.1 / samples.high; decay < f; decay *= 2) poles.push_back({decay, f});
    }
  }
  return poles;
}

} // namespace hvi::solver
