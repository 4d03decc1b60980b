// Full vectors of u, its derivatives and the history fields for a report; see fields.hpp.
#include "solver/step/fields.hpp"

#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// The values of one unknown are not known.
void forget(Vector& values, const Space& space, const SpaceBlock& unknown) {
  for (int node = 0; node < std::ssize(space.nodes); ++node)
    values.segment(space.dof(node, unknown.first), unknown.components).setConstant(std::nan(""));
}

} // namespace

Snapshot::Snapshot(std::vector<bool> needed, int n_dofs, int n_rows)
    : needed_(std::move(needed)), fields_(needed_.size()), xi_(Vector::Zero(n_rows)) {
  for (std::size_t k = 0; k < needed_.size(); ++k)
    if (needed_[k]) fields_[k] = Vector::Zero(n_dofs);
  point();
}

Snapshot::Snapshot(const Snapshot& other)
    : needed_(other.needed_), fields_(other.fields_), xi_(other.xi_), states_(other.states_),
      state_(other.state_), t_(other.t_), step_(other.step_) {
  point();
}

Snapshot& Snapshot::operator=(const Snapshot& other) {
  needed_ = other.needed_;
  fields_ = other.fields_;
  xi_ = other.xi_;
  states_ = other.states_;
  state_ = other.state_;
  t_ = other.t_;
  step_ = other.step_;
  point();
  return *this;
}

void Snapshot::point() {
  pointers_.assign(fields_.size(), nullptr);
  for (std::size_t k = 0; k < fields_.size(); ++k) pointers_[k] = &fields_[k];
}

void Snapshot::take(const RunState& run, bool whole) {
  const Formulation& formulation = *run.formulation;
  const Evolution& evolution = run.evolution;
  const auto scatter = [&](const Vector& state, Vector& full) {
    whole ? formulation.scatter(state, full) : formulation.scatter_observed(state, full);
  };
  if (needed_[field_of_u(0)]) scatter(run.evolution.u(), fields_[field_of_u(0)]);
  for (int j = 1; j <= highest_derivative; ++j) {
    if (!needed_[field_of_u(j)]) continue;
    evolution.derivative(j, state_);
    scatter(state_, fields_[field_of_u(j)]);
  }
  for (int m = 0; m < evolution.memory().size(); ++m) {
    if (!needed_[field_of_memory(m)]) continue;
    evolution.history_field(m, state_);
    scatter(state_, fields_[field_of_memory(m)]);
  }
  xi_ = run.xi();
  states_ = run.states();
  t_ = run.evolution.t();
  step_ = run.evolution.step();
}

void Snapshot::take_start(const RunState& run, const Problem& problem, const Space& space) {
  take(run);
  const bool balance = run.solver.equations.laws.start_known();
  if (!balance) xi_.setConstant(std::nan(""));
  if (problem.time.start) return; // nothing moves
  const bool accelerations = balance && run.evolution.scheme().needs_acceleration();
  const std::vector<int> orders = orders_in_time(problem);
  for (int j = 1; j <= highest_derivative; ++j) {
    Vector& derivative = fields_[field_of_u(j)];
    for (std::size_t b = 0; needed_[field_of_u(j)] && b < orders.size(); ++b)
      if (j > orders[b] || (j == orders[b] && !accelerations))
        forget(derivative, space, space.blocks[b]);
  }
}

void Snapshot::move(const ErrorSample& error, double step) {
  for (int k = 0; k < static_cast<int>(fields_.size()); ++k) {
    if (!needed_[k]) continue;
    const double factor = k == field_of_u(0) ? 1.0
                          : is_rate(k)       ? error.rates[k - 1]
                                             : error.memory[memory_of(k)];
    fields_[k] += step * factor * error.u;
  }
  if (error.xi.size() == xi_.size()) xi_ += step * error.xi;
}

void Snapshot::interpolate(const Snapshot& a, const Snapshot& b, double theta) {
  const bool initial = a.step_ == 0 && theta > 0.0;
  const auto between = [&](const Vector& from, const Vector& to) {
    Vector out = (1 - theta) * from + theta * to;
    if (initial) out = from.array().isNaN().select(to, out);
    return out;
  };
  for (std::size_t k = 0; k < fields_.size(); ++k)
    if (needed_[k]) fields_[k] = between(a.fields_[k], b.fields_[k]);
  xi_ = between(a.xi_, b.xi_);
  states_ = between(a.states_, b.states_);
  t_ = (1 - theta) * a.t_ + theta * b.t_;
  step_ = b.step_;
}

} // namespace hvi::solver
