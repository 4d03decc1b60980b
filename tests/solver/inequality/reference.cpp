// Bisection instead of Newton, one unknown or one point at a time, nothing shared with the solver
// but the law's graph; see reference.hpp.
#include "reference.hpp"

#include <Eigen/Cholesky>

#include <cmath>
#include <functional>

namespace hvi::solver::test {

namespace {

/// The z where a nondecreasing function with jumps crosses 0, to the last bit.
double crossing(const std::function<double(double)>& f, double start, double step) {
  double low = start, high = start;
  for (double d = step; f(low) > 0.0 && std::isfinite(low); d *= 2.0) low -= d;
  for (double d = step; f(high) < 0.0 && std::isfinite(high); d *= 2.0) high += d;
  for (int k = 0; k < 2000; ++k) {
    const double middle = low + (high - low) / 2.0;
    if (!(middle > low && middle < high)) break;
    (f(middle) < 0.0 ? low : high) = middle;
  }
  return std::abs(f(low)) < std::abs(f(high)) ? low : high;
}

double slope_at(const ReducedProblem& problem, const ContactPoint& p, double r) {
  const LawGraph& g = problem.graphs[p.graph];
  return problem.laws[p.law]->slope(g, piece_of(g, r), r);
}

/// The scalar slope of a law of one row, the radial ones continued as odd functions.
double odd_slope(const ReducedProblem& problem, const ContactPoint& p, double z) {
  if (!problem.laws[p.law]->spec().radial) return slope_at(problem, p, z);
  return z == 0.0 ? 0.0
                  : std::copysign(slope_at(problem, p, std::abs(z)),
                                  z * slope_at(problem, p, std::abs(z)));
}

bool separable(const ReducedProblem& problem) {
  for (int row = 0; row < problem.g.rows(); ++row) {
    int entries = 0;
    for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it) entries += it.value() != 0.0;
    if (entries > 1) return false;
  }
  for (const ContactPoint& p : problem.points)
    if (p.rows > 1) return false;
  return true;
}

/// Gauss-Seidel: each unknown in turn minimises the energy exactly, the others fixed.
bool gauss_seidel(const ReducedProblem& problem, const DenseMatrix& s, const Vector& r,
                  double tolerance, Vector& c) {
  struct Touch {
    const ContactPoint* point;
    double g;
  };
  std::vector<std::vector<Touch>> touches(static_cast<std::size_t>(c.size()));
  for (const ContactPoint& p : problem.points)
    for (SparseMatrix::InnerIterator it(problem.g, p.first_row); it; ++it)
      touches[static_cast<std::size_t>(it.col())].push_back({&p, it.value()});
  double scale = r.lpNorm<Eigen::Infinity>() / s.diagonal().maxCoeff() + 1e-300;
  for (int sweep = 0; sweep < 200000; ++sweep) {
    double change = 0.0;
    for (int i = 0; i < c.size(); ++i) {
      const double rest = s.row(i).dot(c) - s(i, i) * c[i] - r[i];
      const auto f = [&](double v) {
        double sum = s(i, i) * v + rest;
        for (const Touch& t : touches[static_cast<std::size_t>(i)]) {
          const double z = t.g * v + problem.offset[t.point->first_row];
          sum += t.point->weight * t.g * odd_slope(problem, *t.point, z);
        }
        return sum;
      };
      const double next = crossing(f, c[i], 1e-3 * scale + 1e-3 * std::abs(c[i]));
      change = std::max(change, std::abs(next - c[i]));
      c[i] = next;
    }
    scale = std::max(scale, c.lpNorm<Eigen::Infinity>());
    if (change <= tolerance * scale) return true;
  }
  return false;
}

/// Alternating directions on  S c - G^T W M z + G^T W lambda = r,  lambda in d jhat(v),  v = z.
bool alternating_directions(const ReducedProblem& problem, const DenseMatrix& s, const Vector& r,
                            double tolerance, Vector& c, Vector& xi) {
  const int rows = static_cast<int>(problem.g.rows());
  Vector weight(rows), m(rows), rho(rows);
  const double stiffness = s.diagonal().mean();
  for (const ContactPoint& p : problem.points) {
    const LawGraph& g = problem.graphs[p.graph];
    const double descent = problem.laws[p.law]->constants(g.x, g.t).m;
    if (!std::isfinite(descent)) return false;
    for (int k = p.first_row; k < p.first_row + p.rows; ++k)
      weight[k] = p.weight, m[k] = descent, rho[k] = stiffness / p.weight;
  }
  const DenseMatrix g = problem.g;
  const Vector wm = weight.cwiseProduct(m), wr = weight.cwiseProduct(rho);
  const DenseMatrix a =
      s - g.transpose() * wm.asDiagonal() * g + g.transpose() * wr.asDiagonal() * g;
  const Eigen::LLT<DenseMatrix> factor(a);
  if (factor.info() != Eigen::Success) return false;
  Vector v = g * c + problem.offset, lambda = xi + m.cwiseProduct(v), z = v;
  for (int k = 0; k < 500000; ++k) {
    const Vector inner = -wm.cwiseProduct(problem.offset) + weight.cwiseProduct(lambda) +
                         wr.cwiseProduct(problem.offset - v);
    c = factor.solve(r - g.transpose() * inner);
    z = g * c + problem.offset;
    const Vector before = v;
    for (const ContactPoint& p : problem.points) {
      const int f = p.first_row;
      const double q = rho[f], shift = m[f];
      const Vector y = q * z.segment(f, p.rows) + lambda.segment(f, p.rows);
      const bool radial = problem.laws[p.law]->spec().radial;
      const double size = radial ? y.norm() : y[0];
      const auto equation = [&](double t) {
        return (q + shift) * t + slope_at(problem, p, t) - size;
      };
      double t = 0.0;
      if (!radial || size > slope_at(problem, p, 0.0))
        t = crossing(equation, 0.0, std::abs(size) / q + 1e-12);
      if (radial)
        v.segment(f, p.rows) = size > 0.0 ? Vector(y * (t / size)) : Vector::Zero(p.rows);
      else
        v[f] = t;
    }
    lambda += rho.cwiseProduct(z - v);
    const double scale = v.lpNorm<Eigen::Infinity>() + z.lpNorm<Eigen::Infinity>() + 1e-300;
    const double error = (z - v).lpNorm<Eigen::Infinity>() + (v - before).lpNorm<Eigen::Infinity>();
    if (error <= tolerance * scale) {
      xi = lambda - m.cwiseProduct(v);
      return true;
    }
  }
  return false;
}

} // namespace

bool reference_solve(const ReducedProblem& problem, const DenseMatrix& s, const Vector& r,
                     double tolerance, InequalityState& state) {
  if (state.c.size() != s.rows()) state.c = Vector::Zero(s.rows());
  if (state.xi.size() != problem.g.rows()) state.xi = Vector::Zero(problem.g.rows());
  if (separable(problem)) return gauss_seidel(problem, s, r, tolerance, state.c);
  return alternating_directions(problem, s, r, tolerance, state.c, state.xi);
}

} // namespace hvi::solver::test
