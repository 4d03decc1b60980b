// The tensor behind a form, point by point; see tensors.hpp.
#include "solver/hypotheses/tensors.hpp"

#include "solver/discrete/body_states.hpp"
#include "solver/fem/geometry.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/linear/dense.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace hvi::solver {
namespace {

/// Orthonormal basis of the matrices a gradient contributes: symmetric ones (Mandel) for vectors,
/// e_j for scalars. Entry (basis element, gradient index); the last one is the hoop's.
DenseMatrix gradient_basis(int components, int dim, bool hoop) {
  const int more = hoop ? 1 : 0;
  const int n = (components == 1 ? dim : dim * (dim + 1) / 2) + more;
  DenseMatrix basis = DenseMatrix::Zero(n, components * dim + more);
  if (hoop) basis(n - 1, components * dim) = 1.0;
  if (components == 1) {
    basis.setIdentity();
    return basis;
  }
  int row = 0;
  for (int i = 0; i < dim; ++i) basis(row++, i * dim + i) = 1.0;
  for (int i = 0; i < dim; ++i)
    for (int j = i + 1; j < dim; ++j, ++row)
      basis(row, i * dim + j) = basis(row, j * dim + i) = std::sqrt(0.5);
  return basis;
}

/// Row of a gradient entry, or -1 for values.
int gradient_index(int derivative, int components, int dim, bool hoop) {
  if (hoop && derivative == slot::hoop) return components * dim;
  for (int i = 0; i < components; ++i)
    for (int j = 0; j < dim; ++j)
      if (derivative == slot::gradient(i, j)) return i * dim + j;
  return -1;
}

Point middle(const Mesh& mesh, int cell) {
  Point out{};
  for (int k = 0; k <= mesh.dim; ++k)
    for (int a = 0; a < 3; ++a) out[a] += mesh.nodes[mesh.cells[cell][k]][a] / (mesh.dim + 1);
  return out;
}

/// The forms of the field on cells with gradients on both sides, with the initial states.
std::vector<FormTerm> tensor_forms(const Problem& problem, const Discretisation& d, int field) {
  std::vector<FormTerm> out;
  for (const FormTerm& form : problem.forms)
    if (form.field == field && d.parts[form.part].kind == Group::Kind::cells)
      out.push_back(reads_states(form) ? at_initial_states(problem, form) : form);
  return out;
}

class PointwiseTensor {
public:
  PointwiseTensor(const Problem& problem, const Discretisation& d, int field)
      : d_(d), forms_(tensor_forms(problem, d, field)), hoop_(has_hoop(d.space)),
        basis_(gradient_basis(d.space.components, d.mesh.dim, hoop_)) {
    for (const FormTerm& form : forms_) {
      isotropic_ = isotropic_ && is_isotropic(problem, form);
      for (const auto& entry : form.entries) varies_ = varies_ || !entry.coefficient.is_constant();
    }
    for (std::size_t f = 0; isotropic_ && f < forms_.size(); ++f) {
      const auto& [index, factor, unknown] = *forms_[f].tensor;
      const auto& constants = problem.tensors[static_cast<std::size_t>(index)].constants;
      lame_.push_back({factor * constants[0], factor * constants[1]});
    }
  }
  bool empty() const { return forms_.empty(); }
  bool varies() const { return varies_ || forms_.size() > 1 || !covers(); }
  Origin origin() const { return forms_.front().origin; }

  double least(int cell) const { return isotropic_ ? least_of_lame(cell) : least_of_entries(cell); }

private:
  static bool is_isotropic(const Problem& problem, const FormTerm& form) {
    return form.tensor && problem.tensors[static_cast<std::size_t>(form.tensor->index)].kind ==
                              TensorSpec::Kind::isotropic;
  }
  bool acts_on(const FormTerm& form, int cell) const {
    return std::ranges::binary_search(d_.parts[form.part].entities, cell);
  }

  /// 2 mu on strains without trace, d lambda + 2 mu on the unit tensor.
  double least_of_lame(int cell) const {
    const Point x = middle(d_.mesh, cell);
    double lambda = 0.0, mu = 0.0;
    bool any = false;
    for (std::size_t f = 0; f < forms_.size(); ++f) {
      if (!acts_on(forms_[f], cell)) continue;
      lambda += value(lame_[f][0], x, cell);
      mu += value(lame_[f][1], x, cell);
      any = true;
    }
    if (!any) return std::numeric_limits<double>::infinity();
    const int d = hoop_ ? 3 : d_.mesh.dim;
    const double volume = d * lambda + 2.0 * mu;
    return d == 1 ? volume : std::min(2.0 * mu, volume);
  }

  double least_of_entries(int cell) const {
    const Point x = middle(d_.mesh, cell);
    const int n = d_.space.components * d_.mesh.dim + (hoop_ ? 1 : 0);
    DenseMatrix full = DenseMatrix::Zero(n, n);
    bool any = false;
    for (const FormTerm& form : forms_) {
      if (!acts_on(form, cell)) continue;
      for (const auto& entry : form.entries) {
        const int a = gradient_index(entry.test, d_.space.components, d_.mesh.dim, hoop_);
        const int b = gradient_index(entry.trial, d_.space.components, d_.mesh.dim, hoop_);
        if (a < 0 || b < 0) continue;
        full(a, b) += value(entry.coefficient, x, cell);
        any = true;
      }
    }
    if (!any) return std::numeric_limits<double>::infinity();
    const DenseMatrix reduced = basis_ * full * basis_.transpose();
    const DenseMatrix symmetric = 0.5 * (reduced + reduced.transpose());
    return symmetric_eigenvalues(symmetric)[0];
  }

  bool covers() const {
    return d_.parts[forms_.front().part].entities.size() == d_.mesh.cells.size();
  }
  double value(const Expr& coefficient, const Point& x, int cell) const {
    if (coefficient.is_constant()) return coefficient.value();
    return evaluate(coefficient, [&](Slot s) {
      for (int a = 0; a < 3; ++a)
        if (s == slot::x(a)) return x[a];
      if (s >= slot::first_inside && d_.space.indicators)
        for (int p = 0; p < static_cast<int>(d_.parts.size()); ++p)
          if (s == slot::inside(p))
            return d_.space.indicators->value(p, Group::Kind::cells, cell, cell);
      return std::nan("");
    });
  }

  const Discretisation& d_;
  std::vector<FormTerm> forms_;
  bool hoop_;
  DenseMatrix basis_;
  bool varies_ = false;
  bool isotropic_ = true;                 ///< all forms, as they were written; then
  std::vector<std::array<Expr, 2>> lame_; ///< lambda and mu of each
};

} // namespace

Ellipticity ellipticity(const Problem& problem, const Discretisation& d, int field) {
  Ellipticity out;
  if (d.space.is_product()) return out; // a tensor of one unknown bounds nothing of the product
  const PointwiseTensor tensor(problem, d, field);
  if (tensor.empty()) return out;
  out.origin = tensor.origin();
  out.varies = tensor.varies();
  const int cells = out.varies ? static_cast<int>(d.mesh.cells.size()) : 1;
  bool any = false, bare = false;
  Point without{};
  for (int cell = 0; cell < cells; ++cell) {
    const double here = tensor.least(cell);
    bare = bare || std::isinf(here);
    any = any || !std::isinf(here);
    if (here < out.least) out.least = here, out.at = middle(d.mesh, cell);
    if (std::isinf(here)) without = middle(d.mesh, cell);
  }
  // A tensor that acts in a part of the body only is 0 elsewhere.
  if (any && bare && out.least > 0.0) out.least = 0.0, out.at = without;
  return out;
}

} // namespace hvi::solver
