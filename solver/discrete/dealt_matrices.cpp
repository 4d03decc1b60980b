// See dealt_matrices.hpp.
#include "solver/discrete/dealt_matrices.hpp"

#include "solver/discrete/operators.hpp"
#include "solver/linear/processes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>
#include <utility>

namespace hvi::solver {

DealtMatrices::DealtMatrices(const Discretisation& discretisation, const StateLayout& layout,
                             const DealtForms& forms, int processes, UnknownsOfNodes& unknowns)
    : d_(discretisation), processes_(processes), n_unknowns_(layout.n_unknowns) {
  const auto part_of_node = parts_of_nodes(d_.space, layout, processes_);
  deal_out_nodes(layout, part_of_node, unknowns);
  std::vector<std::string> messages;
  for (int p = 0; p < processes_; ++p) {
    std::ostringstream out;
    StateWriter w(out);
    of_.push_back(put_assembly(w, d_, layout, part_of_node, p, place_, first_row_, forms));
    messages.push_back(message_of({set(), MatrixErrand::assemble}, std::move(out).str()));
  }
  try {
    for (const std::string& answer : ask(messages)) weights_ = assembled(answer);
  } catch (const Failure&) { // of one process; the others have their rows
    end();
    throw;
  }
  next_ = static_cast<int>(weights_.size());
}

DealtMatrices::~DealtMatrices() { end(); }

void DealtMatrices::end() const noexcept {
  try {
    ask({set(), MatrixErrand::end});
  } catch (const std::exception&) { // the others are at their end
  }
}

/// All components of each node have a row of PETSc's, nodes follow each other in their order, those
/// of the first process first.
void DealtMatrices::deal_out_nodes(const StateLayout& layout,
                                   const std::vector<std::int32_t>& part_of_node,
                                   UnknownsOfNodes& unknowns) {
  const int components = d_.space.components;
  std::vector<std::int32_t> part(static_cast<std::size_t>(unknowns.nodes));
  for (int i = 0; i < n_unknowns_; ++i)
    part[unknowns.node[i]] = part_of_node[layout.dof_of[i] / components];
  unknowns.counts.assign(static_cast<std::size_t>(processes_), 0);
  for (const auto p : part) ++unknowns.counts[p];
  first_row_.assign(1, 0);
  for (const int count : unknowns.counts)
    first_row_.push_back(first_row_.back() + count * components);
  std::vector<int> next(unknowns.counts.size(), 0);
  std::partial_sum(unknowns.counts.begin(), unknowns.counts.end() - 1, next.begin() + 1);
  unknowns.place.clear();
  for (const auto p : part) unknowns.place.push_back(next[p]++);
  place_.assign(static_cast<std::size_t>(layout.n_state), -1);
  for (int i = 0; i < n_unknowns_; ++i)
    place_[i] = unknowns.place[unknowns.node[i]] * components + unknowns.component[i];
}

std::vector<std::string> DealtMatrices::ask(std::span<const std::string> messages) const {
  return deal_out(Errand::matrices, messages,
                  [this](std::string_view message) { return mine_.answer(message); });
}

std::vector<std::string>
DealtMatrices::ask(const MatrixErrand& errand,
                   const std::function<std::vector<double>(int)>& numbers) const {
  std::vector<std::string> messages;
  for (int p = 0; p < processes_; ++p) messages.push_back(message_of(errand, numbers(p)));
  return ask(messages);
}

std::vector<std::string> DealtMatrices::ask(const MatrixErrand& errand) const {
  return ask(errand, [](int) { return std::vector<double>(); });
}

std::vector<double> DealtMatrices::columns_of(int p, const Vector& x) const {
  const auto& state = of_[static_cast<std::size_t>(p)].state;
  std::vector<double> out(state.size(), 0.0);
  for (std::size_t j = 0; j < out.size(); ++j)
    if (state[j] < x.size()) out[j] = x[state[j]];
  return out;
}

std::vector<double> DealtMatrices::rows_of(int p, const Vector& x) const {
  const auto& own = of_[static_cast<std::size_t>(p)];
  std::vector<double> out(static_cast<std::size_t>(own.unknowns));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = x[own.state[i]];
  return out;
}

void DealtMatrices::collect(const std::vector<std::string>& answers, std::size_t part,
                            Vector& out) const {
  out.resize(n_unknowns_);
  for (std::size_t p = 0; p < answers.size(); ++p) {
    const auto& own = of_[p];
    const auto n = static_cast<std::size_t>(own.unknowns);
    const auto numbers = numbers_in(answers[p]).subspan(part * n, n);
    for (std::size_t i = 0; i < n; ++i) out[own.state[i]] = numbers[i];
  }
}

void DealtMatrices::product(int matrix, const Vector& x, Vector& product, Vector& whole) const {
  const auto answers =
      ask({set(), MatrixErrand::products, matrix}, [&](int p) { return columns_of(p, x); });
  collect(answers, 0, product);
  collect(answers, 1, whole);
}

void DealtMatrices::subtract_product(int matrix, const Vector& x, std::vector<DoubleDouble>& y,
                                     Vector& size) const {
  const auto answers =
      ask({set(), MatrixErrand::precisely, matrix}, [&](int p) { return columns_of(p, x); });
  Vector high, low, sizes;
  collect(answers, 0, high);
  collect(answers, 1, low);
  collect(answers, 2, sizes);
  for (int i = 0; i < n_unknowns_; ++i) {
    y[static_cast<std::size_t>(i)].add(-high[i]);
    y[static_cast<std::size_t>(i)].add(-low[i]);
  }
  size += sizes;
}

void DealtMatrices::magnitude(int matrix, const Vector& x, Vector& out) const {
  collect(ask({set(), MatrixErrand::magnitudes, matrix}, [&](int p) { return columns_of(p, x); }),
          0, out);
}

Vector DealtMatrices::diagonal(int matrix) const {
  Vector out;
  collect(ask({set(), MatrixErrand::diagonal, matrix}), 0, out);
  return out;
}

void DealtMatrices::transposed(int matrix, const Vector& x, Vector& product, Vector& sizes) const {
  const auto answers =
      ask({set(), MatrixErrand::transposed, matrix}, [&](int p) { return rows_of(p, x); });
  product.setZero(n_unknowns_);
  sizes.setZero(n_unknowns_);
  for (std::size_t p = 0; p < answers.size(); ++p) {
    const auto& state = of_[p].state;
    const auto numbers = numbers_in(answers[p]);
    for (std::size_t j = 0; j < state.size(); ++j) {
      if (state[j] >= n_unknowns_) continue;
      product[state[j]] += numbers[j];
      sizes[state[j]] += numbers[state.size() + j];
    }
  }
}

bool DealtMatrices::is_symmetric(int matrix) const {
  double apart = 0.0, largest = 0.0;
  std::map<std::pair<int, int>, double> alone; // entries whose mirror image did not come yet
  const auto answers = ask({set(), MatrixErrand::asymmetry, matrix});
  for (std::size_t p = 0; p < answers.size(); ++p) {
    const auto numbers = numbers_in(answers[p]);
    const auto& state = of_[p].state;
    apart = std::max(apart, numbers[0]), largest = std::max(largest, numbers[1]);
    for (std::size_t k = 2; k < numbers.size(); k += 3) {
      const int i = state[static_cast<std::size_t>(numbers[k])];
      const int j = state[static_cast<std::size_t>(numbers[k + 1])];
      const auto mirrored = alone.find({j, i});
      if (mirrored == alone.end()) {
        alone[{i, j}] = numbers[k + 2];
        continue;
      }
      apart = std::max(apart, std::abs(numbers[k + 2] - mirrored->second));
      alone.erase(mirrored);
    }
  }
  for (const auto& [place, value] : alone) apart = std::max(apart, std::abs(value));
  return apart <= asymmetry_of_rounding * largest;
}

void DealtMatrices::add_rounding(int b, const Vector& state, double unit, RoundingForces& forces,
                                 Vector& size) const {
  const Vector sizes = diagonal(b).cwiseAbs().cwiseSqrt();
  const auto answers = ask({set(), MatrixErrand::rounding, b, unit}, [&](int p) {
    std::vector<double> numbers = columns_of(p, state), of_sizes = columns_of(p, sizes);
    numbers.insert(numbers.end(), of_sizes.begin(), of_sizes.end());
    return numbers;
  });
  Vector of;
  for (std::size_t s = 0; s < n_samples; ++s) {
    collect(answers, s, of);
    forces[s] += of;
  }
  collect(answers, n_samples, of);
  size += of;
}

void DealtMatrices::combine(int matrix, const Vector& gamma) const {
  ask({set(), MatrixErrand::sum, matrix},
      [&](int) { return std::vector<double>(gamma.begin(), gamma.end()); });
}

void DealtMatrices::stiffen(int matrix, const Vector& more) const {
  ask({set(), MatrixErrand::stiffen, matrix}, [&](int p) { return rows_of(p, more); });
}

RowArrays DealtMatrices::place(int matrix, double alone) const {
  ask({set(), MatrixErrand::place, matrix, alone});
  return mine_.placed(set(), matrix);
}

void DealtMatrices::leave(int matrix) const { ask({set(), MatrixErrand::leave, matrix}); }

void DealtMatrices::forget(int matrix) const noexcept {
  try {
    ask({set(), MatrixErrand::forget, matrix});
  } catch (const std::exception&) { // the others are at their end
  }
}

/// Unknowns of one cell are coupled.
Pieces DealtMatrices::pieces() const {
  return Pieces(n_unknowns_, [&](const std::function<void(int, int)>& couple) {
    for (std::size_t cell = 0; cell < d_.mesh.cells.size(); ++cell) {
      int first = -1;
      for (const auto node : d_.space.nodes_of_cell(static_cast<int>(cell)))
        for (int c = 0; c < d_.space.components; ++c) {
          const auto unknown = d_.dofs.unknown_of[d_.space.dof(node, c)];
          if (unknown < 0) continue;
          if (first >= 0) couple(first, unknown);
          first = unknown;
        }
    }
  });
}

std::vector<std::vector<int>>
DealtMatrices::points_of_each(std::span<const std::int32_t> cell) const {
  std::vector<std::vector<int>> out(of_.size());
  for (std::size_t p = 0; p < of_.size(); ++p) {
    std::vector<char> has(d_.mesh.cells.size(), 0);
    for (const auto own : of_[p].cells) has[own] = 1;
    for (std::size_t k = 0; k < cell.size(); ++k)
      if (has[cell[k]] != 0) out[p].push_back(static_cast<int>(k));
  }
  return out;
}

void DealtMatrices::take_states(const std::function<std::vector<double>(int)>& values) const {
  for (const std::string& answer : ask({set(), MatrixErrand::states}, values)) assembled(answer);
}

double DealtMatrices::bytes() const { return mine_.bytes(); }

void DealtMatrix::combine(const Vector& gamma) {
  all_.combine(number_, gamma);
  diagonal_ = all_.diagonal(number_);
  last_ = {};
}

void DealtMatrix::stiffen(const Vector& more) {
  all_.stiffen(number_, more);
  diagonal_ += more;
  last_ = {};
}

MotionForces DealtMatrix::forces_of(const DenseMatrix& motions, bool transposed) const {
  MotionForces out{DenseMatrix(size(), motions.cols()), DenseMatrix(size(), motions.cols())};
  Vector forces, sizes;
  for (Eigen::Index m = 0; m < motions.cols(); ++m) {
    const Vector motion = motions.col(m);
    if (transposed)
      all_.transposed(number_, motion, forces, sizes);
    else
      apply(motion, forces), apply_magnitude(motion, sizes);
    out.forces.col(m) = forces;
    out.sizes.col(m) = sizes;
  }
  return out;
}

/// Rows that are no unknown's have the largest entry of the others.
DealtRows DealtMatrix::rows() const {
  return {all_.set(), number_,
          [this] {
            const double most = diagonal_.lpNorm<Eigen::Infinity>();
            return all_.place(number_, most > 0.0 ? most : 1.0);
          },
          [this] { all_.leave(number_); }};
}

std::function<double(int)> DealtMatrix::whole_sizes(const Vector& x) const {
  return [this, &x, whole = static_cast<const Vector*>(nullptr)](int i) mutable {
    if (whole == nullptr) whole = &last(x).whole;
    return (*whole)[i];
  };
}

const DealtMatrix::Last& DealtMatrix::last(const Vector& x) const {
  if (last_.x.size() != x.size() || last_.x != x) {
    all_.product(number_, x, last_.product, last_.whole);
    last_.x = x;
  }
  return last_;
}

} // namespace hvi::solver
