// Fields of all unknowns from the contact unknowns and the modes.
#pragma once

#include "solver/formulation/interior.hpp"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

class FieldRecovery {
public:
  /// Keeps a reference to `interior`, whose modes are all known.
  explicit FieldRecovery(const Interior& interior) : interior_(interior) {}

  /// Full vector of y: a backward solve, unless its field is the last one that was found or kept.
  /// Both give the same bits.
  void scatter(const Vector& y, Vector& full);
  void keep(KnownField field) { last_ = std::move(field); }
  /// Makes these dofs available without triangular solves; prepares one row for each by a solve.
  void observe(std::span<const int> dofs);
  /// Only the observed dofs and the contact unknowns of `full` are set.
  void scatter_observed(const Vector& y, Vector& full) const;

private:
  struct Observed {
    int dof, unknown;
    Vector row;                ///< over c; empty: a contact unknown
    std::vector<double> modes; ///< p_k there
  };

  const Interior& interior_;
  std::vector<Observed> observed_;
  KnownField last_;
};

} // namespace hvi::solver
