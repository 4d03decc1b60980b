// Equilibrium of all rows, where steps are solved on the contact unknowns.
#pragma once

#include "solver/formulation/interior.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// max_i |R|_i / (|T|(|a| + |b|) + |f|)_i on all unknowns with R = f - T (a + b) - G^T W xi, where
/// a and b are the states that `known` and `change` stand for (each counts in the scale: they may
/// cancel, as at the end of a cycle) and f the load that `load` stands for. With |T||a + b| in its
/// place, which is not larger, where that is within `enough`: it takes one state instead of two.
class InteriorEquilibrium {
public:
  /// Keeps a reference to `interior`, whose modes are all known; `force`: G^T W on all unknowns.
  InteriorEquilibrium(const Interior& interior, const SparseMatrix& force)
      : interior_(interior), force_(force) {}

  /// What is asked of one step.
  struct Question {
    Vector known, change, load, xi;
  };
  double error(const Question& step, double enough) const;
  /// The same for up to 16 steps in one reading of the factor and of T. A step's answer does not
  /// depend on the steps it is asked with. The same reading of the factor finds the unknowns of
  /// `more`, which are asked for next.
  std::vector<double> errors(std::span<const Question> steps, double enough,
                             std::span<KnownField> more = {}) const;
  static constexpr int most_steps = 2 * RightHandSides::at_once;

private:
  const Interior& interior_;
  SparseMatrix force_;
};

} // namespace hvi::solver
