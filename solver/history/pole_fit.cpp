// Least squares over poles: solve for coefficients, measure what each pole is worth, move the
// poles.
#include "solver/history/pole_fit.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Columns with unit norm, and where asked the derivatives by the pole parameters.
struct PoleFit::Scaled {
  MatrixXd basis;
  VectorXd scale;     ///< column = scale * raw column
  MatrixXd slopes[2]; ///< by (log) decay and by frequency, with the scale of the basis
};

std::size_t fields_of(const std::vector<Pole>& poles) {
  std::size_t count = 0;
  for (const Pole& p : poles) count += p.fields();
  return count;
}

PoleFit::PoleFit(const KernelSamples& samples, double tolerance, double cap)
    : samples_(samples), ridge_(tolerance / cap) {
  for (std::size_t i = 0; i < samples.lag.size(); ++i) {
    const double w = std::sqrt(2 * samples.weight[i] / samples.density(samples.lag[i]));
    row_weight_.push_back(w / samples.norm);
    right_.push_back(row_weight_.back() * samples.value[i]);
  }
}

PoleFit::Scaled PoleFit::columns(const std::vector<Pole>& poles, bool slopes) const {
  const auto rows = static_cast<Eigen::Index>(samples_.lag.size());
  const auto count = static_cast<Eigen::Index>(fields_of(poles));
  Scaled out{MatrixXd(rows, count), VectorXd(count), {}};
  if (slopes) out.slopes[0] = out.slopes[1] = MatrixXd::Zero(rows, count);
  Eigen::Index column = 0;
  for (const Pole& pole : poles) {
    for (std::size_t part = 0; part < pole.fields(); ++part, ++column) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        const double lag = samples_.lag[static_cast<std::size_t>(i)];
        const double e = row_weight_[static_cast<std::size_t>(i)] * std::exp(-pole.decay * lag);
        const double c = std::cos(pole.frequency * lag), s = std::sin(pole.frequency * lag);
        const double value = part == 0 ? e * c : e * s;
        out.basis(i, column) = value;
        if (!slopes) continue;
        // By log decay, which keeps decays positive; growing or constant poles stay where they are.
        out.slopes[0](i, column) = pole.decay > 0 ? -pole.decay * lag * value : 0.0;
        out.slopes[1](i, column) = lag * (part == 0 ? -e * s : e * c);
      }
      out.scale[column] = 1 / std::max(out.basis.col(column).norm(), 1e-280);
      out.basis.col(column) *= out.scale[column];
      if (!slopes) continue;
      out.slopes[0].col(column) *= out.scale[column];
      out.slopes[1].col(column) *= out.scale[column];
    }
  }
  return out;
}

/// min |B c - b|^2 + ridge^2 |c|^2 by QR.
PoleFit::Solution PoleFit::solve(const std::vector<Pole>& poles) const {
  const Scaled scaled = columns(poles, false);
  const Eigen::Index rows = scaled.basis.rows(), count = scaled.basis.cols();
  MatrixXd system(rows + count, count);
  system << scaled.basis, ridge_ * MatrixXd::Identity(count, count);
  VectorXd right = VectorXd::Zero(rows + count);
  right.head(rows) = Eigen::Map<const VectorXd>(right_.data(), rows);
  const Eigen::HouseholderQR<MatrixXd> qr(system);
  const VectorXd c = qr.solve(right);
  const MatrixXd inverse = qr.matrixQR().topRows(count).triangularView<Eigen::Upper>().solve(
      MatrixXd::Identity(count, count));
  Solution out{poles, {c.data(), c.data() + count}, {}, 0};
  out.residual = (system * c - right).norm();
  Eigen::Index column = 0;
  for (const Pole& pole : poles) {
    double loss = 0;
    for (std::size_t part = 0; part < pole.fields(); ++part, ++column) {
      loss += c[column] * c[column] / inverse.row(column).squaredNorm();
    }
    out.loss.push_back(loss);
  }
  return out;
}

PoleFit::Solution PoleFit::refine(Solution best, double target, int iterations) const {
  double damping = 1e-3;
  for (int iteration = 0; iteration < iterations && best.residual > target; ++iteration) {
    const Scaled s = columns(best.poles, true);
    const Eigen::Index rows = s.basis.rows(), fields = s.basis.cols();
    const auto poles = static_cast<Eigen::Index>(best.poles.size());
    const Eigen::Map<const VectorXd> c(best.coefficients.data(), fields);
    // Unknowns: coefficients, log decays, frequencies (in units of the decay or of 1/T).
    MatrixXd jacobian = MatrixXd::Zero(rows + fields + 2 * poles, fields + 2 * poles);
    jacobian.topLeftCorner(rows, fields) = s.basis;
    jacobian.block(rows, 0, fields, fields).diagonal().setConstant(ridge_);
    std::vector<double> unit(best.poles.size());
    Eigen::Index column = 0;
    for (Eigen::Index p = 0; p < poles; ++p) {
      const Pole& pole = best.poles[static_cast<std::size_t>(p)];
      unit[static_cast<std::size_t>(p)] = std::max(pole.decay, 1 / samples_.high);
      for (std::size_t part = 0; part < pole.fields(); ++part, ++column) {
        jacobian.col(fields + 2 * p).head(rows) += s.slopes[0].col(column) * c[column];
        if (pole.frequency == 0) continue;
        jacobian.col(fields + 2 * p + 1).head(rows) +=
            s.slopes[1].col(column) * (c[column] * unit[static_cast<std::size_t>(p)]);
      }
    }
    VectorXd right = VectorXd::Zero(jacobian.rows());
    right.head(rows) = Eigen::Map<const VectorXd>(right_.data(), rows) - s.basis * c;
    right.segment(rows, fields) = -ridge_ * c;
    bool improved = false;
    for (int attempt = 0; attempt < 4 && !improved; ++attempt) {
      for (Eigen::Index p = 0; p < 2 * poles; ++p) {
        const double size = jacobian.col(fields + p).head(rows).norm();
        jacobian(rows + fields + p, fields + p) = std::max(damping * size, 1e-3 * best.residual);
      }
      const VectorXd step = Eigen::HouseholderQR<MatrixXd>(jacobian).solve(right);
      std::vector<Pole> moved = best.poles;
      for (Eigen::Index p = 0; p < poles; ++p) {
        Pole& pole = moved[static_cast<std::size_t>(p)];
        pole.decay *= std::exp(std::clamp(step[fields + 2 * p], -1.0, 1.0));
        if (pole.frequency != 0) {
          pole.frequency += unit[static_cast<std::size_t>(p)] * step[fields + 2 * p + 1];
        }
      }
      Solution next = solve(moved);
      if (next.residual < best.residual) {
        improved = next.residual < 0.9995 * best.residual;
        best = std::move(next);
        damping *= 0.2;
        break;
      }
      damping *= 8;
    }
    if (!improved) break;
  }
  return best;
}

ExponentialTerms PoleFit::terms(const Solution& solution) const {
  const Scaled scaled = columns(solution.poles, false);
  ExponentialTerms terms;
  std::size_t column = 0;
  const auto coefficient = [&] {
    const double c =
        solution.coefficients[column] * scaled.scale[static_cast<Eigen::Index>(column)];
    ++column;
    return c;
  };
  for (const Pole& pole : solution.poles) {
    const double cosine = coefficient();
    ExponentialTerm term;
    term.lag_rate = {-pole.decay, 0};
    term.factor = cosine;
    if (pole.frequency == 0) {
      terms.push_back(term);
      continue;
    }
    // c cos + s sin = Re[(c - i s) e^{i f lag}]: half of it and its conjugate.
    term.lag_rate = {-pole.decay, pole.frequency};
    term.factor = 0.5 * Complex(cosine, -coefficient());
    terms.push_back(term);
    term.lag_rate = std::conj(term.lag_rate);
    term.factor = std::conj(term.factor);
    terms.push_back(term);
  }
  return terms;
}

} // namespace hvi::solver
