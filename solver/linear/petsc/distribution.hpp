// Who has which rows of a system. The first process has the program, and with it all of K, H and
// right-hand sides; it deals out blocks of rows. A process that is alone has its own arrays, and
// nothing is copied. All calls but the questions are made by all processes together.
#pragma once

#include "solver/linear/petsc/numbering.hpp"
#include "solver/linear/petsc/session.hpp"

#include <vector>

namespace hvi::petsc_module {

class Distribution {
public:
  /// What the first process has been told of: components of a node, rows of each process.
  explicit Distribution(const Numbering& numbering);
  /// Of other rows: how many each process has.
  Distribution(MPI_Comm comm, std::vector<int> counts, int components = 1);
  MPI_Comm comm() const { return comm_; }
  bool alone() const { return first_.size() == 2; }
  int components() const { return components_; }
  int rows() const { return first_[rank_ + 1] - first_[rank_]; }
  int first_row() const { return first_[rank_]; }
  int all_rows() const { return first_.back(); }
  int process_of(int row) const;
  bool is_first() const { return rank_ == 0; }

  /// What the first process says.
  int of_first(int value) const;
  void add_up(double* values, int count) const; ///< over all processes
  double sum(double value) const;
  double largest(double value) const;
  void largest(double* values, int count) const; ///< each one, over all processes
  bool any(bool here) const;

  /// Each process's rows of `whole`; `mine` holds them where they are not those that it has.
  HviPetscMatrix deal(const WholeMatrix& whole, Rows& mine) const;
  HviPetscMatrix deal(const HviPetscMatrix& whole, Rows& mine) const {
    return deal(WholeMatrix(whole), mine);
  }
  std::vector<int> deal(const std::vector<int>& whole) const;
  /// To the first process the rows of a matrix that it names, in their order.
  Rows fetch(const std::vector<int>& named, Mat matrix) const;
  /// Of columns one after the other.
  std::vector<double> deal(std::vector<double> columns, int count) const;

  /// A matrix of these rows, whose entries it reads where they are, or copies; and their values
  /// once more.
  void make(const HviPetscMatrix& mine, Owned<Mat>& matrix) const;
  void refresh(const HviPetscMatrix& mine, Mat matrix) const;
  /// Of this process's part of a matrix, where its entries were copied.
  double copied_bytes(Mat matrix) const;
  /// A vector of these values.
  void make(double* values, Owned<Vec>& vector) const;

private:
  void send(const Rows& part, int to) const;
  void receive(Rows& mine, int rows, int from) const;
  Rows in_order(const std::vector<int>& named, Rows mine) const;
  template <class T>
  void scatter(const T* whole, const std::vector<int>& counts, std::vector<T>& mine,
               MPI_Datatype type) const;
  std::vector<int> counts() const;

  MPI_Comm comm_;
  int rank_;
  int components_ = 1;
  std::vector<int> first_; ///< row of each process, and the end
};

} // namespace hvi::petsc_module
