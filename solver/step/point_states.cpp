// States at contact points; see point_states.hpp. Held by StepLaws.
#include "solver/step/point_states.hpp"

#include "solver/common/numbers.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/certificate.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/step/local_equation.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

/// States have first derivatives only: with the schemes of u'' they have BDF2, of second order,
/// too.
PointStates::PointStates(const Problem& problem, const Evolution& evolution, Contact& contact)
    : problem_(problem), evolution_(evolution), contact_(contact), accepted_(contact.state_values) {
  if (none()) return;
  for (const auto& group : contact.state_groups)
    rates_.emplace_back(problem, group, points_of(contact, group));
  Problem first_order; // without inertia
  first_order.time = problem.time;
  if (problem.time.scheme != Scheme::backward_euler) first_order.time.scheme = Scheme::bdf2;
  scheme_ = make_scheme(first_order);
  scheme_->start(static_cast<int>(accepted_.size()));
}

void PointStates::begin(int n) {
  if (none()) return;
  give_up();
  n_ = n;
  t_ = evolution_.grid().t(n);
  factor_ = 1.0 / scheme_->factor(n, 1);
  known_ = accepted_;
  for (const auto& [factor, of] : scheme_->known(n, 1))
    if (of != nullptr) known_ -= factor_ * factor * *of;
  move_time();
}

/// Of states whose rates are numbers nothing has to be solved for.
void PointStates::move_time() {
  for (const auto& group : contact_.state_groups)
    for (const int i : group.states) {
      const StateTerm& state = problem_.states[static_cast<std::size_t>(i)];
      if (!is_uniform(state)) continue;
      const int first = contact_.first_state[static_cast<std::size_t>(i)];
      for (int at = first; at < first + group.n_points; ++at)
        contact_.state_values[at] =
            std::clamp(known_[at] + factor_ * state.rate.value(), state.low, state.high);
    }
}

void PointStates::inputs(const Vector& u, const Vector* d, const Vector& xi,
                         StateInputs& out) const {
  out.values.setZero(n_inputs());
  out.scales.setZero(n_inputs());
  const auto fields = evolution_.law_fields(n_, contact_.state_fields, u, d);
  const auto laws = evolution_.law_fields(n_, contact_.other_fields, u, d);
  for (const auto& group : contact_.state_groups) {
    const SparseMatrix& trace = group.body ? contact_.body_trace : contact_.trace;
    const bool reached = !group.body && contact_.reach.size() == trace.cols();
    int row = group.first_input;
    for (const Slot s : group.fields) {
      const int field = slot::field_of(s);
      const Vector& values = fields[field];
      const double factor = reached ? fields.factor(field) : 0.0;
      for (const int end = row + group.n_points; row < end; ++row)
        for (SparseMatrix::InnerIterator it(trace, row); it; ++it) {
          out.values[row] += it.value() * values[it.col()];
          out.scales[row] +=
              std::abs(it.value()) * (std::abs(values[it.col()]) +
                                      (factor > 0.0 ? factor * contact_.reach[it.col()] : 0.0));
        }
    }
    for (const Slot s : group.multipliers) {
      const auto& term = contact_.terms[slot::term_of(s)];
      const auto component = static_cast<std::size_t>(slot::row_of(s));
      for (int p = 0; p < group.n_points; ++p)
        out.values[row + p] = global_multiplier(term, xi, p)[component];
      out.scales.segment(row, group.n_points)
          .setConstant(multiplier_scale(contact_, term, laws, xi));
      row += group.n_points;
    }
  }
}

std::vector<double> PointStates::of_point(const StateGroup& group, int p,
                                          const Vector& values) const {
  std::vector<double> out;
  for (const int i : group.states) out.push_back(values[contact_.first_state[i] + p]);
  return out;
}

std::vector<double> PointStates::inputs_of_point(const StateGroup& group, int p,
                                                 const Vector& inputs) const {
  std::vector<double> out;
  for (int row = group.first_input + p; row < group.first_input + group.n_inputs();
       row += group.n_points)
    out.push_back(inputs[row]);
  return out;
}

bool PointStates::solve(const Vector& inputs, double share, Vector& values) const {
  values = accepted_;
  if (!inputs.allFinite()) return false;
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    LocalEquation local;
    local.factor = share * factor_;
    for (const int i : group.states) {
      local.low.push_back(problem_.states[i].low);
      local.high.push_back(problem_.states[i].high);
    }
    for (int p = 0; p < group.n_points; ++p) {
      const auto own = inputs_of_point(group, p, inputs);
      auto z = of_point(group, p, accepted_);
      local.known = of_point(group, p, known_);
      for (std::size_t i = 0; i < z.size(); ++i)
        local.known[i] = z[i] + share * (local.known[i] - z[i]);
      local.rates = [&](std::span<const double> at, std::span<double> out) {
        rates_[g].rates(p, t_, at, own, out);
      };
      local.derivatives = [&](std::span<const double> at, std::span<double> out) {
        rates_[g].derivatives(p, t_, at, own, out, {});
      };
      local.terms = [&](std::span<const double> at, std::span<double> out) {
        terms_of_rates(g, p, at, own, out);
      };
      if (!solve_local(local, z)) return false;
      for (std::size_t i = 0; i < z.size(); ++i)
        values[contact_.first_state[group.states[i]] + p] = z[i];
    }
  }
  return values.allFinite();
}

/// sum_j |dg_i/dz_j z_j| + |dg_i/da_j a_j| of point p.
void PointStates::terms_of_rates(std::size_t g, int p, std::span<const double> z,
                                 std::span<const double> inputs, std::span<double> out) const {
  const std::size_t n = z.size(), n_in = inputs.size();
  std::vector<double> by_state(n * n), by_input(n * n_in);
  rates_[g].derivatives(p, t_, z, inputs, by_state, by_input);
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = 0.0;
    for (std::size_t j = 0; j < n; ++j) out[i] += std::abs(by_state[i * n + j] * z[j]);
    for (std::size_t j = 0; j < n_in; ++j) out[i] += std::abs(by_input[i * n_in + j] * inputs[j]);
  }
}

/// (I - c dg/dz) dz = c dg/da da on the states that are not held at an end.
SparseMatrix PointStates::slopes(const Vector& inputs, double share, const Vector& values) const {
  std::vector<Eigen::Triplet<double>> entries;
  const double c = share * factor_;
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    const auto n = static_cast<Eigen::Index>(group.states.size());
    const auto n_in = static_cast<Eigen::Index>(group.fields.size() + group.multipliers.size());
    std::vector<double> rate(group.states.size()), by_state(static_cast<std::size_t>(n * n)),
        by_input(static_cast<std::size_t>(n * n_in));
    for (int p = 0; p < group.n_points; ++p) {
      const auto own = inputs_of_point(group, p, inputs), z = of_point(group, p, values);
      rates_[g].rates(p, t_, z, own, rate);
      rates_[g].derivatives(p, t_, z, own, by_state, by_input);
      DenseMatrix left = DenseMatrix::Identity(n, n), right = DenseMatrix::Zero(n, n_in);
      for (Eigen::Index i = 0; i < n; ++i) {
        const int state = group.states[static_cast<std::size_t>(i)];
        const auto& spec = problem_.states[static_cast<std::size_t>(state)];
        const int at = contact_.first_state[state] + p;
        const double known = accepted_[at] + share * (known_[at] - accepted_[at]);
        const double moved = known + c * rate[static_cast<std::size_t>(i)];
        if (moved <= spec.low || moved >= spec.high) continue;
        for (Eigen::Index j = 0; j < n; ++j)
          left(i, j) -= c * by_state[static_cast<std::size_t>(i * n + j)];
        for (Eigen::Index j = 0; j < n_in; ++j)
          right(i, j) = c * by_input[static_cast<std::size_t>(i * n_in + j)];
      }
      const DenseMatrix of_point = solve_square(left, right);
      if (!of_point.allFinite()) continue;
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n_in; ++j)
          entries.emplace_back(contact_.first_state[group.states[static_cast<std::size_t>(i)]] + p,
                               group.first_input + static_cast<int>(j) * group.n_points + p,
                               of_point(i, j));
    }
  }
  SparseMatrix out(values.size(), n_inputs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

SparseMatrix PointStates::by_unknowns() const {
  SparseMatrix out = contact_.trace_c;
  const Vector room = Vector::Zero(contact_.trace.cols());
  const auto fields = evolution_.law_fields(n_, contact_.state_fields, room, nullptr);
  for (const auto& group : contact_.state_groups)
    for (std::size_t f = 0; f < group.fields.size(); ++f) {
      const int field = slot::field_of(group.fields[f]);
      const int first = group.first_input + static_cast<int>(f) * group.n_points;
      for (int row = first; row < first + group.n_points; ++row)
        for (SparseMatrix::InnerIterator it(out, row); it; ++it)
          it.valueRef() *= fields.factor(field);
    }
  return out;
}

SparseMatrix PointStates::by_multipliers() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& group : contact_.state_groups) {
    int row = group.first_input + static_cast<int>(group.fields.size()) * group.n_points;
    for (const Slot s : group.multipliers) {
      const auto& term = contact_.terms[slot::term_of(s)];
      const int component = slot::row_of(s), rows = term.points.rows;
      for (int p = 0; p < group.n_points; ++p)
        for (int r = 0; r < rows; ++r) {
          const double factor = term.points.frames.empty() ? (component == 0 ? 1.0 : 0.0)
                                                           : term.points.frames[p](component, r);
          if (factor != 0.0) entries.emplace_back(row + p, term.first_row + p * rows + r, factor);
        }
      row += group.n_points;
    }
  }
  SparseMatrix out(n_inputs(), contact_.n_rows());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

StateError PointStates::error(const StateInputs& inputs) const {
  StateError out;
  const auto size = sizes(inputs);
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    const std::size_t n = group.states.size();
    std::vector<double> rate(n), by_state(n * n), residual(n, 0.0);
    for (int p = 0; p < group.n_points; ++p) {
      const auto own = inputs_of_point(group, p, inputs.values);
      const auto z = of_point(group, p, contact_.state_values);
      rates_[g].rates(p, t_, z, own, rate);
      rates_[g].derivatives(p, t_, z, own, by_state, {});
      for (std::size_t i = 0; i < n; ++i) {
        const auto& spec = problem_.states[static_cast<std::size_t>(group.states[i])];
        const double moved = known_[contact_.first_state[group.states[i]] + p] + factor_ * rate[i];
        const double left = std::abs(z[i] - std::clamp(moved, spec.low, spec.high)) /
                            steepness(std::span(by_state).subspan(i * n, n));
        residual[i] = std::isfinite(left) ? std::max(residual[i], left) : infinity;
        if (!std::isfinite(rate[i]) && !out.no_rate) {
          const LawPoints& points = points_of(contact_, group);
          out.no_rate = {group.states[i], points.x[static_cast<std::size_t>(p)], points.dim,
                         rate[i], z[i]};
        }
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const double worst =
          residual[i] > 0.0 ? residual[i] / size[static_cast<std::size_t>(group.states[i])] : 0.0;
      if (worst > out.worst || out.state < 0) out.worst = worst, out.state = group.states[i];
    }
  }
  return out;
}

/// By how much more the residual of an equation changes than its state.
double PointStates::steepness(std::span<const double> by_state) const {
  double out = 1.0;
  for (const double slope : by_state) out = std::max(out, std::abs(factor_ * slope));
  return out;
}

/// What the inputs' scales make of the states of a point in the step: by the slopes of their rates,
/// and where products of inputs are products of rounding, by the rates one scale away, with the
/// slopes there: a rate that begins at a threshold is flat before it and may be steep behind.
std::vector<double> PointStates::made_of_scales(std::size_t g, int p,
                                                const StateInputs& inputs) const {
  const auto& group = contact_.state_groups[g];
  const std::size_t n = group.states.size(), n_in = group.fields.size() + group.multipliers.size();
  const auto own = inputs_of_point(group, p, inputs.values),
             scales = inputs_of_point(group, p, inputs.scales);
  const auto z = of_point(group, p, contact_.state_values);
  std::vector<double> by_state(n * n), by_input(n * n_in), here(n), there(n), out(n, 0.0);
  rates_[g].derivatives(p, t_, z, own, by_state, by_input);
  rates_[g].rates(p, t_, z, own, here);
  std::vector<double> steep(n);
  for (std::size_t i = 0; i < n; ++i) {
    steep[i] = steepness(std::span(by_state).subspan(i * n, n));
    for (std::size_t j = 0; j < n_in; ++j)
      out[i] += factor_ / steep[i] * std::abs(by_input[i * n_in + j]) * scales[j];
  }
  for (const double sign : {-1.0, 1.0}) {
    auto moved = own;
    for (std::size_t j = 0; j < n_in; ++j) moved[j] += sign * scales[j];
    rates_[g].rates(p, t_, z, moved, there);
    rates_[g].derivatives(p, t_, z, moved, by_state, {});
    for (std::size_t i = 0; i < n; ++i) {
      const double change = factor_ * std::abs(there[i] - here[i]) /
                            std::max(steep[i], steepness(std::span(by_state).subspan(i * n, n)));
      if (std::isfinite(change)) out[i] = std::max(out[i], change);
    }
  }
  return out;
}

std::vector<double> PointStates::sizes(const StateInputs& inputs) const {
  std::vector<double> out(problem_.states.size(), 0.0);
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    for (int p = 0; p < group.n_points; ++p) {
      const auto made = made_of_scales(g, p, inputs);
      for (std::size_t i = 0; i < made.size(); ++i) {
        const int at = contact_.first_state[group.states[i]] + p;
        double& size = out[static_cast<std::size_t>(group.states[i])];
        size = std::max({size, std::abs(contact_.state_values[at]), std::abs(known_[at]),
                         std::abs(accepted_[at]), made[i]});
      }
    }
  }
  return out;
}

StateError PointStates::distance(const Vector& values, const StateInputs& inputs) const {
  StateError out;
  const auto size = sizes(inputs);
  for (const auto& group : contact_.state_groups)
    for (const int i : group.states) {
      const int first = contact_.first_state[i];
      double moved = 0.0, most = size[static_cast<std::size_t>(i)];
      for (int at = first; at < first + group.n_points; ++at) {
        moved = std::max(moved, std::abs(values[at] - contact_.state_values[at]));
        most = std::max(most, std::abs(values[at]));
      }
      const double of_size = moved > 0.0 ? moved / most : 0.0;
      if (of_size > out.worst || out.state < 0) out.worst = of_size, out.state = i;
    }
  return out;
}

Vector PointStates::kept(Vector values) const {
  for (const auto& group : contact_.state_groups)
    for (const int i : group.states) {
      auto own = values.segment(contact_.first_state[i], group.n_points);
      own = own.cwiseMax(problem_.states[i].low).cwiseMin(problem_.states[i].high).eval();
    }
  return values;
}

void PointStates::accept(int n) {
  if (none()) return;
  Vector moved = contact_.state_values - accepted_;
  scheme_->accept(n, moved);
  accepted_ = contact_.state_values;
}

void PointStates::save(StateWriter& w) const {
  if (none()) return;
  put_vector(w, accepted_);
  scheme_->save(w);
}

void PointStates::restore(StateReader& r) {
  if (none()) return;
  get_vector(r, accepted_, accepted_.size());
  scheme_->restore(r);
  give_up();
}

} // namespace hvi::solver
