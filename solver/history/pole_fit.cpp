// Least squares over poles: solve for coefficients, find by how much the residual would grow
// without each pole, move the poles.
#include "solver/history/pole_fit.hpp"

#include "solver/linear/dense.hpp"

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
        const double c = pole.frequency == 0 ? 1.0 : std::cos(pole.frequency * lag);
        const double s = pole.frequency == 0 ? 0.0 : std::sin(pole.frequency * lag);
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
  const auto [c, r] = solve_by_qr(system, right);
  const MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(count, count));
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

/// Which numbers of the poles may move: log decays of decaying poles, frequencies of pairs.
struct PoleFit::Free {
  std::size_t pole, first_column;
  bool frequency;
  double unit; ///< step length of a frequency
};

std::vector<PoleFit::Free> PoleFit::free_numbers(const std::vector<Pole>& poles) const {
  std::vector<Free> list;
  std::size_t column = 0;
  for (std::size_t p = 0; p < poles.size(); column += poles[p].fields(), ++p) {
    if (poles[p].decay > 0) list.push_back({p, column, false, 1.0});
    if (poles[p].frequency == 0) continue;
    list.push_back({p, column, true, std::max(poles[p].decay, 1 / samples_.high)});
  }
  return list;
}

/// Rows: weighted misfit, ridge, damping. Columns: coefficients, then the free numbers.
PoleFit::Linearised PoleFit::linearise(const Solution& at, const std::vector<Free>& free) const {
  const Scaled s = columns(at.poles, true);
  const Eigen::Index rows = s.basis.rows(), fields = s.basis.cols();
  const auto moves = static_cast<Eigen::Index>(free.size());
  const Eigen::Map<const VectorXd> c(at.coefficients.data(), fields);
  Linearised out{MatrixXd::Zero(rows + fields + moves, fields + moves),
                 VectorXd::Zero(rows + fields + moves), VectorXd(moves)};
  out.jacobian.topLeftCorner(rows, fields) = s.basis;
  out.jacobian.block(rows, 0, fields, fields).diagonal().setConstant(ridge_);
  for (Eigen::Index m = 0; m < moves; ++m) {
    const Free& f = free[static_cast<std::size_t>(m)];
    auto column = out.jacobian.col(fields + m).head(rows);
    for (std::size_t part = 0; part < at.poles[f.pole].fields(); ++part) {
      const auto i = static_cast<Eigen::Index>(f.first_column + part);
      column += s.slopes[f.frequency ? 1 : 0].col(i) * (c[i] * f.unit);
    }
    out.size[m] = column.norm();
  }
  out.right.head(rows) = Eigen::Map<const VectorXd>(right_.data(), rows) - s.basis * c;
  out.right.segment(rows, fields) = -ridge_ * c;
  return out;
}

/// The poles after one damped step (D. W. Marquardt, An algorithm for least-squares estimation of
/// nonlinear parameters, J. SIAM 11 (1963) 431-441); the coefficients are solved for again.
PoleFit::Solution PoleFit::stepped(const Solution& from, const std::vector<Free>& free,
                                   Linearised& system, double damping) const {
  const auto moves = static_cast<Eigen::Index>(free.size());
  const Eigen::Index fields = system.jacobian.cols() - moves;
  const Eigen::Index last = system.jacobian.rows() - moves;
  for (Eigen::Index m = 0; m < moves; ++m) {
    // A least damping: numbers that hardly change the residual must not move far.
    system.jacobian(last + m, fields + m) =
        std::max(damping * system.size[m], 1e-3 * from.residual);
  }
  const VectorXd step = solve_by_qr(system.jacobian, system.right).x;
  std::vector<Pole> moved = from.poles;
  for (Eigen::Index m = 0; m < moves; ++m) {
    const Free& f = free[static_cast<std::size_t>(m)];
    Pole& pole = moved[f.pole];
    if (f.frequency) {
      pole.frequency += f.unit * step[fields + m];
    } else {
      pole.decay *= std::exp(std::clamp(step[fields + m], -1.0, 1.0));
    }
  }
  return solve(moved);
}

PoleFit::Solution PoleFit::refine(Solution best, double target, int iterations) const {
  double damping = 1e-3;
  for (int iteration = 0; iteration < iterations && best.residual > target; ++iteration) {
    const auto free = free_numbers(best.poles);
    Linearised system = linearise(best, free);
    const double before = best.residual;
    for (int attempt = 0; attempt < 4; ++attempt) {
      Solution next = stepped(best, free, system, damping);
      if (next.residual < best.residual) {
        best = std::move(next);
        damping *= 0.2;
        break;
      }
      damping *= 8;
    }
    if (!(best.residual < 0.9995 * before)) break;
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
