// See cycle.hpp.
#include "solver/linear/petsc/cycle.hpp"

#include <cmath>

namespace hvi::petsc_module {
namespace {

/// Laws whose stiffness is beyond this part of the body's are solved exactly with their layers.
constexpr double stiff_part = 0.5;

} // namespace

Cycle::Cycle(const Distribution& distribution, const HviPetscMatrix& k, Mat matrix,
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
    double own = 0.0, law = 0.0;
    for (int e = k_.start[i]; e < k_.start[i + 1]; ++e)
      if (k_.column[e] == i) own = std::abs(k_.value[e]);
    for (int e = h.start[i]; e < h.start[i + 1]; ++e) law += std::abs(h.value[e]);
    if (law > stiff_part * own) return true;
  }
  return false;
}

bool Cycle::set_laws(const Rows& h, const FewRows& rows, bool symmetric, double shift) {
  law_rows_ = &rows;
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
