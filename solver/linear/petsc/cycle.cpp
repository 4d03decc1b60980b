// See cycle.hpp.
#include "solver/linear/petsc/cycle.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::petsc_module {
namespace {

/// Laws whose stiffness is beyond this part of the body's are solved exactly with their layers, and
/// the multigrid has no more of them: what is rigid would hold whatever interpolates from there.
constexpr double stiff_part = 0.5;

std::vector<int> rows_of_laws(const Rows& h) {
  std::vector<int> out;
  for (int i = 0; i < h.size(); ++i)
    if (h.start[i] < h.start[i + 1]) out.push_back(i);
  return out;
}

} // namespace

Cycle::Cycle(const Distribution& distribution, const WholeMatrix& k, Mat matrix,
             const std::vector<double>& motions, int n_motions)
    : distribution_(distribution), k_(k), multigrid_(matrix, motions, n_motions) {
  check(MatCreateVecs(matrix, work_.put(), rest_.put()));
}

void Cycle::matrix_changed() {
  if (layers_) layers_->matrix_changed(work_.get());
}

bool Cycle::stiff(const Rows& h) const {
  for (int i = 0; i < h.size(); ++i) {
    if (h.start[i] == h.start[i + 1]) continue;
    double law = 0.0;
    for (int e = h.start[i]; e < h.start[i + 1]; ++e) law += std::abs(h.value[e]);
    if (law > stiff_part * std::abs(k_.entry(i, i))) return true;
  }
  return false;
}

/// S H S, S_ii^2 = stiff_part K_ii / H_ii where H is stiffer than that, and 1 where it is not.
/// Where H is not symmetric, entries with H_ij^2 > |H_ii H_jj| are left out: they might outweigh
/// all others.
Rows Cycle::not_stiffer(const Rows& h, bool symmetric) const {
  std::vector<double> law(static_cast<std::size_t>(h.size())), scale(law.size(), 1.0);
  for (int i = 0; i < h.size(); ++i) {
    if (h.start[i] == h.start[i + 1]) continue;
    law[i] = entry(h.view(), i, i);
    const double most = stiff_part * std::abs(k_.entry(i, i));
    if (law[i] > most) scale[i] = std::sqrt(most / law[i]);
  }
  Rows out = h;
  for (int i = 0; i < h.size(); ++i)
    for (int e = h.start[i]; e < h.start[i + 1]; ++e) {
      const int j = h.column[e];
      const double root = std::sqrt(std::abs(law[i])) * std::sqrt(std::abs(law[j]));
      const bool left_out = !symmetric && i != j && std::abs(h.value[e]) > root;
      out.value[e] = left_out ? 0.0 : scale[i] * h.value[e] * scale[j];
    }
  return out;
}

void Cycle::give_to_multigrid(const Rows& h) {
  Rows mine;
  multigrid_.set_laws(distribution_, distribution_.deal(h.view(), mine));
}

bool Cycle::leave_laws() { return multigrid_.leave_laws(); }

bool Cycle::set_laws(const Rows& h, const FewRows& rows, bool symmetric, double shift) {
  law_rows_ = &rows;
  k_.need(rows_of_laws(h));
  give_to_multigrid(not_stiffer(h, symmetric));
  in_layers_ = distribution_.of_first(stiff(h));
  if (!in_layers_) return true;
  if (distribution_.of_first(!layers_ || !layers_->fit(h)))
    layers_ = std::make_unique<Layers>(distribution_, work_.get(), k_, h);
  in_layers_ = layers_->factor(h, symmetric, shift);
  ++local_factors_;
  return in_layers_;
}

/// As in layers.hpp.
PetscErrorCode Cycle::apply(Vec r, Vec z) {
  if (!in_layers_) return multigrid_.apply(r, z);
  const Vec rest = rest_.get(), work = work_.get();
  PetscCall(VecSet(z, 0.0));
  PetscCall(layers_->add_solved(r, z));
  PetscCall(rest_near_laws(r, z));
  PetscCall(multigrid_.apply(rest, work));
  PetscCall(VecAXPY(z, 1.0, work));
  PetscCall(rest_near_laws(r, z));
  return layers_->add_solved(rest, z);
}

/// r - (K + H) z, right where laws act and next to it.
PetscErrorCode Cycle::rest_near_laws(Vec r, Vec z) const {
  PetscCall(VecCopy(r, rest_.get()));
  PetscCall(layers_->subtract_product(z, rest_.get()));
  return law_rows_->add_product(-1.0, z, rest_.get());
}

Effort Cycle::effort() const {
  const double layers = layers_ ? layers_->bytes() : 0.0;
  return {multigrid_.bytes() + layers, multigrid_.seconds, local_factors_, multigrid_.levels()};
}

} // namespace hvi::petsc_module
