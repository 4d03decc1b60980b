// See step_laws.hpp.
#include "solver/step/step_laws.hpp"

#include "solver/linear/vector_stream.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::solver {

StepLaws::StepLaws(const Problem& problem, double tolerance, const Evolution& evolution,
                   Contact& contact)
    : states(problem, evolution, contact), problem_(problem), tolerance_(tolerance),
      evolution_(evolution), contact_(contact) {
  now.xi = Vector::Zero(contact.n_rows());
  now.c = Vector::Zero(static_cast<Eigen::Index>(contact.unknowns.size()));
  accepted_ = now;
  const auto& points = contact.problem.points;
  for (std::size_t p = 0; p < points.size(); ++p)
    if (contact.problem.g.middleRows(points[p].first_row, points[p].rows).nonZeros() == 0)
      given_.push_back(static_cast<int>(p));
}

/// No multiplier is large enough for an obstacle that imposed values go through.
void StepLaws::refuse_impossible(double t) const {
  for (const int p : given_) {
    const auto& point = contact_.problem.points[static_cast<std::size_t>(p)];
    const auto z = contact_.problem.offset.segment(point.first_row, point.rows);
    const Law& law = *contact_.laws[point.law];
    const double r = law.spec().radial ? z.norm() : z[0];
    const double snap = tolerance_ * contact_.problem.offset_size[point.first_row];
    const Interval xi = clarke(law, contact_.problem.graphs[point.graph], r, snap);
    if (xi.low < unbounded_slope && xi.high > -unbounded_slope) continue;
    const auto& term = problem_.law_terms[static_cast<std::size_t>(point.application)];
    throw Failure(FailureKind::not_certified, term.origin,
                  fmt::format("there is no solution at t = {:.6g}: imposed values take the "
                              "argument of `{}` to {:.6g}, where the law is infinite",
                              t, term.name, r),
                  "let the imposed values keep off the obstacle");
  }
}

void StepLaws::prepare(int n, const Vector& u, const Vector* d) {
  if (contact_.none()) return;
  const auto fields = evolution_.law_fields(n, contact_.other_fields, u, d);
  solver::prepare(contact_, problem_, evolution_.grid().t(n), fields, now.xi, d);
}

void StepLaws::read_solution(int n, const Vector& u, const Vector* d) {
  if (contact_.readings.empty()) return;
  state_ = u;
  if (d != nullptr) state_.head(d->size()) += *d;
  solver::read_solution(contact_, evolution_.grid().t(n),
                        evolution_.law_fields(n, contact_.other_fields, state_, d), now.xi);
}

void StepLaws::start_path(int n) {
  const auto& grid = evolution_.grid();
  arguments_of(contact_, problem_, grid.is_static() ? 0.0 : grid.t(n - 1),
               evolution_.law_fields(contact_.other_fields), now.z_before);
}

Inclusion StepLaws::inclusion(int n, const Vector& u, const Vector& d, Vector& z) const {
  const auto fields = evolution_.law_fields(n, contact_.other_fields, u, &d);
  const auto out = inclusion_error(contact_, fields, now.xi, tolerance_, z);
  if (!std::isfinite(out.worst)) refuse_impossible(evolution_.grid().t(n));
  return out;
}

StateError StepLaws::state_error(const Vector& u, const Vector& d) const {
  StateInputs inputs;
  states.inputs(u, &d, now.xi, inputs);
  return states.error(inputs);
}

double StepLaws::settle_bounds(int n, const Vector& u, const Vector& d, Vector& z) {
  prepare(n, u);
  state_ = u;
  state_.head(d.size()) += d;
  return inclusion(n, state_, d, z).worst;
}

void StepLaws::save(StateWriter& w) const {
  put_vector(w, now.c);
  put_vector(w, now.xi);
  w.put(now.state);
  states.save(w);
}

namespace {

/// The pieces that contact points are on must be pieces of their laws.
void check_states(const Contact& contact, const std::vector<int>& states, const StateReader& r) {
  const auto& points = contact.problem.points;
  bool good = states.empty() || states.size() == points.size();
  for (std::size_t p = 0; good && p < states.size(); ++p)
    good = states[p] >= -1 && states[p] / 2 < contact.problem.graphs[points[p].graph].pieces();
  if (!good) r.fail("is inconsistent");
}

} // namespace

void StepLaws::read(StateReader& r) {
  get_vector(r, now.c, now.c.size());
  get_vector(r, now.xi, contact_.n_rows());
  now.state = r.get_vector<int>();
  states.restore(r);
  // Laws that move with time are prepared for the step's time before every solve.
  if (!contact_.none() && evolution_.step() > 0) {
    const auto fields = evolution_.law_fields(contact_.other_fields);
    solver::read_solution(contact_, evolution_.t(), fields, now.xi);
    solver::prepare(contact_, problem_, evolution_.t(), fields, now.xi);
  }
}

void StepLaws::restore(StateReader& r) {
  read(r);
  check_states(contact_, now.state, r);
  accepted_ = now;
}

void StepLaws::take_over(StateReader& r) {
  read(r);
  now.state.clear();
  accepted_ = now;
}

} // namespace hvi::solver
