// How far rounding may have moved the state of a run; see rounding_estimate.hpp. Samples are asked
// for once, after the last step.
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
// max_b gamma_b / gamma_b(w), gamma_b the coefficients of the base matrices. The number of steps,
// with u'' its square, bounds it, and is taken where a law softens or acts on a rate.
//
// C. S. Kenney, A. J. Laub, M. S. Reese, Statistical condition estimation for linear systems, SIAM
// J. Sci. Comput. 19 (1998) 566-583: a few random e_ij show the size of every entry of e.
#include "solver/step/rounding_estimate.hpp"

#include "solver/formulation/whole_time.hpp"
#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
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

RoundingEstimate::RoundingEstimate(const Problem& problem, Formulation& formulation,
                                   const Evolution& evolution, const Balance& balance)
    : problem_(problem), formulation_(formulation), evolution_(evolution), balance_(balance) {
  left_over_.force = Vector::Zero(formulation.layout().n_unknowns);
}

void RoundingEstimate::note(double error, const Vector& gap, const Vector& xi, Vector& room) {
  if (error > clearly_larger * left_over_.error) {
    const Contact& contact = formulation_.contact();
    left_over_.error = error;
    left_over_.force = gap;
    if (!contact.none()) left_over_.force.noalias() -= contact.force * xi;
  }
  note_size(room);
}

/// Keeps what acts on each base matrix while the state is the largest so far.
void RoundingEstimate::note_size(Vector& room) {
  const double size = evolution_.u().lpNorm<Eigen::Infinity>();
  if (!(size > clearly_larger * largest_.size)) return;
  largest_.size = size;
  largest_.step = evolution_.step();
  const auto& operators = formulation_.operators();
  largest_.on_base.resize(operators.bases.size());
  for (int b = 0; b < operators.n_bases(); ++b)
    evolution_.acting(operators.weights, b, largest_.on_base[static_cast<std::size_t>(b)], room);
}

/// int q_m(t_n, s) ds over the whole time, by memory.
std::vector<double> RoundingEstimate::memory_of_one() const {
  const auto& grid = evolution_.grid();
  const double t = evolution_.t();
  std::vector<double> out;
  for (const auto& history : problem_.histories)
    out.push_back(grid.is_static()
                      ? 0.0
                      : interval_integral(history.kernel.expression, t, 0.0, t - grid.t(0), 0));
  return out;
}

/// Those of the base matrices, were the time one step.
Vector RoundingEstimate::coefficients_of_one() const {
  return whole_coefficients(formulation_.operators(), evolution_.t() - evolution_.grid().t(0),
                            memory_of_one());
}

double RoundingEstimate::amplification() const {
  if (evolution_.grid().is_static() || evolution_.step() == 0) return 1.0;
  // Errors of velocities add up, too.
  const double n = evolution_.step(), steps = in_motion(problem_) ? n * n : n;
  // A law on a rate is stiffer in one step than over the whole time.
  if (!formulation_.contact().other_fields.empty() ||
      std::ranges::any_of(formulation_.contact().softening, [](double m) { return m > 0.0; }))
    return steps;
  const Vector now = balance_.coefficients(evolution_.step()), whole = coefficients_of_one();
  double most = 1.0;
  for (Eigen::Index b = 0; b < now.size(); ++b)
    if (now[b] != 0.0) {
      const double ratio = now[b] / whole[b];
      most = ratio > 0.0 ? std::max(most, ratio) : steps; // NaN: both are zero
    }
  return std::min(most, steps);
}

/// Forces of random rounding, on the unknowns, and last what steps left of their equations;
/// `backward_error`: that of the worst. Where states hold contact unknowns only, the left forces on
/// the others are not known, and random ones of that size stand for them.
std::vector<Vector> RoundingEstimate::forces(double backward_error) const {
  const bool reduced = formulation_.reduced();
  const auto n = Eigen::Index{formulation_.whole_layout().n_unknowns};
  RoundingForces random;
  random.fill(Vector::Zero(n));
  Vector room, load, size = Vector::Zero(n);
  for (int b = 0; b < formulation_.operators().n_bases(); ++b) {
    const Vector& acting = largest_.on_base[static_cast<std::size_t>(b)];
    formulation_.add_rounding_of_base(b, formulation_.whole_state(acting, room), unit, random,
                                      size);
  }
  if (!reduced) balance_.load.find(largest_.step, load);
  for (std::size_t s = 0; s < n_samples; ++s)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double more = reduced ? backward_error * size[i] : unit * std::abs(load[i]);
      random[s][i] += more * random_unit(static_cast<std::uint64_t>(i), s + 100);
    }
  std::vector<Vector> out(std::make_move_iterator(random.begin()),
                          std::make_move_iterator(random.end()));
  if (!reduced && left_over_.error > 0.0)
    out.push_back(std::max(1.0, backward_error / left_over_.error) * left_over_.force);
  return out;
}

/// Answers to the forces in one step become those over the steps together; by how much each grows.
std::vector<double> RoundingEstimate::over_the_run(std::span<const Vector> forces,
                                                   StepMatrix& matrix, const InequalityState& at,
                                                   std::vector<Vector>& x,
                                                   std::vector<Vector>& xi) const {
  const auto& operators = formulation_.operators();
  const double bound = amplification();
  const int step = evolution_.step();
  const int most =
      !formulation_.reduced() && !operators.iterative && bound >= 2.0 &&
              formulation_.contact().other_fields.empty()
          ? vectors_for_whole_time(operators.n_unknowns, formulation_.contact().n_rows(), step)
          : 0;
  std::optional<WholeTime> whole;
  if (most > 0)
    whole.emplace(operators, matrix, at, formulation_.layout().n_state,
                  balance_.coefficients(step) - coefficients_of_one());
  return grow(whole ? &*whole : nullptr, forces, most, bound, x, xi);
}

std::vector<ErrorSample> RoundingEstimate::samples(StepMatrix& matrix,
                                                   const InequalityState& accepted,
                                                   double backward_error) const {
  if (largest_.step == 0) return {};
  Contact& contact = formulation_.contact();
  const int step = evolution_.step();
  const auto random = forces(backward_error);
  InequalityState at = accepted;
  at.c.setZero();
  if (!contact.none())
    prepare(contact, problem_, evolution_.t(), evolution_.law_fields(contact.other_fields), at.xi);
  std::vector<Vector> x, xi;
  const bool found = formulation_.respond(random, matrix, balance_.coefficients(step), at, x, xi);
  if (contact.none()) xi.resize(random.size());
  const auto growth = found ? over_the_run(random, matrix, at, x, xi)
                            : std::vector<double>(random.size(), amplification());
  const auto memory = memory_of_one();
  const StateLayout& layout = formulation_.whole_layout();
  Vector state = Vector::Zero(layout.n_state);
  std::vector<ErrorSample> out(random.size());
  for (std::size_t s = 0; s < random.size(); ++s) {
    auto& sample = out[s];
    sample.u = Vector::Zero(layout.n_dofs);
    if (found) {
      state.head(layout.n_unknowns) = x[s];
      layout.scatter(state, sample.u);
      if (!contact.none()) sample.xi = xi[s];
    } else { // the tangent has no factor: nothing is known
      sample.u.setConstant(std::numeric_limits<double>::infinity());
    }
    for (int j = 1; j <= highest_derivative; ++j)
      sample.rates.push_back(evolution_.scheme().factor(step, j) / growth[s]);
    sample.memory = memory;
    if (s < n_samples) sample.share = 1.0 / n_samples;
  }
  return out;
}

void RoundingEstimate::save(StateWriter& w) const {
  put_vector(w, left_over_.force);
  w.put(std::array<double, 2>{left_over_.error, largest_.size});
  w.put(largest_.step);
  w.put(static_cast<std::uint64_t>(largest_.on_base.size()));
  for (const Vector& v : largest_.on_base) put_vector(w, v);
}

void RoundingEstimate::restore(StateReader& r) {
  get_vector(r, left_over_.force, left_over_.force.size());
  const auto sizes = r.get<std::array<double, 2>>();
  left_over_.error = sizes[0], largest_.size = sizes[1];
  largest_.step = r.get_between(0, evolution_.step());
  largest_.on_base.resize(r.get_between<std::uint64_t>(
      0, static_cast<std::uint64_t>(formulation_.operators().n_bases())));
  for (Vector& v : largest_.on_base) get_vector(r, v, formulation_.layout().n_state);
}

} // namespace hvi::solver
