// See changed_unknowns.hpp.
#include "solver/linear/changed_unknowns.hpp"

#include <utility>

namespace hvi::solver {
namespace {

class InOtherUnknowns final : public Factorisation {
public:
  InOtherUnknowns(std::unique_ptr<Factorisation> of_changed,
                  std::shared_ptr<const BasisChange> change)
      : inner_(std::move(of_changed)), change_(std::move(change)) {
    take_order();
  }

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<InOtherUnknowns>(inner_->another(), change_);
  }
  void factor(const SparseMatrix& k) override {
    inner_->factor(change_->congruent(k));
    take_order(); // which the values may have chosen
  }
  void forward(RightHandSides y, Columns columns) override { inner_->forward(y, columns); }
  void back(RightHandSides y, Columns columns) override { inner_->back(y, columns); }
  const DenseMatrix& schur() const override { return inner_->schur(); }
  bool solve_schur(DenseMatrix& columns) const override { return inner_->solve_schur(columns); }
  const EliminationOrder& order() const override { return order_; }
  const FactorStatistics& statistics() const override { return inner_->statistics(); }
  const Factorisation& inner() const { return *inner_; }

private:
  void take_order() {
    order_ = inner_->order();
    order_.change = change_;
  }

  std::unique_ptr<Factorisation> inner_;
  std::shared_ptr<const BasisChange> change_;
  EliminationOrder order_;
};

} // namespace

std::unique_ptr<Factorisation> with_changed_unknowns(std::unique_ptr<Factorisation> of_changed,
                                                     std::shared_ptr<const BasisChange> change) {
  return std::make_unique<InOtherUnknowns>(std::move(of_changed), std::move(change));
}

const Factorisation& eliminating(const Factorisation& of) {
  const auto* const changed = dynamic_cast<const InOtherUnknowns*>(&of);
  return changed != nullptr ? changed->inner() : of;
}

} // namespace hvi::solver
