// The rates g(z, a, t) of states at points (point_states.hpp), with their derivatives.
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/kernel/tape.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// The rates of a group's states, compiled with their derivatives.
class StateRates {
public:
  StateRates(const Problem& problem, const StateGroup& group, const LawPoints& points);

  /// Of point p at time t: rates and, where they are asked for, their derivatives by the states
  /// (row by row) and by the inputs. `z`, `inputs`: the point's own.
  void rates(int p, double t, std::span<const double> z, std::span<const double> inputs,
             std::span<double> out) const;
  void derivatives(int p, double t, std::span<const double> z, std::span<const double> inputs,
                   std::span<double> by_state, std::span<double> by_input) const;

  /// The same of all points at once: z[i] and inputs[j] are columns of their values; number k of
  /// point p is out[k n_points + p]. Derivatives by the states come first, then those by the
  /// inputs.
  using Columns = std::span<const double* const>;
  void rates(double t, Columns z, Columns inputs, std::vector<double>& out) const;
  void derivatives(double t, Columns z, Columns inputs, std::vector<double>& out) const;

private:
  struct Source {
    enum class Kind { place, normal, time, state, input, inside } kind;
    int index = 0;
  };
  std::vector<Source> sources(const Tape& tape, const StateGroup& group) const;
  void run(const Tape& tape, const std::vector<Source>& sources, int p, double t,
           std::span<const double> z, std::span<const double> inputs, std::span<double> out) const;
  void run(const Tape& tape, const std::vector<Source>& sources, double t, Columns z,
           Columns inputs, std::vector<double>& out) const;
  double of_place(const Source& source, std::size_t point) const;

  int n_ = 0;
  const LawPoints& points_;
  Tape rates_, derivatives_;
  std::vector<Source> of_rates_, of_derivatives_;
};

} // namespace hvi::solver
