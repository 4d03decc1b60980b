// See mixed_solves.hpp.
#include "solver/linear/mixed/mixed_solves.hpp"

#include "solver/common/stream.hpp"
#include "solver/linear/mixed/precision_choice.hpp"
#include "solver/linear/mixed/rounded_factor.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace hvi::solver {
namespace {

/// No factor of more bytes is stored once more with fewer bits.
constexpr double largest_reduced = 4e9;

class MixedSolves final : public CorrectionSolves {
public:
  MixedSolves(double tolerance, bool laws)
      : CorrectionSolves(tolerance), laws_(laws), choice_(tolerance) {}

  double begin(const SparseMatrix& k, bool guessed) override;
  void forward(Factorisation& factor, Vector& y) override;
  void back(Factorisation& factor, double moved, Vector& y) override;
  void judge(double moved, double error, bool exact) override;
  void accept(const SparseMatrix& k, const Factorisation& factor, bool predictable,
              int steps_left) override;
  void stop() override;
  FactorStatistics statistics() const override { return rounded_.statistics(); }
  void save(std::ostream& out, std::span<const SparseMatrix* const> matrices) override;
  void restore(std::istream& in, std::span<const SparseMatrix* const> matrices) override;

private:
  bool laws_, allowed_ = true;
  const SparseMatrix* of_ = nullptr; ///< whose factor may be read in reduced precision
  RoundedFactor rounded_;
  PrecisionChoice choice_;
  struct Correction {
    bool first_of_guess = false; ///< the next one is the first one of a guessed state
    PrecisionLimits limits;      ///< for the next one
    FactorPrecision forward = FactorPrecision::full, back = FactorPrecision::full; ///< of the last
  } correction_;
};

double MixedSolves::begin(const SparseMatrix& k, bool guessed) {
  correction_.first_of_guess = guessed;
  correction_.limits = of_ == &k && guessed ? choice_.limits(laws_) : PrecisionLimits{};
  choice_.note_moved(std::numeric_limits<double>::infinity());
  return of_ == &k ? choice_.target() : tolerance();
}

void MixedSolves::forward(Factorisation& factor, Vector& y) {
  correction_.forward = correction_.limits.forward;
  if (correction_.forward != FactorPrecision::full && rounded_.take(factor))
    return rounded_.forward(correction_.forward, y);
  correction_.forward = FactorPrecision::full;
  factor.forward(y, Columns::interior);
}

/// The correction of the contact unknowns moves the whole body: where it is large, reduced
/// precision would leave an error of its size, however small all was before the solve.
void MixedSolves::back(Factorisation& factor, double moved, Vector& y) {
  correction_.back = correction_.forward;
  if (correction_.forward != FactorPrecision::full && factor.order().contacts() > 0)
    correction_.back = correction_.limits.back(moved);
  if (correction_.back != FactorPrecision::full) return rounded_.back(correction_.back, y);
  if (correction_.forward != FactorPrecision::full) rounded_.complete(y);
  factor.back(y, Columns::interior);
}

void MixedSolves::judge(double moved, double error, bool exact) {
  correction_
      .limits = {}; // what the first correction leaves, the others finish in double precision
  if (!std::exchange(correction_.first_of_guess, false)) return;
  choice_.note_moved(moved);
  if (correction_.forward != FactorPrecision::full && exact)
    choice_.learn(correction_.forward, correction_.back, error);
}

void MixedSolves::accept(const SparseMatrix& k, const Factorisation& factor, bool predictable,
                         int steps_left) {
  if (!allowed_) return;
  if (of_ == nullptr) {
    if (!predictable || !choice_.worthwhile(steps_left)) return;
    allowed_ = factor.statistics().bytes <= largest_reduced && rounded_.take(factor);
    if (allowed_) of_ = &k;
    return;
  }
  if (of_ != &k) return;
  choice_.count_step();
  if (choice_.failed()) stop();
}

void MixedSolves::stop() {
  allowed_ = false, of_ = nullptr;
  correction_.limits = {};
  rounded_.forget();
}

void MixedSolves::save(std::ostream& out, std::span<const SparseMatrix* const> matrices) {
  StateWriter w(out);
  const auto place = std::ranges::find(matrices, of_) - matrices.begin();
  w.put(of_ == nullptr ? -1 : static_cast<int>(place));
  w.put(allowed_ ? 1 : 0);
  choice_.save(out);
}

void MixedSolves::restore(std::istream& in, std::span<const SparseMatrix* const> matrices) {
  StateReader r(in, {});
  const int place = r.get_between(-1, static_cast<int>(matrices.size()) - 1);
  of_ = place < 0 ? nullptr : matrices[static_cast<std::size_t>(place)];
  allowed_ = r.get_between(0, 1) != 0;
  choice_.restore(in);
}

} // namespace

std::unique_ptr<CorrectionSolves> mixed_solves(double tolerance, bool laws) {
  return std::make_unique<MixedSolves>(tolerance, laws);
}

} // namespace hvi::solver
