// The balance of forces of a step; see balance.hpp. Called by the StepSolver.
#include "solver/step/balance.hpp"

#include "solver/discrete/certificate.hpp"
#include "solver/formulation/halved_bases.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Of the terms of a sum: what it is known to.
constexpr double rounding_of_terms = 1e-15;
/// Who asks for less asks for rounding: then nothing is beside it.
constexpr double least_tolerance = 1e-13;

/// Matrices are stored once more, for products that read half, when a run has so many steps.
constexpr int worth_halving = 12;

} // namespace

Balance::Balance(const Plan& plan, const Discretisation& discretisation,
                 const Formulation& formulation, const Evolution& evolution)
    : load(plan.problem, discretisation, formulation, evolution.scheme()),
      formulation_(formulation), evolution_(evolution),
      imposed_(plan.problem.space, discretisation, formulation.layout()) {
  const auto& layout = formulation.layout();
  const Operators& operators = formulation.operators();
  state_ = Vector::Zero(layout.n_state);
  scale_ = product_ = Vector::Zero(layout.n_unknowns);
  if (evolution.grid().steps() >= worth_halving && operators.symmetric && !formulation.imposed() &&
      operators.changing.empty() && !operators.iterative) // memory is what they are to save
    halves_ = halved(operators, plan.options.threads);
}

Vector Balance::coefficients(int n) const {
  return formulation_.operators().weights.transpose() * evolution_.in_equation(n);
}

void Balance::known_state(int n, Vector& out) {
  out = evolution_.u();
  note_largest(out);
  if (formulation_.imposed()) imposed_.put(evolution_.grid().t(n), out);
}

void Balance::note_past(int n) {
  const Operators& operators = formulation_.operators();
  product_.setZero();
  for (const auto& [base, form] : operators.changing) {
    if (!evolution_.past_part(operators.weights, base, state_)) continue;
    add_product_of_base(operators, base, 1.0, state_, product_);
    ++products;
  }
  load.note_forces(product_);
  load.note_state_loads(n);
}

void Balance::find_right_hand_side(StepEquation& equation) {
  const Operators& operators = formulation_.operators();
  load.find(equation.n, equation.rhs);
  for (int b = 0; b < operators.n_bases(); ++b) {
    const double change = equation.change[b];
    bool any = evolution_.known_part(equation.n, operators.weights, b, !operators.changes(b),
                                     equation.known, state_);
    if (!any && change != 0.0) state_.setZero(), any = true;
    if (change != 0.0) state_ -= change * equation.expected;
    if (!any || state_.isZero(0.0)) continue;
    if (operators.dealt) {
      add_product_of_base(operators, b, 1.0, state_, equation.rhs);
    } else if (halves().empty()) {
      state_ = -state_;
      subtract_product(operators.bases[b], state_, equation.rhs);
    } else {
      halves()[static_cast<std::size_t>(b)].add_product(state_, equation.rhs);
    }
    ++products;
  }
}

EquationResidual Balance::residual(const StepEquation& equation, StepMatrix& matrix,
                                   const Vector& xi, Trial& trial) {
  const Operators& operators = formulation_.operators();
  const Contact& contact = formulation_.contact();
  const Vector &rhs = equation.rhs, &d = trial.d;
  ++products;
  if (equation.exact() && matrix.dealt() == nullptr) {
    const SymmetricBlocks& half = matrix.half(halves_);
    if (half.empty()) {
      const double error =
          equilibrium_error(matrix.k(), d, rhs, contact.loaded, contact.reactions(), xi, trial.gap);
      trial.kd = rhs - trial.gap;
      return {error, 0.0};
    }
    trial.kd.setZero(rhs.size());
    half.add_product(d, trial.kd);
    return {equilibrium_error(matrix.k(), half.diagonal(), trial.kd, d, rhs, contact.loaded,
                              contact.reactions(), xi, trial.gap),
            0.0};
  }
  find_gap_and_scale(matrix, d, rhs, trial.gap);
  trial.kd = rhs - trial.gap;
  state_ = equation.expected;
  if (!equation.exact()) state_.head(rhs.size()) -= d;
  EquationResidual out;
  for (int b = 0; b < operators.n_bases(); ++b) {
    if (equation.change[b] == 0.0) continue;
    product_of_base(operators, b, state_, product_);
    product_ *= equation.change[b];
    trial.gap += product_;
    out.mismatch += (product_.array().abs() / scale_.array().max(1e-300)).maxCoeff();
    ++products;
  }
  out.error = error_of(matrix, d, trial.gap, xi);
  return out;
}

/// gap = rhs - K d, and in scale_ what its rows are made of.
void Balance::find_gap_and_scale(const StepMatrix& matrix, const Vector& d, const Vector& rhs,
                                 Vector& gap) {
  if (matrix.dealt() == nullptr) return gap_and_scale(matrix.k(), d, rhs, gap, scale_);
  matrix.dealt()->apply(d, gap);
  gap = rhs - gap;
  matrix.dealt()->apply_magnitude(d, scale_);
  scale_ += rhs.cwiseAbs();
}

double Balance::error_of(const StepMatrix& matrix, const Vector& d, const Vector& gap,
                         const Vector& xi) const {
  return error_of_rows(matrix, d, gap, scale_, formulation_.contact().reactions(), xi);
}

void Balance::add_terms(const StepEquation& equation, double factor, Vector& out) {
  const Operators& operators = formulation_.operators();
  load.find(equation.n, product_);
  out += factor * product_.cwiseAbs();
  for (int b = 0; b < operators.n_bases(); ++b) {
    if (!evolution_.known_part(equation.n, operators.weights, b, !operators.changes(b),
                               equation.known, state_))
      continue;
    add_magnitude_of_base(operators, b, factor, state_, out);
  }
}

int Balance::unknown_of(Eigen::Index row) const {
  const auto& of_unknown = formulation_.contact().of_unknown;
  return of_unknown.empty() ? 0 : of_unknown[static_cast<std::size_t>(row)];
}

void Balance::note_largest(const Vector& state) {
  for (Eigen::Index i = 0; i < formulation_.layout().n_unknowns; ++i) {
    double& largest = largest_[unknown_of(i)];
    largest = std::max(largest, std::abs(state[i]));
  }
}

ByUnknown Balance::rounding_of_largest() const {
  auto out = largest_;
  for (double& value : out) value *= rounding_of_terms;
  return out;
}

bool Balance::is_rounding(const Vector& values) const {
  const auto known_to = rounding_of_largest();
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (!(std::abs(values[i]) <= known_to[unknown_of(i)])) return false;
  return true;
}

void Balance::add_past(const StepMatrix& matrix, double factor, Vector& out) const {
  Vector past(out.size()), forces;
  const Contact& contact = formulation_.contact();
  ByUnknown most = largest_;
  if (contact.reach.size() > 0)
    for (const int i : contact.loaded)
      most[unknown_of(i)] = std::max(most[unknown_of(i)], contact.reach[i]);
  for (Eigen::Index i = 0; i < past.size(); ++i) past[i] = most[unknown_of(i)];
  if (matrix.dealt() != nullptr)
    matrix.dealt()->apply_magnitude(past, forces);
  else
    HeldRows(matrix.k(), {}).apply_magnitude(past, forces);
  out += factor * forces;
}

double Balance::error_beside_rounding(const StepEquation& equation, const StepMatrix& matrix,
                                      const Vector& xi, const Trial& trial, double tolerance) {
  Vector gap(equation.rhs.size());
  find_gap_and_scale(matrix, trial.d, equation.rhs, gap);
  if (tolerance >= least_tolerance) {
    add_terms(equation, rounding_of_terms / tolerance, scale_);
    add_past(matrix, rounding_of_terms / tolerance, scale_);
  }
  return error_of(matrix, trial.d, gap, xi);
}

InteriorEquilibrium::Question Balance::question(int n, const Vector& d, const Vector& xi) const {
  InteriorEquilibrium::Question out; // there is one base matrix, and nothing is imposed
  if (!evolution_.known_part(n, formulation_.operators().weights, 0, true, evolution_.u(),
                             out.known))
    out.known.setZero(evolution_.u().size());
  out.known = -out.known;
  out.change = coefficients(n)[0] * d;
  load.find(n, out.load);
  out.xi = xi;
  return out;
}

void Balance::save(StateWriter& w) const {
  for (const double largest : largest_) w.put(largest);
}

void Balance::restore(StateReader& r) {
  for (double& largest : largest_)
    if (largest = r.get<double>(); !(largest >= 0.0)) r.fail("is inconsistent");
}

void take_back_change(const Operators& operators, StepEquation& equation) {
  for (int b = 0; b < operators.n_bases(); ++b)
    if (equation.change[b] != 0.0)
      add_product_of_base(operators, b, equation.change[b], equation.expected, equation.rhs);
  equation.change.setZero();
}

double error_of_rows(const StepMatrix& matrix, const Vector& d, const Vector& gap,
                     const Vector& scale, const Reactions& reactions, const Vector& xi) {
  if (matrix.dealt() == nullptr) return equilibrium_error(matrix.k(), d, gap, scale, reactions, xi);
  return equilibrium_error(matrix.dealt()->whole_sizes(d), gap, scale, reactions, xi);
}

double bytes_of(const Operators& operators, std::span<const SymmetricBlocks> halves) {
  double out = operators.dealt ? operators.dealt->bytes() : 0.0;
  for (const auto& base : operators.bases)
    out += static_cast<double>(base.nonZeros()) * (sizeof(double) + sizeof(int));
  for (const auto& half : halves) out += half.bytes();
  return out; // halves in the place of the matrices are those of the balance
}

} // namespace hvi::solver
