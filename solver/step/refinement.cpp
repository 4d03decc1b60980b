// Refinement in extended precision; see refinement.hpp. Called by the StepSolver.
#include "solver/step/refinement.hpp"

#include "solver/discrete/certificate.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/formulation/halved_bases.hpp"
#include "solver/linear/double_double.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr int most_refinements = 60;
/// A correction of this relative size is the rounding of the state itself.
constexpr double smallest_correction = 4e-16;
/// Corrections that shrink slower than this have come to their end.
constexpr double slow = 0.5;
/// The last correction must be smaller: else the factor of K gains nothing.
constexpr double largest_last = 1e-6;

[[noreturn]] void too_ill_conditioned(const Problem& problem, int n, double last) {
  throw Failure(
      FailureKind::mostly_rounding, problem.space.origin,
      fmt::format("the matrix of step {} is too ill-conditioned for double precision: corrections "
                  "with residuals in extended precision still change the state by {:.1e} of its "
                  "size",
                  n, last),
      better_conditioned);
}

} // namespace

PreciseEquation::PreciseEquation(const Formulation& formulation, const Evolution& evolution,
                                 Balance& balance, const StepEquation& equation)
    : formulation_(formulation), balance_(balance), step_(equation.n),
      known_(formulation.operators().bases.size()) {
  const Operators& operators = formulation.operators();
  for (int b = 0; b < operators.n_bases(); ++b)
    if (Vector& of = known_[static_cast<std::size_t>(b)]; !evolution.known_part(
            step_, operators.weights, b, !operators.changes(b), equation.known, of))
      of.setZero(equation.known.size());
}

double PreciseEquation::gap(const StepMatrix& matrix, const Vector& d, const Vector& xi,
                            Vector& gap) {
  const Operators& operators = formulation_.operators();
  Vector load, state;
  SparseMatrix room;
  balance_.load.find(step_, load);
  Vector scale = load.cwiseAbs();
  std::vector<DoubleDouble> sums(static_cast<std::size_t>(d.size()));
  for (Eigen::Index i = 0; i < d.size(); ++i) sums[static_cast<std::size_t>(i)].high = load[i];
  const Vector gamma = balance_.coefficients(step_);
  for (int b = 0; b < operators.n_bases(); ++b) {
    state = -known_[static_cast<std::size_t>(b)];
    state.head(d.size()) += gamma[b] * d;
    if (operators.dealt)
      operators.dealt->subtract_product(b, state, sums, scale);
    else
      subtract_product(base_by_rows(operators, b, room), state, sums, scale);
    ++balance_.products;
  }
  for (Eigen::Index i = 0; i < d.size(); ++i) gap[i] = sums[static_cast<std::size_t>(i)].value();
  return error_of_rows(matrix, d, gap, scale, formulation_.contact().reactions(), xi);
}

bool Refinement::begins_with(const StepMatrix& matrix) {
  if (on_) return false;
  // The factor of a free body is that of a matrix made almost singular, whose errors laws stop.
  if (!matrix.factorisation() || matrix.free_body() != nullptr) return false;
  Factorisation& factor = *matrix.factorisation();
  const auto& of_unknown = formulation_.contact().of_unknown;
  const double growth =
      matrix.dealt() != nullptr
          ? rounding_growth(*matrix.dealt(), {matrix.dealt()->own_stiffness(), of_unknown}, factor)
          : rounding_growth(matrix.k(), {own_stiffness(matrix.k()), of_unknown}, factor);
  on_ = growth > growth_to_refine;
  return on_;
}

void Refinement::refine(const StepMatrix& matrix, const StepEquation& equation,
                        Corrector& corrector, StepLaws& step_laws, Trial& trial, StepResult& out) {
  if (!trial.d.allFinite()) return;
  auto& laws = step_laws.now;
  const int n = equation.n;
  PreciseEquation precise(formulation_, evolution_, balance_, equation);
  Vector total = trial.d, state = equation.known;
  auto moved_by = state.head(total.size());
  const int iterations = out.inequality.iterations, events = out.inequality.events;
  double last = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_refinements; ++pass) {
    precise.gap(matrix, total, laws.xi, trial.gap);
    moved_by = equation.known.head(total.size()) + total;
    step_laws.prepare(n, state, &total);
    laws.c.setZero();
    const auto report = corrector.start(matrix, trial.gap, laws, trial.d);
    ++out.corrections;
    const double size = state.lpNorm<Eigen::Infinity>(), moved = trial.d.lpNorm<Eigen::Infinity>();
    const double correction = size > 0.0 ? moved / size : 0.0;
    if (!std::isfinite(correction) || correction > slow * last) break;
    total += trial.d;
    out.inequality = report;
    last = correction;
    if (correction <= smallest_correction) break;
  }
  out.inequality.iterations += iterations, out.inequality.events += events;
  moved_by = equation.known.head(total.size()) + total;
  // Of what is at rest a last correction says nothing: both are rounding.
  const bool at_rest = balance_.is_rounding(trial.d) || balance_.is_rounding(moved_by);
  trial.d = total;
  contact_part(formulation_.contact(), trial.d, laws.c);
  step_laws.prepare(n, equation.known);
  out.equilibrium = precise.gap(matrix, trial.d, laws.xi, trial.gap);
  if (matrix.dealt() != nullptr)
    matrix.dealt()->apply(trial.d, trial.kd);
  else
    trial.kd.noalias() = matrix.k() * trial.d;
  if (at_rest) return;
  last_correction_ = std::max(last_correction_, last);
  if (!(last <= largest_last) && matrix.free_body() == nullptr)
    too_ill_conditioned(problem_, n, last);
}

void Refinement::save(StateWriter& w) const {
  w.put(std::uint8_t{on_});
  w.put(last_correction_);
}

void Refinement::restore(StateReader& r) {
  on_ = r.get<std::uint8_t>() != 0;
  last_correction_ = r.get<double>();
}

} // namespace hvi::solver
