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
  bool first_of_guess_ = false; ///< the next correction is the first one of a guessed state
  PrecisionLimits limits_;      ///< for the next correction
  FactorPrecision forward_ = FactorPrecision::full, back_ = FactorPrecision::full; ///< of the last
};

double MixedSolves::begin(const SparseMatrix& k, bool guessed) {
  first_of_guess_ = guessed;
  limits_ = of_ == &k && guessed ? choice_.limits(laws_) : PrecisionLimits{};
  choice_.note_moved(std::numeric_limits<double>::infinity());
  return of_ == &k ? choice_.target() : tolerance();
}

void MixedSolves::forward(Factorisation& factor, Vector& y) {
  forward_ = limits_.forward;
  if (forward_ != FactorPrecision::full && rounded_.take(factor))
    return rounded_.forward(forward_, y);
  forward_ = FactorPrecision::full;
  factor.forward(y, Columns::interior);
}

/// The correction of the contact unknowns moves the whole body: where it is large, reduced
/// precision would leave an error of its size, however small all was before the solve.
void MixedSolves::back(Factorisation& factor, double moved, Vector& y) {
  back_ = forward_;
  if (forward_ != FactorPrecision::full && factor.order().contacts() > 0)
    back_ = limits_.back(moved);
  if (back_ != FactorPrecision::full) return rounded_.back(back_, y);
  if (forward_ != FactorPrecision::full) rounded_.complete(y);
  factor.back(y, Columns::interior);
}

void MixedSolves::judge(double moved, double error, bool exact) {
  limits_ = {}; // what the first correction leaves, the others finish in double precision
  if (!std::exchange(first_of_guess_, false)) return;
  choice_.note_moved(moved);
  if (forward_ != FactorPrecision::full && exact) choice_.learn(forward_, back_, error);
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
  limits_ = {};
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
