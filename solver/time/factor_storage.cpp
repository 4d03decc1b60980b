// Factors with fewer bits; see factor_storage.hpp. Used by the StepSolver.
#include "solver/time/factor_storage.hpp"

#include "solver/common/stream.hpp"

#include <limits>

namespace hvi::solver {
namespace {

/// No factor of more bytes is made once more with fewer bits.
constexpr double largest_shortened = 4e9;

} // namespace

SweepLimits FactorStorage::begin(const StepMatrix& matrix, bool predicted, bool contact) {
  const bool shortened = shortened_ == &matrix && predicted;
  const SweepLimits out = shortened ? sweeps_.limits(contact) : SweepLimits{};
  sweeps_.note_moved(std::numeric_limits<double>::infinity());
  return out;
}

void FactorStorage::learn(const Correction& correction, bool exact, double error) {
  sweeps_.note_moved(correction.moved);
  if (correction.forward != SweepStorage::full && exact)
    sweeps_.learn(correction.forward, correction.back, error);
}

void FactorStorage::choose(StepMatrix& matrix, bool predictable, int steps_left) {
  if (!allowed_) return;
  if (shortened_ == nullptr) {
    if (!predictable || !sweeps_.worthwhile(steps_left)) return;
    allowed_ = matrix.statistics().bytes <= largest_shortened && matrix.shorten();
    if (allowed_) shortened_ = &matrix;
    return;
  }
  if (shortened_ != &matrix) return;
  sweeps_.count_step();
  if (sweeps_.failed()) forbid();
}

void FactorStorage::save(std::ostream& out, const StepMatrices& matrices) const {
  StateWriter w(out);
  w.put(std::array<int, 2>{matrices.place_of(shortened_), allowed_ ? 1 : 0});
  sweeps_.save(out);
}

void FactorStorage::restore(std::istream& in, const StepMatrices& matrices) {
  StateReader r(in, {});
  const auto saved = r.get<std::array<int, 2>>();
  StepMatrix* matrix = matrices.at(saved[0]);
  shortened_ = matrix != nullptr && matrix->shorten() ? matrix : nullptr;
  allowed_ = saved[1] != 0;
  sweeps_.restore(in);
}

} // namespace hvi::solver
