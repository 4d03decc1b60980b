// See coupled_readings.hpp. Called by the StepSolver.
#include "solver/step/coupled_readings.hpp"

#include "solver/step/mixing.hpp"

namespace hvi::solver {
namespace {

constexpr int most_passes = 100;

Vector readings_of(const Contact& contact) {
  std::size_t n = 0;
  for (const auto& readings : contact.readings) n += readings.values.size();
  Vector out(static_cast<Eigen::Index>(n));
  Eigen::Index at = 0;
  for (const auto& readings : contact.readings)
    for (const double value : readings.values) out[at++] = value;
  return out;
}

/// Of each law's readings, one after the other.
std::vector<int> kinds_of(const Contact& contact) {
  std::vector<int> out;
  int kind = 0;
  for (const auto& readings : contact.readings) {
    const std::size_t points = readings.n_points();
    for (std::size_t i = 0; i < readings.values.size(); i += points, ++kind)
      out.insert(out.end(), points, kind);
  }
  return out;
}

void set_readings(Contact& contact, const Vector& to) {
  Eigen::Index at = 0;
  for (auto& readings : contact.readings)
    for (double& value : readings.values) value = to[at++];
}

} // namespace

void couple_readings(StepLaws& laws, Contact& contact, double tolerance,
                     const InequalityState* path_start, const StepEquation& equation, Trial& trial,
                     const std::function<StepResult(CorrectionStart)>& solve, StepResult& out) {
  Mixing mixing(kinds_of(contact));
  Vector used = readings_of(contact);
  for (int pass = 0; out.inequality.converged && trial.d.allFinite(); ++pass) {
    laws.read_solution(equation.n, equation.known, &trial.d);
    const double error = laws.settle_bounds(equation.n, equation.known, trial.d, trial.z);
    if (error <= tolerance) return;
    if (pass == most_passes) {
      out.inequality.verdict = "the laws do not hold with what they read of the same state";
      return;
    }
    used = mixing.next(used, readings_of(contact));
    if (!used.allFinite()) return;
    set_readings(contact, used);
    laws.prepare(equation.n, equation.known);
    if (path_start != nullptr) {
      auto& now = laws.now;
      now.z_before = path_start->z_before;
      now.xi_before = path_start->xi, now.state_before = path_start->state;
    }
    const int iterations = out.inequality.iterations, corrections = out.corrections;
    out = solve(CorrectionStart::again);
    out.inequality.iterations += iterations;
    out.corrections += corrections;
  }
}

} // namespace hvi::solver
