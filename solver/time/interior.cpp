// Recovery of the interior from the contact unknowns; see interior.hpp. Used by reduce.cpp, and by
// StateLayout::scatter when a report asks for a field.
#include "solver/time/interior.hpp"

#include "solver/time/certificate.hpp"

#include <algorithm>

namespace hvi::solver {

Interior::Interior(SparseMatrix t, StateLayout layout, std::vector<int> contact, SharedWork* shared)
    : t_(std::move(t)), layout_(std::move(layout)), contact_(std::move(contact)),
      position_(layout_.n_unknowns, -1), factor_(lend_factor(shared, t_, contact_, true)) {
  for (int c = 0; c < n_contact(); ++c) position_[contact_[c]] = c;
}

Vector Interior::add_mode(const Vector& f) {
  Vector r, p;
  factor_->reduce(f, r);
  factor_->back(Vector::Zero(n_contact()), p);
  forces_.push_back(f);
  modes_.push_back(std::move(p));
  Vector out = Vector::Zero(size());
  out.head(n_contact()) = r;
  out[size() - 1] = 1.0;
  return out;
}

Vector Interior::add_state(const Vector& u) {
  Vector c(n_contact());
  for (int i = 0; i < n_contact(); ++i) c[i] = u[contact_[i]];
  if (u.isZero(0.0)) return Vector::Zero(size());
  add_mode(t_ * u);
  Vector out = Vector::Zero(size());
  out.head(n_contact()) = c;
  out[size() - 1] = 1.0;
  return out;
}

SparseMatrix Interior::matrix() const {
  const DenseMatrix& s = factor_->schur();
  const int nc = n_contact();
  std::vector<int> starts{0}, columns;
  std::vector<double> values;
  for (int i = 0; i < size(); ++i) {
    for (int j = 0; i < nc && j < nc; ++j) columns.push_back(j), values.push_back(s(i, j));
    if (i >= nc) columns.push_back(i), values.push_back(1.0);
    starts.push_back(static_cast<int>(columns.size()));
  }
  return Eigen::Map<const SparseMatrix>(size(), size(), static_cast<int>(values.size()),
                                        starts.data(), columns.data(), values.data());
}

/// x = E c + sum_k phi_k p_k
void Interior::expand(const Vector& y, Vector& x) {
  factor_->extend(y.head(n_contact()), x);
  for (std::size_t k = 0; k < modes_.size(); ++k)
    if (const double phi = y[n_contact() + static_cast<int>(k)]; phi != 0.0) x += phi * modes_[k];
}

/// f = sum_k y_k F_k
void Interior::force_of_modes(const Vector& y, Vector& f) const {
  f.setZero(layout_.n_unknowns);
  for (std::size_t k = 0; k < forces_.size(); ++k)
    if (const double g = y[n_contact() + static_cast<int>(k)]; g != 0.0) f += g * forces_[k];
}

void Interior::scatter(const Vector& y, Vector& full) {
  if (scattered_.size() != y.size() || scattered_ != y) expand(y, x_);
  scattered_ = y;
  layout_.scatter(x_, full);
}

void Interior::observe(std::span<const int> dofs) {
  for (const int dof : dofs) {
    const int unknown = layout_.entry_of[dof];
    const auto same = [&](const Observed& o) { return o.dof == dof; };
    if (unknown < 0 || std::any_of(observed_.begin(), observed_.end(), same)) continue;
    Observed out{dof, unknown, {}};
    if (position_[unknown] < 0) {
      // (E^T e_i)_c = -T_cI T_II^-1 e_i: what the forward sweep leaves of e_i.
      Vector e = Vector::Zero(layout_.n_unknowns);
      e[unknown] = 1.0;
      factor_->reduce(e, out.row);
    }
    observed_.push_back(std::move(out));
  }
}

void Interior::scatter_observed(const Vector& y, Vector& full) const {
  for (int c = 0; c < n_contact(); ++c) full[layout_.dof_of[contact_[c]]] = y[c];
  for (const auto& o : observed_) {
    if (o.row.size() == 0) continue;
    double value = o.row.dot(y.head(n_contact()));
    for (std::size_t k = 0; k < modes_.size(); ++k)
      value += y[n_contact() + static_cast<int>(k)] * modes_[k][o.unknown];
    full[o.dof] = value;
  }
}

double Interior::equilibrium(const Vector& known, const Vector& change, const Vector& load,
                             const Vector& xi, double enough) {
  for (Vector* v : {&gap_, &scale_, &change_gap_, &work_}) v->resize(layout_.n_unknowns);
  force_of_modes(load, f_);
  expand(known + change, state_);
  gap_and_scale(t_, state_, f_, gap_, scale_);
  const double of_sum = equilibrium_error(gap_, scale_, force, xi, work_);
  if (of_sum <= enough) return of_sum;
  expand(known, state_);
  gap_and_scale(t_, state_, f_, gap_, scale_);
  expand(change, state_);
  f_.setZero();
  gap_and_scale(t_, state_, f_, change_gap_, work_);
  gap_ += change_gap_;
  scale_ += work_;
  return equilibrium_error(gap_, scale_, force, xi, work_);
}

} // namespace hvi::solver
