// The balance of forces of a step; see balance.hpp. Called by the StepSolver.
#include "solver/time/balance.hpp"

#include "solver/common/parallel.hpp"
#include "solver/time/certificate.hpp"
#include "solver/time/inertia.hpp"
#include "solver/time/step_load.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// Matrices are stored once more, for products that read half, when a run has so many steps.
constexpr int worth_halving = 12;

} // namespace

Balance::Balance(const Plan& plan, const Discretisation& discretisation,
                 const Formulation& formulation, const Evolution& evolution)
    : problem_(plan.problem), discretisation_(discretisation), formulation_(formulation),
      operators_(formulation.operators()), evolution_(evolution) {
  const auto& layout = formulation.layout();
  if (const SparseMatrix transfer = load_transfer(problem_, discretisation);
      transfer.nonZeros() > 0)
    load_transfer_ = restrict_rows(transfer, layout).leftCols(layout.n_unknowns);
  state_ = Vector::Zero(layout.n_state);
  full_ = Vector::Zero(layout.n_dofs);
  scale_ = product_ = Vector::Zero(layout.n_unknowns);
  if (evolution.grid().steps() >= worth_halving && operators_.symmetric && !formulation.imposed() &&
      operators_.changing.empty())
    halve_bases(plan.options.threads);
}

void Balance::halve_bases(int threads) {
  halves_.resize(operators_.bases.size());
  for_each_piece(operators_.n_bases(), threads, [&](int b) {
    halves_[b] = SymmetricBlocks(operators_.bases[b], operators_.mirrored);
  });
  if (std::any_of(halves_.begin(), halves_.end(), [](const auto& half) { return half.empty(); }))
    halves_.clear();
}

Vector Balance::coefficients(int n) const {
  return operators_.weights.transpose() * evolution_.in_equation(n);
}

void Balance::load(int n, Vector& out) const {
  const auto& scheme = evolution_.scheme();
  out.setZero(formulation_.layout().n_unknowns);
  add_step_load(formulation_.loads(), problem_.time, scheme, n, out);
  if (load_transfer_.nonZeros() > 0) out = load_transfer_ * out;
  if (scheme.past_of_laws() != 0.0 && !formulation_.contact().none())
    out -= scheme.past_of_laws() * last_reaction_;
}

void Balance::note_multipliers(const Vector& xi) {
  if (evolution_.scheme().past_of_laws() != 0.0 && !formulation_.contact().none())
    last_reaction_ = formulation_.contact().force * xi;
}

void Balance::known_state(int n, Vector& out) {
  const auto& layout = formulation_.layout();
  const Vector& u = evolution_.u();
  out = u;
  if (!formulation_.imposed()) return;
  layout.scatter(u, full_);
  impose(discretisation_.space, problem_.space, discretisation_.dofs, evolution_.grid().t(n),
         full_);
  layout.gather(full_, out);
  out.head(layout.n_unknowns) = u.head(layout.n_unknowns);
}

void Balance::find_right_hand_side(StepEquation& equation) {
  load(equation.n, equation.rhs);
  for (int b = 0; b < operators_.n_bases(); ++b) {
    const double change = equation.change[b];
    bool any = evolution_.known_part(equation.n, operators_.weights, b, equation.known, state_);
    if (!any && change != 0.0) state_.setZero(), any = true;
    if (change != 0.0) state_ -= change * equation.expected;
    if (!any || state_.isZero(0.0)) continue;
    if (halves_.empty()) {
      state_ = -state_;
      subtract_product(operators_.bases[b], state_, equation.rhs);
    } else {
      halves_[b].add_product(state_, equation.rhs);
    }
    ++products;
  }
}

void Balance::take_back_change(StepEquation& equation) const {
  for (int b = 0; b < operators_.n_bases(); ++b)
    if (equation.change[b] != 0.0)
      equation.rhs.noalias() += equation.change[b] * (operators_.bases[b] * equation.expected);
  equation.change.setZero();
}

Balance::Residual Balance::residual(const StepEquation& equation, StepMatrix& matrix,
                                    const Vector& xi, Trial& trial) {
  const Contact& contact = formulation_.contact();
  const Vector &rhs = equation.rhs, &d = trial.d;
  ++products;
  if (equation.exact()) {
    const SymmetricBlocks& half = matrix.half(halves_);
    if (half.empty()) {
      const double error =
          equilibrium_error(matrix.k(), d, rhs, contact.unknowns, contact.force, xi, trial.gap);
      trial.kd = rhs - trial.gap;
      return {error, 0.0};
    }
    trial.kd.setZero(rhs.size());
    half.add_product(d, trial.kd);
    return {equilibrium_error(matrix.k(), half.diagonal(), trial.kd, d, rhs, contact.unknowns,
                              contact.force, xi, trial.gap),
            0.0};
  }
  gap_and_scale(matrix.k(), d, rhs, trial.gap, scale_);
  trial.kd = rhs - trial.gap;
  state_ = equation.expected;
  state_.head(rhs.size()) -= d;
  Residual out;
  for (int b = 0; b < operators_.n_bases(); ++b) {
    if (equation.change[b] == 0.0) continue;
    product_.noalias() = operators_.bases[b] * state_;
    product_ *= equation.change[b];
    trial.gap += product_;
    out.mismatch += (product_.array().abs() / scale_.array().max(1e-300)).maxCoeff();
    ++products;
  }
  out.error = equilibrium_error(matrix.k(), d, trial.gap, scale_, contact.force, xi);
  return out;
}

std::vector<Vector> Balance::known_on_bases(const StepEquation& equation) {
  std::vector<Vector> out(operators_.bases.size());
  for (int b = 0; b < operators_.n_bases(); ++b)
    if (Vector& of = out[static_cast<std::size_t>(b)];
        !evolution_.known_part(equation.n, operators_.weights, b, equation.known, of))
      of.setZero(equation.known.size());
  return out;
}

double Balance::precise_gap(int n, const StepMatrix& matrix, const std::vector<Vector>& known,
                            const Vector& d, const Vector& xi, Vector& gap) {
  load(n, product_);
  scale_ = product_.cwiseAbs();
  std::vector<DoubleDouble> sums(static_cast<std::size_t>(d.size()));
  for (Eigen::Index i = 0; i < d.size(); ++i) sums[static_cast<std::size_t>(i)].high = product_[i];
  const Vector gamma = coefficients(n);
  for (int b = 0; b < operators_.n_bases(); ++b) {
    state_ = -known[static_cast<std::size_t>(b)];
    state_.head(d.size()) += gamma[b] * d;
    subtract_product(operators_.bases[b], state_, sums, scale_);
    ++products;
  }
  for (Eigen::Index i = 0; i < d.size(); ++i) gap[i] = sums[static_cast<std::size_t>(i)].value();
  return equilibrium_error(matrix.k(), d, gap, scale_, formulation_.contact().force, xi);
}

Interior::Question Balance::question(int n, const Vector& d, const Vector& xi) const {
  Interior::Question out; // there is one base matrix, and nothing is imposed
  if (!evolution_.known_part(n, operators_.weights, 0, evolution_.u(), out.known))
    out.known.setZero(evolution_.u().size());
  out.known = -out.known;
  out.change = coefficients(n)[0] * d;
  load(n, out.load);
  out.xi = xi;
  return out;
}

SymmetricBlocks Balance::from_bases(const FormTerm& form) const {
  if (halves_.empty() || formulation_.reduced()) return {};
  const auto factors = as_combination(operators_, discretisation_, form);
  return factors ? SymmetricBlocks::sum(halves_, *factors) : SymmetricBlocks();
}

double Balance::bytes() const {
  double out = 0.0;
  for (const auto& base : operators_.bases)
    out += static_cast<double>(base.nonZeros()) * (sizeof(double) + sizeof(int));
  for (const auto& half : halves_) out += half.bytes();
  return out;
}

} // namespace hvi::solver
