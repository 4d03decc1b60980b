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
namespace {

/// What a tolerance of 1e-10 makes of this part of a size is rounding.
constexpr double rounding_beside_tolerance = 1e-5;

} // namespace

/// States have first derivatives only: with the schemes of u'' they have BDF2, of second order,
/// too.
PointStates::PointStates(const Problem& problem, const Evolution& evolution, Contact& contact)
    : problem_(problem), evolution_(evolution), contact_(contact), accepted_(contact.state_values) {
  if (none()) return;
  for (const auto& group : contact.state_groups)
    rates_.emplace_back(problem, group, points_of(contact, group));
  if (std::ranges::all_of(problem.states, &StateTerm::algebraic)) return;
  Problem first_order; // without inertia
  first_order.time = problem.time;
  if (problem.time.scheme != Scheme::backward_euler) first_order.time.scheme = Scheme::bdf2;
  scheme_ = make_scheme(first_order);
  scheme_->start(static_cast<int>(accepted_.size()));
}

void PointStates::start() {
  if (std::ranges::none_of(problem_.states, &StateTerm::algebraic)) return;
  const auto& grid = evolution_.grid();
  auto known = contact_.state_fields;
  std::erase_if(known, [](int field) { return is_memory(field); });
  auto fields = evolution_.law_fields(known);
  for (const int field : contact_.state_fields) // which are empty at that time
    if (is_memory(field)) fields.add(field, 0.0, Vector::Zero(evolution_.u().size()));
  StateInputs inputs{Vector::Zero(n_inputs()), Vector::Zero(n_inputs())};
  for (const auto& group : contact_.state_groups) values_of_fields(group, fields, inputs);
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    std::vector<double> rates(group.states.size());
    for (int p = 0; p < group.n_points; ++p) {
      rates_[g].rates(p, grid.is_static() ? 0.0 : grid.t(0), of_point(group, p, accepted_),
                      inputs_of_point(group, p, inputs.values), rates);
      for (std::size_t i = n_with_rates(group); i < rates.size(); ++i)
        accepted_[contact_.first_state[group.states[i]] + p] = rates[i];
    }
  }
  give_up();
}

void PointStates::begin(int n) {
  if (none()) return;
  give_up();
  n_ = n;
  t_ = evolution_.grid().is_static() ? 0.0 : evolution_.grid().t(n);
  known_ = accepted_;
  if (scheme_) {
    factor_ = 1.0 / scheme_->factor(n, 1);
    for (const auto& [factor, of] : scheme_->known(n, 1))
      if (of != nullptr) known_ -= factor_ * factor * *of;
  }
  for (const auto& group : contact_.state_groups)
    for (const int i : group.states)
      if (algebraic(i)) known_.segment(contact_.first_state[i], group.n_points).setZero();
  move_time();
}

std::size_t PointStates::n_with_rates(const StateGroup& group) const {
  const auto first = std::ranges::find_if(group.states, [&](int i) { return algebraic(i); });
  return static_cast<std::size_t>(first - group.states.begin());
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
    values_of_fields(group, fields, out);
    int row = group.first_input + static_cast<int>(group.fields.size()) * group.n_points;
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

/// Those that the rates of a group read, with their sizes. Of a body that laws hold it is rounding
/// where it sticks.
void PointStates::values_of_fields(const StateGroup& group, const LawFields& fields,
                                   StateInputs& out) const {
  const SparseMatrix& trace = group.body ? contact_.body_trace : contact_.trace;
  const bool reached = contact_.reach.size() == trace.cols();
  int row = group.first_input;
  for (const Slot s : group.fields) {
    const int field = slot::field_of(s);
    const Vector& values = fields[field];
    const double factor = reached ? fields.factor(field) : 0.0;
    for (const int end = row + group.n_points; row < end; ++row)
      for (SparseMatrix::InnerIterator it(trace, row); it; ++it) {
        out.values[row] += it.value() * values[it.col()];
        out.scales[row] +=
            std::abs(it.value()) *
            (std::abs(values[it.col()]) + (factor > 0.0 ? factor * contact_.reach[it.col()] : 0.0));
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
    const std::size_t with_rates = n_with_rates(group);
    std::vector<double> rates(group.states.size());
    for (int p = 0; p < group.n_points; ++p) {
      const auto own = inputs_of_point(group, p, inputs);
      auto z = of_point(group, p, accepted_);
      if (with_rates > 0 && !solve_rates(g, p, share, own, z)) return false;
      if (with_rates < z.size()) {
        rates_[g].rates(p, t_, z, own, rates);
        std::copy(rates.begin() + static_cast<std::ptrdiff_t>(with_rates), rates.end(),
                  z.begin() + static_cast<std::ptrdiff_t>(with_rates));
      }
      for (std::size_t i = 0; i < z.size(); ++i)
        values[contact_.first_state[group.states[i]] + p] = z[i];
    }
  }
  return values.allFinite();
}

/// The states of point p that have rates, from the accepted ones on; these read no algebraic ones.
bool PointStates::solve_rates(std::size_t g, int p, double share, std::span<const double> inputs,
                              std::span<double> z) const {
  const auto& group = contact_.state_groups[g];
  const std::size_t n = n_with_rates(group), all = z.size();
  LocalEquation local;
  local.factor = share * factor_;
  for (std::size_t i = 0; i < n; ++i) {
    const auto& spec = problem_.states[static_cast<std::size_t>(group.states[i])];
    local.low.push_back(spec.low);
    local.high.push_back(spec.high);
    const double known = known_[contact_.first_state[group.states[i]] + p];
    local.known.push_back(z[i] + share * (known - z[i]));
  }
  std::vector<double> at(z.begin(), z.end()), room(all), square(all * all);
  const auto full = [&](std::span<const double> own) -> std::span<const double> {
    std::ranges::copy(own, at.begin());
    return at;
  };
  local.rates = [&](std::span<const double> own, std::span<double> out) {
    rates_[g].rates(p, t_, full(own), inputs, room);
    std::copy_n(room.begin(), n, out.begin());
  };
  local.derivatives = [&](std::span<const double> own, std::span<double> out) {
    rates_[g].derivatives(p, t_, full(own), inputs, square, {});
    for (std::size_t i = 0; i < n; ++i)
      std::copy_n(square.begin() + static_cast<std::ptrdiff_t>(i * all), n,
                  out.begin() + static_cast<std::ptrdiff_t>(i * n));
  };
  local.terms = [&](std::span<const double> own, std::span<double> out) {
    terms_of_rates(g, p, full(own), inputs, room);
    std::copy_n(room.begin(), n, out.begin());
  };
  return solve_local(local, z.first(n));
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

GroupRates PointStates::rates_of_group(std::size_t g, const Vector& states,
                                       const Vector& inputs) const {
  const auto& group = contact_.state_groups[g];
  std::vector<const double*> z, a;
  for (const int i : group.states) z.push_back(states.data() + contact_.first_state[i]);
  for (int j = 0; j < group.n_inputs(); j += group.n_points)
    a.push_back(inputs.data() + group.first_input + j);
  GroupRates out;
  out.states = group.states.size(), out.points = static_cast<std::size_t>(group.n_points);
  rates_[g].rates(t_, z, a, out.rates);
  rates_[g].derivatives(t_, z, a, out.derivatives);
  return out;
}

/// (I - c dg/dz) dz = c dg/da da on the states that are not held at an end.
SparseMatrix PointStates::slopes(const Vector& inputs, double share, const Vector& values) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    const auto n = static_cast<Eigen::Index>(group.states.size());
    const auto n_in = static_cast<Eigen::Index>(group.fields.size() + group.multipliers.size());
    const GroupRates of = rates_of_group(g, values, inputs);
    DenseMatrix left(n, n), right(n, n_in);
    for (int p = 0; p < group.n_points; ++p) {
      left.setIdentity();
      right.setZero();
      for (Eigen::Index i = 0; i < n; ++i) {
        const int state = group.states[static_cast<std::size_t>(i)];
        const auto& spec = problem_.states[static_cast<std::size_t>(state)];
        const int at = contact_.first_state[state] + p;
        const double part = spec.algebraic ? 1.0 : share, c = part * factor(state);
        const double known = accepted_[at] + part * (known_[at] - accepted_[at]);
        const double moved = known + c * of.rate(i, p);
        if (moved <= spec.low || moved >= spec.high) continue;
        for (Eigen::Index j = 0; j < n; ++j) left(i, j) -= c * of.by_state(i, j, p);
        for (Eigen::Index j = 0; j < n_in; ++j) right(i, j) = c * of.by_input(i, j, p);
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
    const GroupRates of = rates_of_group(g, contact_.state_values, inputs.values);
    std::vector<double> residual(n, 0.0);
    for (std::size_t p = 0; p < of.points; ++p) {
      for (std::size_t i = 0; i < n; ++i) {
        const int state = group.states[i];
        const auto& spec = problem_.states[static_cast<std::size_t>(state)];
        const auto at = contact_.first_state[state] + static_cast<Eigen::Index>(p);
        const double rate = of.rate(i, p), z = contact_.state_values[at];
        const double moved = known_[at] + factor(state) * rate;
        const double left =
            std::abs(z - std::clamp(moved, spec.low, spec.high)) / steepness(group, i, of, p);
        residual[i] = std::isfinite(left) ? std::max(residual[i], left) : infinity;
        if (!std::isfinite(rate) && !out.no_rate) {
          const LawPoints& points = points_of(contact_, group);
          out.no_rate = {state, points.x[p], points.dim, rate, z};
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

/// By how much more the residual of the equation of state i changes than the state, at point p.
double PointStates::steepness(const StateGroup& group, std::size_t i, const GroupRates& of,
                              std::size_t p) const {
  double out = 1.0;
  for (std::size_t j = 0; j < of.states; ++j)
    out = std::max(out, std::abs(factor(group.states[i]) * of.by_state(i, j, p)));
  return out;
}

/// What the inputs' scales make of the states of a group in the step, column by column: by the
/// slopes of their rates, and where products of inputs are products of rounding, by the rates one
/// scale away, with the slopes there: a rate that begins at a threshold is flat before it and may
/// be steep behind.
std::vector<double> PointStates::made_of_scales(std::size_t g, const StateInputs& inputs) const {
  const auto& group = contact_.state_groups[g];
  const std::size_t n = group.states.size(), n_in = group.fields.size() + group.multipliers.size();
  const GroupRates here = rates_of_group(g, contact_.state_values, inputs.values);
  const auto at = [&](std::size_t j, std::size_t p) {
    return group.first_input + static_cast<Eigen::Index>(j * here.points + p);
  };
  std::vector<double> out(n * here.points, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t p = 0; p < here.points; ++p)
      for (std::size_t j = 0; j < n_in; ++j)
        out[i * here.points + p] += factor(group.states[i]) / steepness(group, i, here, p) *
                                    std::abs(here.by_input(i, j, p)) * inputs.scales[at(j, p)];
  for (const double sign : {-1.0, 1.0}) {
    const GroupRates there =
        rates_of_group(g, contact_.state_values, inputs.values + sign * inputs.scales);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t p = 0; p < here.points; ++p) {
        const double change = factor(group.states[i]) *
                              std::abs(there.rate(i, p) - here.rate(i, p)) /
                              std::max(steepness(group, i, here, p), steepness(group, i, there, p));
        double& made = out[i * here.points + p];
        if (std::isfinite(change)) made = std::max(made, change);
      }
  }
  return out;
}

std::vector<double> PointStates::sizes(const StateInputs& inputs) const {
  // A state goes no farther than its range, but for what rounding of its inputs does.
  const auto within_range = [](double made, const StateTerm& state) {
    return std::min(made, std::max(state.high - state.low, rounding_beside_tolerance * made));
  };
  std::vector<double> out(problem_.states.size(), 0.0);
  for (std::size_t g = 0; g < rates_.size(); ++g) {
    const auto& group = contact_.state_groups[g];
    const auto made = made_of_scales(g, inputs);
    auto of_state = made.begin();
    for (const int state : group.states) {
      double& size = out[static_cast<std::size_t>(state)];
      const StateTerm& term = problem_.states[static_cast<std::size_t>(state)];
      const int first = contact_.first_state[state];
      for (int at = first; at < first + group.n_points; ++at, ++of_state)
        size = std::max({size, std::abs(contact_.state_values[at]), std::abs(known_[at]),
                         std::abs(accepted_[at]), within_range(*of_state, term)});
    }
  }
  share_sizes(out);
  return out;
}

/// The entries of a load have that of the largest: the shear of a flow leaves rounding in its other
/// strains.
void PointStates::share_sizes(std::vector<double>& sizes) const {
  const auto& states = problem_.states;
  for (std::size_t i = 0; i < states.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (states[i].algebraic && states[j].algebraic && states[i].part == states[j].part &&
          states[i].name == states[j].name)
        sizes[i] = sizes[j] = std::max(sizes[i], sizes[j]);
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
  if (scheme_) {
    Vector moved = contact_.state_values - accepted_;
    scheme_->accept(n, moved);
  }
  accepted_ = contact_.state_values;
}

void PointStates::save(StateWriter& w) const {
  if (none()) return;
  put_vector(w, accepted_);
  if (scheme_) scheme_->save(w);
}

void PointStates::restore(StateReader& r) {
  if (none()) return;
  get_vector(r, accepted_, accepted_.size());
  if (scheme_) scheme_->restore(r);
  give_up();
}

} // namespace hvi::solver
