// See several.hpp.
#include "solver/linear/petsc/several.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hvi::petsc_module {
namespace {

/// A residual of an unknown whose energy is less than this part of the largest one counts as that:
/// forces of the others have to be solved for there first.
constexpr double least_part = 1e-4;

} // namespace

/// One of them.
struct SeveralCycles::Unknown {
  std::vector<int> rows;     ///< of the whole, of the first process
  std::vector<int> position; ///< of each row of the whole, of the first process; -1: another's
  std::vector<int> mine;     ///< this process's rows, by their places among its rows of the whole
  std::vector<char> solved;  ///< is each of `mine` solved for?
  Rows k, h;                 ///< this process's rows; whole, of the first process
  std::optional<WholeMatrix> whole_k;
  FewRows h_rows;
  /// Of this process's rows: the sizes of the diagonals of S_b, and of that and H.
  std::vector<double> diagonal, stiffness;
  std::unique_ptr<Distribution> distribution;
  Owned<Mat> matrix;
  Owned<Vec> r, z;
  std::unique_ptr<Cycle> cycle;

  /// `is_solved`: of each of this process's rows of the whole.
  void find(const UnknownRows& all, int own, const std::vector<int>& is_solved) {
    position.assign(all.turn_of_whole.size(), -1);
    for (std::size_t row = 0; row < all.turn_of_whole.size(); ++row)
      if (all.turn_of_whole[row] == own) {
        position[row] = static_cast<int>(rows.size());
        rows.push_back(static_cast<int>(row));
      }
    for (std::size_t row = 0; row < all.turn.size(); ++row)
      if (all.turn[row] == own) {
        mine.push_back(static_cast<int>(row));
        solved.push_back(static_cast<char>(is_solved[row]));
      }
  }

  void distribute(const Distribution& whole, int components) {
    std::vector<int> counts(static_cast<std::size_t>(processes()), 0);
    for (const int row : rows) ++counts[whole.process_of(row)];
    distribution = std::make_unique<Distribution>(whole.comm(), counts, components);
  }

  Rows block_of(const Rows& a) const {
    Rows out;
    for (const int row : rows) {
      for (int e = a.start[row]; e < a.start[row + 1]; ++e)
        if (const int column = position[a.column[e]]; column >= 0) {
          out.column.push_back(column);
          out.value.push_back(a.value[e]);
        }
      out.start.push_back(static_cast<int>(out.column.size()));
    }
    return out;
  }

  double typical(const std::vector<double>& of_whole) const {
    double sums[2] = {};
    for (std::size_t p = 0; p < mine.size(); ++p)
      if (solved[p] != 0) sums[0] += std::abs(of_whole[mine[p]]), ++sums[1];
    distribution->add_up(sums, 2);
    return sums[0] > 0.0 ? sums[0] / sums[1] : 1.0;
  }

  /// This process's rows of it, with this diagonal of the whole in place of its own. Rows that are
  /// not solved for have a typical one.
  Rows block_of(const Distribution& whole, Mat a, const std::vector<double>& of_whole) const {
    const double otherwise = typical(of_whole);
    std::vector<double> own_position(of_whole.size(), -1.0);
    for (std::size_t p = 0; p < mine.size(); ++p)
      own_position[mine[p]] = distribution->first_row() + static_cast<int>(p);
    NumbersOfColumns position_of(whole, a);
    position_of.set(own_position);
    Rows out;
    for (std::size_t p = 0; p < mine.size(); ++p) {
      const int at = mine[p], row = whole.first_row() + at;
      const RowOf entries(a, row);
      const auto put = [&](double column, double value) {
        out.column.push_back(static_cast<int>(column));
        out.value.push_back(value);
      };
      const double own = solved[p] != 0 && of_whole[at] != 0.0 ? of_whole[at] : otherwise;
      bool to_come = true;
      for (int e = 0; e < entries.size(); ++e) {
        const int j = entries.column(e);
        if (to_come && j >= row) put(own_position[at], own), to_come = false;
        if (const double column = position_of[j]; column >= 0.0 && j != row)
          put(column, entries.value(e));
      }
      if (to_come) put(own_position[at], own);
      out.start.push_back(static_cast<int>(out.column.size()));
    }
    return out;
  }

  std::vector<double> diagonal_of_laws() const {
    std::vector<double> out(static_cast<std::size_t>(h.size()), 0.0);
    for (int i = 0; i < h.size(); ++i) out[i] = std::abs(entry(h.view(), i, i));
    return distribution->deal(std::move(out), 1);
  }

  void set_laws(const Rows& whole) {
    h = block_of(whole);
    h_rows.set(*distribution, r.get(), h.view());
    const std::vector<double> more = diagonal_of_laws();
    for (std::size_t i = 0; i < more.size(); ++i) stiffness[i] = diagonal[i] + more[i];
  }

  /// Of a vector of the whole: the norm of its rows, each by what a motion of it costs.
  double squares(const double* whole) const {
    double out = 0.0;
    for (std::size_t i = 0; i < mine.size(); ++i)
      out += whole[mine[i]] * whole[mine[i]] / stiffness[i];
    return out;
  }

  void set_matrix(const Distribution& all, Mat whole, const std::vector<double>& of_whole) {
    Rows now = block_of(all, whole, of_whole);
    diagonal.clear();
    for (int i = 0; i < now.size(); ++i)
      diagonal.push_back(std::abs(entry(now.view(), i, distribution->first_row() + i)));
    stiffness = diagonal;
    if (!matrix) {
      k = std::move(now);
      distribution->make(k.view(), matrix);
      know_whole();
      check(MatCreateVecs(matrix.get(), r.put(), z.put()));
      return;
    }
    if (distribution->alone()) std::copy(now.value.begin(), now.value.end(), k.value.begin());
    distribution->refresh(distribution->alone() ? k.view() : now.view(), matrix.get());
    whole_k->changed();
    cycle->matrix_changed();
  }

  /// PETSc has copied the rows where there are several processes.
  void know_whole() {
    if (distribution->alone()) {
      whole_k.emplace(k.view());
      return;
    }
    k = {};
    whole_k.emplace(
        distribution->is_first() ? distribution->all_rows() : 0,
        [this](const std::vector<int>& named) { return distribution->fetch(named, matrix.get()); });
  }

  /// Its rows of the motions that move it.
  void make_cycle(const std::vector<double>& motions, int n_motions, int rows_of_whole) {
    std::vector<double> own;
    int count = 0;
    for (int m = 0; m < n_motions; ++m) {
      const double* whole = motions.data() + static_cast<std::ptrdiff_t>(m) * rows_of_whole;
      double square = 0.0;
      for (const int row : mine) square += whole[row] * whole[row];
      if (distribution->sum(square) == 0.0) continue;
      for (const int row : mine) own.push_back(whole[row]);
      ++count;
    }
    cycle = std::make_unique<Cycle>(*distribution, *whole_k, matrix.get(), own, count);
  }

  PetscErrorCode take(Vec whole) const {
    const double* from = nullptr;
    double* to = nullptr;
    PetscCall(VecGetArrayRead(whole, &from));
    PetscCall(VecGetArrayWrite(r.get(), &to));
    for (std::size_t i = 0; i < mine.size(); ++i) to[i] = from[mine[i]];
    PetscCall(VecRestoreArrayWrite(r.get(), &to));
    return VecRestoreArrayRead(whole, &from);
  }

  PetscErrorCode give(Vec whole) const {
    const double* from = nullptr;
    double* to = nullptr;
    PetscCall(VecGetArrayRead(z.get(), &from));
    PetscCall(VecGetArray(whole, &to));
    for (std::size_t i = 0; i < mine.size(); ++i) to[mine[i]] = from[i];
    PetscCall(VecRestoreArray(whole, &to));
    return VecRestoreArrayRead(z.get(), &from);
  }
};

SeveralCycles::SeveralCycles(const Distribution& distribution, const Numbering& numbering,
                             const std::vector<int>& first_component, Mat k, Mat product,
                             const std::vector<double>& motions, int n_motions)
    : distribution_(distribution), k_(k), product_(product),
      rows_(order_of_unknowns(distribution, k, numbering, first_component)) {
  check(MatCreateVecs(product, moved_.put(), rest_.put()));
  std::vector<int> solved; // of the whole, of the first process
  for (int row = 0; distribution.is_first() && row < numbering.size(); ++row)
    solved.push_back(numbering.is_unknown(row) ? 1 : 0);
  const std::vector<int> mine = distribution.deal(solved);
  const std::vector<double> diagonal = eliminate(distribution, k, rows_);
  for (int u = 0; u < rows_.count; ++u) {
    Unknown& one = *unknowns_.emplace_back(std::make_unique<Unknown>());
    one.find(rows_, u, mine);
    one.distribute(distribution, distribution.is_first() ? rows_.components[u] : 0);
    one.set_matrix(distribution, k, diagonal);
    one.make_cycle(motions, n_motions, distribution.rows());
  }
}

SeveralCycles::~SeveralCycles() = default;

void SeveralCycles::matrix_changed() {
  const std::vector<double> diagonal = eliminate(distribution_, k_, rows_);
  for (const auto& one : unknowns_) one->set_matrix(distribution_, k_, diagonal);
}

bool SeveralCycles::set_laws(const Rows& h, const FewRows&, bool symmetric, double shift) {
  bool out = true;
  for (const auto& one : unknowns_) {
    one->set_laws(h);
    out = one->cycle->set_laws(one->h, one->h_rows, symmetric, shift) && out;
  }
  return out;
}

/// Iterations on several unknowns do not ask for a preconditioner that is positive definite.
bool SeveralCycles::leave_laws() { return false; }

void SeveralCycles::set_up() {
  for (const auto& one : unknowns_) one->cycle->set_up();
}

PetscErrorCode SeveralCycles::apply(Vec r, Vec z) {
  PetscCall(VecSet(z, 0.0));
  PetscCall(VecCopy(r, rest_.get()));
  for (std::size_t u = 0; u < unknowns_.size(); ++u) {
    const Unknown& one = *unknowns_[u];
    if (u > 0) {
      PetscCall(MatMult(product_, z, moved_.get()));
      PetscCall(VecWAXPY(rest_.get(), -1.0, moved_.get(), r));
    }
    PetscCall(one.take(rest_.get()));
    PetscCall(one.cycle->apply(one.r.get(), one.z.get()));
    PetscCall(one.give(z));
  }
  return 0;
}

Effort SeveralCycles::effort() const {
  Effort out;
  for (const auto& one : unknowns_) {
    const Effort of = one->cycle->effort();
    out.bytes += of.bytes + one->distribution->copied_bytes(one->matrix.get()) +
                 12.0 * static_cast<double>(one->k.column.size() + one->h.column.size()) +
                 one->h_rows.bytes();
    out.seconds_setup += of.seconds_setup;
    out.local_factors += of.local_factors;
    out.levels.resize(std::max(out.levels.size(), of.levels.size()));
    for (std::size_t l = 0; l < of.levels.size(); ++l) {
      out.levels[l].rows += of.levels[l].rows;
      out.levels[l].entries += of.levels[l].entries;
    }
  }
  return out;
}

void SeveralCycles::weigh(Vec b, Vec weights) const {
  std::vector<double> size;
  const double* values = nullptr;
  check(VecGetArrayRead(b, &values));
  for (const auto& one : unknowns_) size.push_back(one->squares(values));
  check(VecRestoreArrayRead(b, &values));
  distribution_.add_up(size.data(), static_cast<int>(size.size()));
  const double most = *std::max_element(size.begin(), size.end());
  double* to = nullptr;
  check(VecSet(weights, 0.0));
  check(VecGetArray(weights, &to));
  for (std::size_t u = 0; u < size.size(); ++u) {
    const double part = std::max(size[u] / most, least_part);
    const Unknown& one = *unknowns_[u];
    for (std::size_t i = 0; i < one.mine.size(); ++i)
      to[one.mine[i]] = most > 0.0 ? 1.0 / std::sqrt(most * part * one.stiffness[i]) : 1.0;
  }
  check(VecRestoreArray(weights, &to));
}

} // namespace hvi::petsc_module
