// The body that follows from its contact unknowns; see interior.hpp. Used by the formulation on
// contact unknowns, for the fields of a report among others.
#include "solver/formulation/interior.hpp"

#include <numeric>
#include <utility>

namespace hvi::solver {

Interior::Interior(SparseMatrix& of_all, SharedFactor its_factor, StateLayout its_layout,
                   std::vector<int> its_contact)
    : layout(std::move(its_layout)), contact(std::move(its_contact)),
      position(layout.n_unknowns, -1), factor(std::move(its_factor)) {
  t.swap(of_all);
  for (int c = 0; c < n_contact(); ++c) position[contact[c]] = c;
}

Vector add_mode(Interior& interior, const Vector& f) {
  Vector y, r;
  forward(*interior.factor, f, y, r);
  return add_mode(interior, f, y.head(interior.n_interior()), r);
}

Vector add_mode(Interior& interior, const Vector& f, Vector y, const Vector& r) {
  interior.forces.push_back(f);
  interior.kept.push_back(std::move(y));
  Vector out = Vector::Zero(interior.size());
  out.head(interior.n_contact()) = r;
  out[interior.size() - 1] = 1.0;
  return out;
}

Vector add_state(Interior& interior, const Vector& u) {
  Vector c(interior.n_contact());
  for (int i = 0; i < interior.n_contact(); ++i) c[i] = u[interior.contact[i]];
  if (u.isZero(0.0)) return Vector::Zero(interior.size());
  add_mode(interior, interior.t * u);
  Vector out = Vector::Zero(interior.size());
  out.head(interior.n_contact()) = c;
  out[interior.size() - 1] = 1.0;
  return out;
}

SparseMatrix condensed_matrix(const Interior& interior) {
  const DenseMatrix& s = interior.factor->schur();
  const int nc = interior.n_contact(), size = interior.size();
  SparseMatrix out(size, size);
  out.resizeNonZeros(static_cast<Eigen::Index>(nc) * nc + size - nc);
  int* column = out.innerIndexPtr();
  double* value = out.valuePtr();
  for (int i = 0; i < nc; ++i) {
    out.outerIndexPtr()[i] = i * nc;
    std::iota(column, column + nc, 0);
    column += nc;
    for (int j = 0; j < nc; ++j) *value++ = s(j, i); // symmetric
  }
  for (int i = nc; i <= size; ++i) out.outerIndexPtr()[i] = nc * nc + i - nc;
  for (int i = nc; i < size; ++i) *column++ = i, *value++ = 1.0;
  return out;
}

void expand(const Interior& interior, const Vector& y, Vector& x) {
  Vector kept = Vector::Zero(interior.layout.n_unknowns);
  for (std::size_t k = 0; k < interior.kept.size(); ++k)
    if (const double phi = y[interior.n_contact() + static_cast<int>(k)]; phi != 0.0)
      kept.head(interior.n_interior()) += phi * interior.kept[k];
  back(*interior.factor, y.head(interior.n_contact()), kept, x);
}

void expand(const Interior& interior, std::span<const Vector* const> y, DenseMatrix& x) {
  const auto count = static_cast<int>(y.size());
  x.resize(RightHandSides::stride_of(count), interior.layout.n_unknowns);
  auto inside = x.leftCols(interior.n_interior());
  if (interior.kept.empty()) inside.setZero();
  Vector phi = Vector::Zero(x.rows());
  for (std::size_t k = 0; k < interior.kept.size(); ++k) {
    for (int r = 0; r < count; ++r) phi[r] = (*y[r])[interior.n_contact() + static_cast<int>(k)];
    if (k == 0)
      inside.noalias() = phi * interior.kept[k].transpose();
    else
      inside.noalias() += phi * interior.kept[k].transpose();
  }
  auto contact = x.rightCols(interior.n_contact());
  for (int r = 0; r < count; ++r) contact.row(r) = y[r]->head(interior.n_contact()).transpose();
  contact.bottomRows(x.rows() - count).setZero();
  interior.factor->back({x, count}, Columns::interior);
}

void take_row(const Interior& interior, const DenseMatrix& x, int row, Vector& unknowns) {
  const std::vector<int>& unknown = interior.factor->order().unknown;
  unknowns.resize(x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    unknowns[unknown[static_cast<std::size_t>(i)]] = x(row, i);
}

void force_of_modes(const Interior& interior, const Vector& y, Vector& f) {
  f.setZero(interior.layout.n_unknowns);
  for (std::size_t k = 0; k < interior.forces.size(); ++k)
    if (const double g = y[interior.n_contact() + static_cast<int>(k)]; g != 0.0)
      f += g * interior.forces[k];
}

bool respond(const Interior& interior, std::span<const Vector> forces, StepMatrix& matrix,
             double gamma, const InequalityState& at, std::vector<Vector>& x,
             std::vector<Vector>& xi) {
  DenseMatrix y;
  std::vector<Vector> r, c;
  forward(*interior.factor, forces, y, r);
  if (!matrix.laws()->respond(at, r, c, xi)) return false;
  for (auto& of_force : c) of_force *= gamma; // the factor's matrix times gamma is the step's
  back(*interior.factor, c, y, x);
  for (auto& of_force : x) of_force /= gamma;
  return true;
}

} // namespace hvi::solver
