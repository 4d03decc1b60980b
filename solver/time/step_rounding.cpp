// How far rounding may have moved the state of a run; see step.hpp. Asked for once, after the last
// step.
//
// The exact assembly differs from ours by dT_b, dT_ij = e_ij T_ij, and what a step leaves of its
// equation is r. To first order the state's error e obeys the equation of the run itself,
//
//   A e' + B e + sum_m E_m (R_m e) + H e = r - sum_b dT_b v_b,    v_b: all that acts on T_b,
//
// with H the slopes of the laws. Of r the vector itself is taken, for it is no random one: where d
// is rounded, or solved for with an approximate factor, r is large beside K times the error of d.
// The right-hand side is the same in all steps but for the size of
// the load, so e is at most what the largest one makes of the whole time as one step,
//
//   (K_w + H) e = r - sum_b dT_b v_b,    K_w: the matrix of that one step,
//
// which relaxes what the single steps add up. Only K of the last step has a factor; K_w is solved
// with it (whole_time.cpp), where that costs little beside the run. Else e is at most
// amplification x, where (K + H) x is that right-hand side and amplification =
// max_b gamma_b / gamma_b(w), gamma_b the coefficients of the base matrices. The number of steps
// bounds it, and is taken where a law softens.
//
// C. S. Kenney, A. J. Laub, M. S. Reese, Statistical condition estimation for linear systems, SIAM
// J. Sci. Comput. 19 (1998) 566-583: a few random e_ij show the size of every entry of e.
#include "solver/linear/condition_estimate.hpp"
#include "solver/time/rounding.hpp"
#include "solver/time/step.hpp"
#include "solver/time/whole_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace hvi::solver {
namespace {

constexpr double unit = std::numeric_limits<double>::epsilon();
/// A state is kept as the largest when it is so much larger than the last one that was.
constexpr double clearly_larger = 1.6;

/// Answers x of the last step's matrix to forces become those of the whole time; where `whole` is
/// null or finds none, `bound` times as large. By how much each of them has grown.
std::vector<double> grow(WholeTime* whole, std::span<const Vector> forces, int most, double bound,
                         std::vector<Vector>& x, std::vector<Vector>& xi) {
  std::vector<double> out;
  for (std::size_t s = 0; s < forces.size(); ++s) {
    const double before = x[s].norm();
    if (whole == nullptr || !whole->relax(forces[s], most, bound, x[s], xi[s])) {
      x[s] *= bound;
      xi[s] *= bound;
    }
    out.push_back(before > 0.0 ? std::max(1.0, x[s].norm() / before) : bound);
  }
  return out;
}

} // namespace

/// Keeps what acts on each base matrix while the state is the largest so far.
void Stepper::note_size() {
  const double size = u().lpNorm<Eigen::Infinity>();
  if (!(size > clearly_larger * largest_.size)) return;
  largest_.size = size;
  largest_.step = step();
  const auto& operators = formulation_->operators();
  largest_.on_base.resize(operators.bases.size());
  Vector& room = equation_.known; // of a state, and of the step before
  for (int b = 0; b < operators.n_bases(); ++b)
    evolution_.acting(operators.weights, b, largest_.on_base[static_cast<std::size_t>(b)], room);
}

/// int q_m(t_n, s) ds over the whole time, by memory.
std::vector<double> Stepper::memory_of_one() const {
  std::vector<double> out;
  for (const auto& history : plan_.histories)
    out.push_back(grid().is_static() ? 0.0
                                     : interval_integral(history.kernel.expression, t(), 0.0,
                                                         t() - grid().t(0), 0));
  return out;
}

double Stepper::amplification() const {
  if (grid().is_static() || step() == 0) return 1.0;
  const double steps = step();
  if (std::ranges::any_of(contact().softening, [](double m) { return m > 0.0; })) return steps;
  const Vector now = balance_.coefficients(step());
  const Vector whole =
      whole_coefficients(formulation_->operators(), t() - grid().t(0), memory_of_one());
  double most = 1.0;
  for (Eigen::Index b = 0; b < now.size(); ++b)
    if (now[b] != 0.0) {
      const double ratio = now[b] / whole[b];
      most = ratio > 0.0 ? std::max(most, ratio) : steps; // NaN: both are zero
    }
  return std::min(most, steps);
}

/// Keeps what an attempted step leaves of its equation while that is the most so far.
void Stepper::note_left_over(double error) {
  if (!(error > clearly_larger * left_over_.error)) return;
  left_over_.error = error;
  left_over_.force = trial_.gap;
  if (!contact().none()) left_over_.force.noalias() -= contact().force * xi();
}

/// Forces of random rounding, on the unknowns, and last what steps left of their equations;
/// `backward_error`: that of the worst. Where states hold contact unknowns only, the left forces on
/// the others are not known, and random ones of that size stand for them.
std::vector<Vector> Stepper::rounding_forces(double backward_error) {
  const bool whole = formulation_->whole();
  const auto n = Eigen::Index{formulation_->whole_layout().n_unknowns};
  RoundingForces random;
  random.fill(Vector::Zero(n));
  Vector room, load, size = Vector::Zero(n);
  for (int b = 0; b < formulation_->operators().n_bases(); ++b) {
    const Vector& acting = largest_.on_base[static_cast<std::size_t>(b)];
    add_rounding(formulation_->whole_base(b), formulation_->whole_state(acting, room), unit, random,
                 size);
  }
  if (whole) balance_.load(largest_.step, load);
  for (std::size_t s = 0; s < n_samples; ++s)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double more = whole ? unit * std::abs(load[i]) : backward_error * size[i];
      random[s][i] += more * random_unit(static_cast<std::uint64_t>(i), s + 100);
    }
  std::vector<Vector> out(random.begin(), random.end());
  if (whole && left_over_.error > 0.0)
    out.push_back(std::max(1.0, backward_error / left_over_.error) * left_over_.force);
  return out;
}

std::vector<ErrorSample> Stepper::rounding_errors(double backward_error) {
  StepMatrix* const matrix = solver_.matrices().latest();
  if (step() == 0 || largest_.step == 0 || matrix == nullptr) return {};
  const auto forces = rounding_forces(backward_error);
  const auto& operators = formulation_->operators();
  const Vector gamma = balance_.coefficients(step());
  InequalityState at = solver_.accepted();
  at.c.setZero();
  if (!contact().none()) prepare(formulation_->contact(), plan_, t(), u(), at.xi);
  std::vector<Vector> x, xi;
  const bool found = formulation_->respond(forces, *matrix, gamma, at, x, xi);
  const double bound = amplification();
  const auto memory = memory_of_one();
  if (contact().none()) xi.resize(forces.size());
  std::vector<double> growth(forces.size(), bound);
  if (found) {
    const int most = formulation_->whole() && bound >= 2.0
                         ? vectors_for_whole_time(operators.n_unknowns, contact().n_rows(), step())
                         : 0;
    std::optional<WholeTime> whole;
    if (most > 0)
      whole.emplace(operators, *matrix, at, formulation_->layout().n_state,
                    gamma - whole_coefficients(operators, t() - grid().t(0), memory));
    growth = grow(whole ? &*whole : nullptr, forces, most, bound, x, xi);
  }
  const StateLayout& layout = formulation_->whole_layout();
  Vector state = Vector::Zero(layout.n_state);
  std::vector<ErrorSample> out(forces.size());
  for (std::size_t s = 0; s < forces.size(); ++s) {
    auto& sample = out[s];
    sample.u = Vector::Zero(layout.n_dofs);
    if (found) {
      state.head(layout.n_unknowns) = x[s];
      layout.scatter(state, sample.u);
      if (!contact().none()) sample.xi = xi[s];
    } else { // the tangent has no factor: nothing is known
      sample.u.setConstant(std::numeric_limits<double>::infinity());
    }
    sample.rate = evolution_.scheme().factor(step(), 1) / growth[s];
    sample.memory = memory;
    if (s < n_samples) sample.share = 1.0 / n_samples;
  }
  return out;
}

double Stepper::condition() { return formulation_->condition(solver_.matrices().latest()); }

} // namespace hvi::solver
