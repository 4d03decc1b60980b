// Full vectors of u, its derivatives and the history fields for a report; see fields.hpp.
#include "solver/step/fields.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

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

void Snapshot::take_start(const RunState& run, bool moves) {
  take(run);
  const bool balance = run.solver.equations.laws.start_known();
  const auto forget = [](Vector& v) { v.setConstant(std::nan("")); };
  for (int j = 1; j <= highest_derivative; ++j)
    if (needed_[field_of_u(j)] && !(balance || (moves && j == 1))) forget(fields_[field_of_u(j)]);
  if (!balance) forget(xi_);
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
  // Nothing is known of u', memory and multipliers at the initial time: the first step's hold.
  const bool initial = a.step_ == 0;
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    if (!needed_[k]) continue;
    fields_[k] = b.fields_[k];
    if (is_rate(static_cast<int>(k)) && initial) continue;
    fields_[k] = (1 - theta) * a.fields_[k] + theta * b.fields_[k];
  }
  xi_ = initial ? b.xi_ : Vector((1 - theta) * a.xi_ + theta * b.xi_);
  states_ = (1 - theta) * a.states_ + theta * b.states_;
  t_ = (1 - theta) * a.t_ + theta * b.t_;
  step_ = b.step_;
}

} // namespace hvi::solver
