// The forms that states change, as one of several processes assembles them on its own cells: their
// coefficients are those of the states that the first process sends.
#pragma once

#include "solver/discrete/dealt_forms.hpp"
#include "solver/discrete/own_cells.hpp"
#include "solver/linear/own_rows.hpp"

#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

class OwnChangingForms {
public:
  /// `made`: of each form its matrix with the initial states; the first of them is base `first` of
  /// the rows.
  OwnChangingForms(std::unique_ptr<const OwnCells> cells, std::vector<ChangingTerm> terms,
                   std::vector<SparseMatrix> made, int first);
  OwnChangingForms(const OwnChangingForms&) = delete;
  OwnChangingForms& operator=(const OwnChangingForms&) = delete;

  /// The rows become those of these states: by form, and by state that it reads, the values at the
  /// points here, or one for all points (StateReading::uniform). Throws as PointForm::assemble
  /// does.
  void take(std::span<const double> values, OwnRows& rows);

private:
  std::unique_ptr<const OwnCells> cells_;
  std::vector<ChangingTerm> terms_;
  std::vector<SparseMatrix> matrices_;
  std::vector<PointForm> forms_;
  int first_;
};

} // namespace hvi::solver
