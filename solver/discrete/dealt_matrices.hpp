// The base matrices of a problem whose rows several processes have, each those of its own nodes
// (own_matrices.hpp), as the first process sees them: by what they make of vectors.
#pragma once

#include "solver/discrete/own_matrices.hpp"
#include "solver/discrete/rigid_motions.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/linear/double_double.hpp"
#include "solver/linear/iterative_solver.hpp"
#include "solver/linear/matrix_rows.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hvi::solver {

class DealtMatrices {
public:
  /// All processes assemble these forms. `unknowns` learns where its nodes are. Keeps a reference
  /// to the discretisation. Throws what a process met with.
  DealtMatrices(const Discretisation& discretisation, const StateLayout& layout,
                const DealtForms& forms, int processes, UnknownsOfNodes& unknowns);
  ~DealtMatrices();
  DealtMatrices(const DealtMatrices&) = delete;
  DealtMatrices& operator=(const DealtMatrices&) = delete;

  /// By base matrix, the coefficients in each field.
  const std::vector<Vector>& weights() const { return weights_; }
  int processes() const { return processes_; }
  int n_unknowns() const { return n_unknowns_; }
  /// `x`: a state, or the unknowns alone where its other values are 0. A x, and |A_ii| max |x_j|
  /// over the columns of row i.
  void product(int matrix, const Vector& x, Vector& product, Vector& whole) const;
  /// subtract_product (double_double.hpp).
  void subtract_product(int matrix, const Vector& x, std::vector<DoubleDouble>& y,
                        Vector& size) const;
  /// |A| |x|
  void magnitude(int matrix, const Vector& x, Vector& out) const;
  Vector diagonal(int matrix) const;
  /// A^T x and |A|^T |x|, on the unknowns.
  void transposed(int matrix, const Vector& x, Vector& product, Vector& sizes) const;
  /// To rounding; see symmetric_to_rounding (operators.hpp).
  bool is_symmetric(int matrix) const;
  /// add_rounding (rounding.hpp) of base b.
  void add_rounding(int b, const Vector& state, double unit, RoundingForces& forces,
                    Vector& size) const;

  /// Another matrix, a sum of the bases.
  int another() { return next_++; }
  void combine(int matrix, const Vector& gamma) const;
  void stiffen(int matrix, const Vector& more) const; ///< adds to the diagonal
  /// For PETSc; see OwnRows::place and OwnRows::leave.
  RowArrays place(int matrix, double alone) const;
  void leave(int matrix) const;
  void forget(int matrix) const noexcept;
  std::uint64_t set() const { return reinterpret_cast<std::uintptr_t>(this); }
  Pieces pieces() const;
  /// Which of some points, whose cells these are, each process has.
  std::vector<std::vector<int>> points_of_each(std::span<const std::int32_t> cell) const;
  /// The forms that read states become those of these (OwnChangingForms::take). Throws what a
  /// process met with.
  void take_states(const std::function<std::vector<double>(int)>& values) const;
  double bytes() const; ///< of this process

private:
  void end() const noexcept; ///< of all processes' rows
  std::vector<std::string> ask(const MatrixErrand& errand,
                               const std::function<std::vector<double>(int)>& numbers) const;
  std::vector<std::string> ask(const MatrixErrand& errand) const;
  std::vector<std::string> ask(std::span<const std::string> messages) const;
  std::vector<double> columns_of(int p, const Vector& x) const;
  std::vector<double> rows_of(int p, const Vector& x) const;
  /// Numbers of each process's rows, `part` of several blocks of them, to their unknowns.
  void collect(const std::vector<std::string>& answers, std::size_t part, Vector& out) const;
  void deal_out_nodes(const StateLayout& layout, const std::vector<std::int32_t>& part_of_node,
                      UnknownsOfNodes& unknowns);

  const Discretisation& d_;
  int processes_, n_unknowns_;
  int next_ = 0;
  std::vector<OwnEntries> of_; ///< by process
  std::vector<Vector> weights_;
  std::vector<int> first_row_;      ///< PETSc's, of each process, and the end
  std::vector<std::int32_t> place_; ///< by state entry; see PlacedRows::column
  mutable OwnMatrices mine_;
};

/// K of a step.
class DealtMatrix final : public MatrixRows {
public:
  /// Keeps a reference.
  explicit DealtMatrix(DealtMatrices& all) : all_(all), number_(all.another()) {}
  ~DealtMatrix() override { all_.forget(number_); }
  DealtMatrix(const DealtMatrix&) = delete;
  DealtMatrix& operator=(const DealtMatrix&) = delete;

  void combine(const Vector& gamma);
  /// Adds to the diagonal.
  void stiffen(const Vector& more);
  double diagonal_entry(int i) const { return diagonal_[i]; }
  MotionForces forces_of(const DenseMatrix& motions, bool transposed) const;
  /// For the iterative solver, while this lives.
  DealtRows rows() const;

  int size() const override { return all_.n_unknowns(); }
  void apply(const Vector& x, Vector& y) const override { y = last(x).product; }
  void apply_magnitude(const Vector& x, Vector& y) const override { all_.magnitude(number_, x, y); }
  Vector diagonal() const override { return diagonal_; }
  Vector own_stiffness() const override { return diagonal_.cwiseAbs(); }
  std::function<double(int)> whole_sizes(const Vector& x) const override;
  Pieces pieces() const override { return all_.pieces(); }

private:
  /// What was made of the last x.
  struct Last {
    Vector x, product, whole;
  };
  const Last& last(const Vector& x) const;

  DealtMatrices& all_;
  int number_;
  Vector diagonal_;
  mutable Last last_;
};

} // namespace hvi::solver
