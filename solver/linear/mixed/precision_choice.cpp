// See precision_choice.hpp.
#include "solver/linear/mixed/precision_choice.hpp"

#include "solver/common/stream.hpp"

#include <algorithm>
#include <array>

namespace hvi::solver {
namespace {

/// A correction of the extrapolated increment in reduced precision is accepted when its error is
/// within this part of the certificate's tolerance.
constexpr double part_for_rounding = 0.05;
/// A reduced-precision factor is made when at least so many steps are left.
constexpr int worth_rounding = 24;
/// How far contact unknowns may move, over the target: first guesses, lowered where a step shows
/// that they were too much.
constexpr double first_most_single = 5e7, first_most_fine = 2e11;
/// And by which part of their size at the most.
constexpr double cap_single = 0.1, cap_fine = 1.0;
/// Where they move further the extrapolation is poor: the forward solve takes more bits.
constexpr double moved_for_single_forward = 0.02;

} // namespace

PrecisionChoice::PrecisionChoice(double tolerance) : target_(part_for_rounding * tolerance) {}

double PrecisionChoice::most(FactorPrecision storage) const {
  const bool single = storage == FactorPrecision::single;
  const double gain = single ? known_.gain_single : known_.gain_fine;
  const double learnt = gain > 0.0 ? 0.5 / gain : single ? first_most_single : first_most_fine;
  return std::min(single ? cap_single : cap_fine, learnt * target_);
}

bool PrecisionChoice::worthwhile(int steps_left) const {
  return steps_left >= worth_rounding && !failed() && known_.moved <= most(FactorPrecision::fine);
}

PrecisionLimits PrecisionChoice::limits(bool contact) const {
  PrecisionLimits out;
  const double single = most(FactorPrecision::single), fine = most(FactorPrecision::fine);
  if (!(known_.moved <= fine)) return out;
  const bool near = known_.moved <= (contact ? moved_for_single_forward : single);
  out.forward = known_.forward_single && near ? FactorPrecision::single : FactorPrecision::fine;
  out.most_single = single, out.most_fine = fine;
  return out;
}

void PrecisionChoice::learn(FactorPrecision forward, FactorPrecision back, double error) {
  const bool single = back == FactorPrecision::single;
  if (single && known_.moved > 0.0 && (error > 1e-3 * target_ || known_.moved > 0.1 * most(back)))
    known_.gain_single = std::max(known_.gain_single, error / known_.moved);
  if (single || error <= target_) return;
  if (forward == FactorPrecision::single) {
    known_.forward_single = false; // it is to blame: back with 48 bits leaves less
    return;
  }
  ++known_.misses;
  if (back == FactorPrecision::fine && known_.moved > 0.0)
    known_.gain_fine = std::max(known_.gain_fine, error / known_.moved);
}

void PrecisionChoice::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(std::array<double, 3>{known_.gain_single, known_.gain_fine, known_.moved});
  w.put(std::array<int, 3>{known_.steps, known_.misses, known_.forward_single ? 1 : 0});
}

void PrecisionChoice::restore(std::istream& in) {
  StateReader r(in, {});
  const auto numbers = r.get<std::array<double, 3>>();
  const auto counts = r.get_counts<3>();
  known_.gain_single = numbers[0], known_.gain_fine = numbers[1], known_.moved = numbers[2];
  known_.steps = counts[0], known_.misses = counts[1], known_.forward_single = counts[2] != 0;
}

} // namespace hvi::solver
