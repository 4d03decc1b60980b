// Factors in reduced precision; see factor_storage.hpp. Used by the StepSolver.
#include "solver/time/factor_storage.hpp"

#include "solver/common/stream.hpp"

#include <limits>

namespace hvi::solver {
namespace {

/// No factor of more bytes is stored once more with fewer bits.
constexpr double largest_reduced = 4e9;

} // namespace

PrecisionLimits FactorStorage::begin(const StepMatrix& matrix, bool predicted, bool contact) {
  const bool reduced = reduced_ == &matrix && predicted;
  const PrecisionLimits out = reduced ? choice_.limits(contact) : PrecisionLimits{};
  choice_.note_moved(std::numeric_limits<double>::infinity());
  return out;
}

void FactorStorage::learn(const Correction& correction, bool exact, double error) {
  choice_.note_moved(correction.moved);
  if (correction.forward != FactorPrecision::full && exact)
    choice_.learn(correction.forward, correction.back, error);
}

void FactorStorage::choose(StepMatrix& matrix, bool predictable, int steps_left) {
  if (!allowed_) return;
  if (reduced_ == nullptr) {
    if (!predictable || !choice_.worthwhile(steps_left)) return;
    allowed_ = matrix.statistics().bytes <= largest_reduced && matrix.reduce_precision();
    if (allowed_) reduced_ = &matrix;
    return;
  }
  if (reduced_ != &matrix) return;
  choice_.count_step();
  if (choice_.failed()) forbid();
}

void FactorStorage::save(std::ostream& out, const StepMatrices& matrices) const {
  StateWriter w(out);
  w.put(std::array<int, 2>{matrices.place_of(reduced_), allowed_ ? 1 : 0});
  choice_.save(out);
}

void FactorStorage::restore(std::istream& in, const StepMatrices& matrices) {
  StateReader r(in, {});
  const auto saved = r.get<std::array<int, 2>>();
  StepMatrix* matrix = matrices.at(saved[0]);
  reduced_ = matrix != nullptr && matrix->reduce_precision() ? matrix : nullptr;
  allowed_ = saved[1] != 0;
  choice_.restore(in);
}

} // namespace hvi::solver
