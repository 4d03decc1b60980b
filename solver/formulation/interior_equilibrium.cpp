// Backward errors of steps on all rows; see interior_equilibrium.hpp. Asked by the row checks.
#include "solver/formulation/interior_equilibrium.hpp"

#include "solver/discrete/certificate.hpp"
#include "solver/linear/instruction_set.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

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

double InteriorEquilibrium::error(const Question& step, double enough) const {
  const SparseMatrix& t = interior_.t;
  const Eigen::Index n = interior_.layout.n_unknowns;
  Vector state, f, gap(n), scale(n);
  force_of_modes(interior_, step.load, f);
  expand(interior_, step.known + step.change, state);
  gap_and_scale(t, state, f, gap, scale);
  const double of_sum = equilibrium_error(t, state, gap, scale, {force_, {}}, step.xi);
  if (of_sum <= enough) return of_sum;
  Vector change_gap(n), change_scale(n);
  expand(interior_, step.known, state);
  gap_and_scale(t, state, f, gap, scale);
  expand(interior_, step.change, state);
  f.setZero();
  gap_and_scale(t, state, f, change_gap, change_scale);
  gap += change_gap;
  scale += change_scale;
  return equilibrium_error(t, state, gap, scale, {force_, {}}, step.xi);
}

std::vector<double> InteriorEquilibrium::errors(std::span<const Question> steps, double enough,
                                                std::span<KnownField> more) const {
  std::vector<Vector> sums;
  sums.reserve(steps.size());
  std::vector<const Vector*> states;
  for (const auto& step : steps) {
    sums.push_back(step.known + step.change);
    states.push_back(&sums.back());
  }
  for (const auto& field : more) states.push_back(&field.y);
  DenseMatrix x;
  expand(interior_, states, x);
  for (std::size_t k = 0; k < more.size(); ++k)
    take_row(interior_, x, static_cast<int>(steps.size() + k), more[k].unknowns);
  const auto& unknown = interior_.factor->order().unknown;
  std::vector<int> place(unknown.size());
  for (std::size_t i = 0; i < unknown.size(); ++i) place[unknown[i]] = static_cast<int>(i);
  DenseMatrix load =
      DenseMatrix::Zero(x.rows(), static_cast<Eigen::Index>(interior_.forces.size()));
  DenseMatrix reaction = DenseMatrix::Zero(x.rows(), interior_.n_contact());
  for (std::size_t r = 0; r < steps.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    load.row(row) = steps[r].load.tail(load.cols()).transpose();
    for (int c = 0; c < interior_.n_contact(); ++c)
      for (SparseMatrix::InnerIterator it(force_, interior_.contact[c]); it; ++it)
        reaction(row, c) += it.value() * steps[r].xi[it.col()];
  }
  std::vector<double> out(static_cast<std::size_t>(x.rows()), 0.0);
  const ManyStates all{interior_.t,      x.data(), load.data(),       reaction.data(),
                       interior_.forces, place,    interior_.position};
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
    if (!(out[r] <= enough)) out[r] = error(steps[r], enough);
  return out;
}

} // namespace hvi::solver
