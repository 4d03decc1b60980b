// Recovery of the interior from the contact unknowns; see interior.hpp. Used by the formulation on
// contact unknowns, for the fields of a report among others.
#include "solver/time/interior.hpp"

#include "solver/linear/instruction_set.hpp"
#include "solver/time/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>

namespace hvi::solver {

namespace {

/// T with many states: a column of x, of the loads' forces f and of the reactions for each unknown.
struct ManyStates {
  const SparseMatrix& t;
  const double *x, *load, *reaction; ///< rows of `row` numbers; no load: as many modes as there are
  const std::vector<Vector>& forces;
  const std::vector<int>& place;    ///< of an unknown's column in x
  const std::vector<int>& position; ///< of an unknown among the contact unknowns, or -1
};

/// v = |v|, by the sign bit.
template <int Lanes>
HVI_INLINE void drop_signs(Pack<Lanes>& v) {
  typedef std::int64_t Bits __attribute__((vector_size(sizeof(Pack<Lanes>))));
  Bits bits;
  std::memcpy(&bits, &v, sizeof v);
  bits &= std::numeric_limits<std::int64_t>::max();
  std::memcpy(&v, &bits, sizeof v);
}

/// worst[r] = max_i |f - T x - reaction|_i / (|T||x| + |f|)_i of state r; NaN where one is. So many
/// packs of so many states at once.
template <int Packs, int Lanes>
HVI_INLINE void worst_of_row(const ManyStates& s, int row, int i, int first, double* worst) {
  Pack<Lanes> sum[Packs] = {}, size[Packs] = {}, other;
  for (int e = s.t.outerIndexPtr()[i]; e < s.t.outerIndexPtr()[i + 1]; ++e) {
    const double value = s.t.valuePtr()[e];
    const double* x =
        s.x + static_cast<std::ptrdiff_t>(s.place[s.t.innerIndexPtr()[e]]) * row + first;
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g) {
      load<Lanes>(x + g * Lanes, other);
      other *= value;
      sum[g] -= other;
      drop_signs<Lanes>(other);
      size[g] += other;
    }
  }
  const int contact = s.position[i];
#pragma GCC unroll 2
  for (int g = 0; g < Packs; ++g) {
    const int at = first + g * Lanes;
    Pack<Lanes> f = {};
    for (std::size_t k = 0; k < s.forces.size(); ++k) {
      load<Lanes>(s.load + static_cast<std::ptrdiff_t>(k) * row + at, other);
      f += s.forces[k][i] * other;
    }
    sum[g] += f;
    drop_signs<Lanes>(f);
    size[g] += f;
    if (contact >= 0) {
      load<Lanes>(s.reaction + static_cast<std::ptrdiff_t>(contact) * row + at, other);
      sum[g] -= other;
    }
    drop_signs<Lanes>(sum[g]);
    // A row of zeros has no error; one of zeros with a residual has a practically infinite one.
    const Pack<Lanes> error = sum[g] / (size[g] + std::numeric_limits<double>::min());
    Pack<Lanes> most;
    load<Lanes>(worst + at, most);
    const Pack<Lanes> larger = error <= most ? most : error;
    most = most == most ? larger : most; // a NaN stays
    std::memcpy(worst + at, &most, sizeof most);
  }
}

template <int Packs, int Lanes>
HVI_INLINE void worst_errors(const ManyStates& s, int row, double* worst) {
  for (int i = 0; i < s.t.rows(); ++i) {
    int first = 0;
    for (; first + Packs * Lanes <= row; first += Packs * Lanes)
      worst_of_row<Packs, Lanes>(s, row, i, first, worst);
    for (; first < row; first += Lanes) worst_of_row<1, Lanes>(s, row, i, first, worst);
  }
}

HVI_AVX2 void worst_avx2(const ManyStates& s, int row, double* worst) {
  worst_errors<2, 4>(s, row, worst);
}
HVI_AVX512 void worst_avx512(const ManyStates& s, int row, double* worst) {
  worst_errors<2, 8>(s, row, worst);
}

} // namespace

Interior::Interior(SparseMatrix& t, SharedFactor factor, StateLayout layout,
                   std::vector<int> contact)
    : layout_(std::move(layout)), contact_(std::move(contact)), position_(layout_.n_unknowns, -1),
      factor_(std::move(factor)) {
  t_.swap(t);
  for (int c = 0; c < n_contact(); ++c) position_[contact_[c]] = c;
}

Vector Interior::add_mode(const Vector& f) {
  Vector y, r;
  forward(*factor_, f, y, r);
  forces_.push_back(f);
  kept_.push_back(y.head(n_interior()));
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
  SparseMatrix out(size(), size());
  out.resizeNonZeros(static_cast<Eigen::Index>(nc) * nc + size() - nc);
  int* column = out.innerIndexPtr();
  double* value = out.valuePtr();
  for (int i = 0; i < nc; ++i) {
    out.outerIndexPtr()[i] = i * nc;
    std::iota(column, column + nc, 0);
    column += nc;
    for (int j = 0; j < nc; ++j) *value++ = s(j, i); // symmetric
  }
  for (int i = nc; i <= size(); ++i) out.outerIndexPtr()[i] = nc * nc + i - nc;
  for (int i = nc; i < size(); ++i) *column++ = i, *value++ = 1.0;
  return out;
}

/// x = E c + sum_k phi_k p_k
void Interior::expand(const Vector& y, Vector& x) {
  Vector kept = Vector::Zero(layout_.n_unknowns);
  for (std::size_t k = 0; k < kept_.size(); ++k)
    if (const double phi = y[n_contact() + static_cast<int>(k)]; phi != 0.0)
      kept.head(n_interior()) += phi * kept_[k];
  back(*factor_, y.head(n_contact()), kept, x);
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
    Observed out{dof, unknown, {}, {}};
    if (position_[unknown] < 0) {
      // (E^T e_i)_c = -T_cI T_II^-1 e_i: what the forward solve makes of e_i.
      Vector e = Vector::Zero(layout_.n_unknowns);
      e[unknown] = 1.0;
      Vector y;
      forward(*factor_, e, y, out.row);
      for (const Vector& of_mode : kept_) out.modes.push_back(y.head(n_interior()).dot(of_mode));
    }
    observed_.push_back(std::move(out));
  }
}

void Interior::scatter_observed(const Vector& y, Vector& full) const {
  for (int c = 0; c < n_contact(); ++c) full[layout_.dof_of[contact_[c]]] = y[c];
  for (const auto& o : observed_) {
    if (o.row.size() == 0) continue;
    double value = o.row.dot(y.head(n_contact()));
    for (std::size_t k = 0; k < o.modes.size(); ++k)
      value += y[n_contact() + static_cast<int>(k)] * o.modes[k];
    full[o.dof] = value;
  }
}

bool Interior::respond(std::span<const Vector> forces, StepMatrix& matrix, double gamma,
                       const InequalityState& at, std::vector<Vector>& x, std::vector<Vector>& xi) {
  DenseMatrix y;
  std::vector<Vector> r, c;
  forward(*factor_, forces, y, r);
  if (!matrix.laws()->respond(at, r, c, xi)) return false;
  for (auto& of_force : c) of_force *= gamma; // the factor's matrix times gamma is the step's
  back(*factor_, c, y, x);
  for (auto& of_force : x) of_force /= gamma;
  return true;
}

double Interior::equilibrium(const Vector& known, const Vector& change, const Vector& load,
                             const Vector& xi, double enough) {
  for (Vector* v : {&gap_, &scale_, &change_gap_, &work_}) v->resize(layout_.n_unknowns);
  force_of_modes(load, f_);
  expand(known + change, state_);
  gap_and_scale(t_, state_, f_, gap_, scale_);
  const double of_sum = equilibrium_error(t_, state_, gap_, scale_, {force, {}}, xi);
  if (of_sum <= enough) return of_sum;
  expand(known, state_);
  gap_and_scale(t_, state_, f_, gap_, scale_);
  expand(change, state_);
  f_.setZero();
  gap_and_scale(t_, state_, f_, change_gap_, work_);
  gap_ += change_gap_;
  scale_ += work_;
  return equilibrium_error(t_, state_, gap_, scale_, {force, {}}, xi);
}

/// expand() of several in one backward solve, a row of x each, in the order of elimination.
void Interior::expand_all(std::span<const Vector* const> y, DenseMatrix& x) {
  const auto count = static_cast<int>(y.size());
  x.resize(RightHandSides::stride_of(count), layout_.n_unknowns);
  auto inside = x.leftCols(n_interior());
  if (kept_.empty()) inside.setZero();
  Vector phi = Vector::Zero(x.rows());
  for (std::size_t k = 0; k < kept_.size(); ++k) {
    for (int r = 0; r < count; ++r) phi[r] = (*y[r])[n_contact() + static_cast<int>(k)];
    if (k == 0)
      inside.noalias() = phi * kept_[k].transpose();
    else
      inside.noalias() += phi * kept_[k].transpose();
  }
  auto contact = x.rightCols(n_contact());
  for (int r = 0; r < count; ++r) contact.row(r) = y[r]->head(n_contact()).transpose();
  contact.bottomRows(x.rows() - count).setZero();
  factor_->back({x, count}, Columns::interior);
}

std::vector<double> Interior::equilibria(std::span<const Question> steps, double enough) {
  std::vector<Vector> sums;
  sums.reserve(steps.size());
  std::vector<const Vector*> states;
  for (const auto& step : steps) {
    sums.push_back(step.known + step.change);
    states.push_back(&sums.back());
  }
  DenseMatrix x;
  expand_all(states, x);
  const auto& unknown = factor_->order().unknown;
  std::vector<int> place(unknown.size());
  for (std::size_t i = 0; i < unknown.size(); ++i) place[unknown[i]] = static_cast<int>(i);
  DenseMatrix load = DenseMatrix::Zero(x.rows(), static_cast<Eigen::Index>(forces_.size()));
  DenseMatrix reaction = DenseMatrix::Zero(x.rows(), n_contact());
  for (std::size_t r = 0; r < steps.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    load.row(row) = steps[r].load.tail(load.cols()).transpose();
    for (int c = 0; c < n_contact(); ++c)
      for (SparseMatrix::InnerIterator it(force, contact_[c]); it; ++it)
        reaction(row, c) += it.value() * steps[r].xi[it.col()];
  }
  std::vector<double> out(static_cast<std::size_t>(x.rows()), 0.0);
  const ManyStates all{t_, x.data(), load.data(), reaction.data(), forces_, place, position_};
  const auto row = static_cast<int>(x.rows());
  switch (instruction_set()) {
  case InstructionSet::avx512:
    worst_avx512(all, row, out.data());
    break;
  case InstructionSet::avx2:
    worst_avx2(all, row, out.data());
    break;
  case InstructionSet::baseline:
    worst_errors<2, 4>(all, row, out.data());
  }
  out.resize(steps.size()); // lanes without a question
  for (double& error : out)
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < steps.size(); ++r)
    if (const auto& s = steps[r]; !(out[r] <= enough))
      out[r] = equilibrium(s.known, s.change, s.load, s.xi, enough);
  return out;
}

} // namespace hvi::solver
