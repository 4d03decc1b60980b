// The states at contact points in the steps of a run: bonding fields, wear, ages of contacts.
//
// A state z' = g(z, a, t), kept in [low, high], is written with the derivative of the run's scheme,
// z'(t_n) = f (z_n - z_{n-1}) + known part, at every point:
//
//   z_n = P(b_n + g(z_n, a_n, t_n) / f),    P the projection on [low, high],
//
// b_n known (backward Euler: z_{n-1}, 1/f = k). a_n, the inputs, are values of u and u' and
// multipliers at the end of the step: state and inequality hold at once (state_coupling.hpp).
//
// An algebraic state is z_n = g(z_n, a_n, t_n), the same with b_n = 0 and f = 1; g reads others
// only.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/state_rates.hpp"
#include "solver/step/evolution.hpp"

#include <optional>

namespace hvi::solver {

/// How well the states' equations hold.
struct StateError {
  double worst = 0.0; ///< see PointStates::error
  int state = -1;     ///< of the plan; -1: none
  /// Where a rate is no number.
  struct NoRate {
    int state = 0;
    Point x{};
    int dim = 3;
    double rate = 0.0, value = 0.0; ///< of the state
  };
  std::optional<NoRate> no_rate{};
};

/// What the rates read, and of what size that is: an input of rounding's size, as the slip rate of
/// a body that sticks, is known up to a part of the scale only (certificate.hpp, inclusion_error).
struct StateInputs {
  Vector values, scales;
};

/// The rates of a group's states and their derivatives at all points, column by column.
struct GroupRates {
  std::size_t states = 0, points = 0;
  std::vector<double> rates, derivatives;

  double rate(std::size_t i, std::size_t p) const { return rates[i * points + p]; }
  double by_state(std::size_t i, std::size_t j, std::size_t p) const {
    return derivatives[(i * states + j) * points + p];
  }
  double by_input(std::size_t i, std::size_t j, std::size_t p) const {
    const std::size_t inputs = derivatives.size() / (states * points) - states;
    return derivatives[(states * states + i * inputs + j) * points + p];
  }
};

class PointStates {
public:
  /// Keeps references to all of them; the values are in contact.state_values.
  PointStates(const Problem& problem, const Evolution& evolution, Contact& contact);

  bool none() const { return contact_.state_groups.empty(); }
  int n_inputs() const { return static_cast<int>(contact_.trace.rows()); }
  double t() const { return t_; } ///< of the step

  /// The algebraic states of the initial time, when the evolution has its initial state.
  void start();
  /// Step n starts at the accepted values, those that are the same everywhere, as time is, at the
  /// values of its end.
  void begin(int n);
  /// What the rates read at the state u of step n (increment d, where u has it already) with the
  /// multipliers xi.
  void inputs(const Vector& u, const Vector* d, const Vector& xi, StateInputs& out) const;
  /// The values that solve the step's equations with these inputs, the first ones that are met from
  /// the accepted values on. With `share` < 1 the step is that part as long. False where a point
  /// has none; `values` is then of no use.
  bool solve(const Vector& inputs, double share, Vector& values) const;
  /// d values / d inputs of such a solution, values x inputs.
  SparseMatrix slopes(const Vector& inputs, double share, const Vector& values) const;
  /// d inputs / d increment of the contact unknowns where multipliers hold still, and d inputs / d
  /// multipliers.
  SparseMatrix by_unknowns() const;
  SparseMatrix by_multipliers() const;

  /// max |z - P(b + g / f)| / (size max(1, |dg/dz| / f)) over all points, of the present values
  /// with these inputs: by how much of its size a state would have to change for its equation to
  /// hold. From the definition, not from `solve`. The size of a state is the largest of its values
  /// now and before, and of what its inputs' scales make of it in the step.
  StateError error(const StateInputs& inputs) const;
  /// The largest difference of the values of a state from the present ones, by its size.
  StateError distance(const Vector& values, const StateInputs& inputs) const;

  /// The values projected on their ranges.
  Vector kept(Vector values) const;

  const Vector& accepted() const { return accepted_; }
  void accept(int n);
  void give_up() { contact_.state_values = accepted_; }
  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  void move_time();
  bool algebraic(int state) const {
    return problem_.states[static_cast<std::size_t>(state)].algebraic;
  }
  /// 1 / f of a state.
  double factor(int state) const { return algebraic(state) ? 1.0 : factor_; }
  std::size_t n_with_rates(const StateGroup& group) const; ///< which stand first
  bool solve_rates(std::size_t g, int p, double share, std::span<const double> inputs,
                   std::span<double> z) const;
  void values_of_fields(const StateGroup& group, const LawFields& fields, StateInputs& out) const;
  std::vector<double> of_point(const StateGroup& group, int p, const Vector& values) const;
  std::vector<double> inputs_of_point(const StateGroup& group, int p, const Vector& inputs) const;
  void terms_of_rates(std::size_t g, int p, std::span<const double> z,
                      std::span<const double> inputs, std::span<double> out) const;
  std::vector<double> sizes(const StateInputs& inputs) const;
  void share_sizes(std::vector<double>& sizes) const;
  std::vector<double> made_of_scales(std::size_t g, const StateInputs& inputs) const;
  GroupRates rates_of_group(std::size_t g, const Vector& states, const Vector& inputs) const;
  double steepness(const StateGroup& group, std::size_t i, const GroupRates& of,
                   std::size_t p) const;

  const Problem& problem_;
  const Evolution& evolution_;
  Contact& contact_;
  std::vector<StateRates> rates_;      ///< by group
  std::unique_ptr<TimeScheme> scheme_; ///< of the states; null: none has a rate
  Vector accepted_, known_;
  double factor_ = 1.0, t_ = 0.0; ///< 1 / f, and t_n
  int n_ = 0;
};

} // namespace hvi::solver
