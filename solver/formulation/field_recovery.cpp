// Whole fields and single dofs; see field_recovery.hpp.
#include "solver/formulation/field_recovery.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {

void FieldRecovery::scatter(const Vector& y, Vector& full) {
  if (last_.y.size() != y.size() || last_.y != y) {
    const Vector* const alone[] = {&y};
    DenseMatrix rows;
    expand(interior_, alone, rows);
    take_row(interior_, rows, 0, last_.unknowns);
    last_.y = y;
  }
  interior_.layout.scatter(last_.unknowns, full);
}

void FieldRecovery::observe(std::span<const int> dofs) {
  for (const int dof : dofs) {
    const int unknown = interior_.layout.entry_of[dof];
    const auto same = [&](const Observed& o) { return o.dof == dof; };
    if (unknown < 0 || std::any_of(observed_.begin(), observed_.end(), same)) continue;
    Observed out{dof, unknown, {}, {}};
    if (interior_.position[unknown] < 0) {
      // (E^T e_i)_c = -T_cI T_II^-1 e_i: what the forward solve makes of e_i.
      Vector e = Vector::Zero(interior_.layout.n_unknowns);
      e[unknown] = 1.0;
      Vector y;
      forward(*interior_.factor, e, y, out.row);
      for (const Vector& of_mode : interior_.kept)
        out.modes.push_back(y.head(interior_.n_interior()).dot(of_mode));
    }
    observed_.push_back(std::move(out));
  }
}

void FieldRecovery::scatter_observed(const Vector& y, Vector& full) const {
  for (int c = 0; c < interior_.n_contact(); ++c)
    full[interior_.layout.dof_of[interior_.contact[c]]] = y[c];
  for (const DofLink& link : interior_.layout.links) full[link.dof] = full[link.to];
  for (const auto& o : observed_) {
    if (o.row.size() == 0) continue;
    double value = o.row.dot(y.head(interior_.n_contact()));
    for (std::size_t k = 0; k < o.modes.size(); ++k)
      value += y[interior_.n_contact() + static_cast<int>(k)] * o.modes[k];
    full[o.dof] = value;
  }
}

} // namespace hvi::solver
