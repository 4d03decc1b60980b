// See single_precision.hpp.
#include "solver/linear/petsc/single_precision.hpp"

#include "solver/linear/petsc/numbering.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace hvi::petsc_module {
namespace {

/// The rows of a sequential matrix, as PETSc has them.
class ReadRows {
public:
  explicit ReadRows(Mat a) : a_(a) {
    PetscBool done = PETSC_FALSE;
    check(MatGetRowIJ(a_, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
    check(MatSeqAIJGetArrayRead(a_, &value));
  }
  ReadRows(const ReadRows&) = delete;
  ReadRows& operator=(const ReadRows&) = delete;
  ~ReadRows() {
    PetscBool done = PETSC_FALSE;
    static_cast<void>(MatSeqAIJRestoreArrayRead(a_, &value));
    static_cast<void>(
        MatRestoreRowIJ(a_, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
  }
  PetscInt count = 0;
  const PetscInt *start = nullptr, *column = nullptr;
  const double* value = nullptr;

private:
  Mat a_;
};

/// Calls `of` with the sizes of a block as constants; false where there is no such product.
template <class Product>
bool with_sizes(int rows, int columns, const Product& of) {
  const auto is = [&](int r, int c) { return rows == r && columns == c; };
  if (is(1, 1))
    of.template operator()<1, 1>();
  else if (is(2, 2))
    of.template operator()<2, 2>();
  else if (is(2, 3))
    of.template operator()<2, 3>();
  else if (is(3, 3))
    of.template operator()<3, 3>();
  else if (is(3, 6))
    of.template operator()<3, 6>();
  else if (is(6, 6))
    of.template operator()<6, 6>();
  else
    return false;
  return true;
}

/// Whether these columns, ascending, are whole blocks.
bool are_blocks(const PetscInt* columns, PetscInt count, int size) {
  if (count % size != 0) return false;
  for (PetscInt c = 0; c < count; ++c)
    if (columns[c] % size != c % size || columns[c] - c % size != columns[c - c % size])
      return false;
  return true;
}

/// To the entries of `rows`, the sums of the sizes in those rows.
void add_sizes(Mat a, const std::vector<int>& rows, Vec to) {
  PetscInt first = 0;
  double* sums = nullptr;
  check(MatGetOwnershipRange(a, &first, nullptr));
  check(VecGetArray(to, &sums));
  for (const int i : rows) {
    PetscInt count = 0;
    const double* value = nullptr;
    check(MatGetRow(a, first + i, &count, nullptr, &value));
    for (PetscInt e = 0; e < count; ++e) sums[i] += std::abs(value[e]);
    check(MatRestoreRow(a, first + i, &count, nullptr, &value));
  }
  check(VecRestoreArray(to, &sums));
}

struct NoProduct {
  template <int rows, int columns>
  void operator()() const {}
};

} // namespace

SingleBlocks::SingleBlocks(Mat sequential, int block_rows, int block_columns) {
  PetscInt rows = 0, columns = 0;
  check(MatGetSize(sequential, &rows, &columns));
  if (rows % block_rows == 0 && columns % block_columns == 0 &&
      with_sizes(block_rows, block_columns, NoProduct{}))
    block_rows_ = block_rows, block_columns_ = block_columns;
  read(sequential, rows / block_rows_, columns / block_columns_);
}

void SingleBlocks::read(Mat sequential, int rows, int columns) {
  const ReadRows a(sequential);
  const PetscInt entries = a.count > 0 ? a.start[a.count] : 0;
  double most = 0.0;
  for (PetscInt e = 0; e < entries; ++e) most = std::max(most, std::abs(a.value[e]));
  if (most > 0.0) scale_ = most;
  const int size = block_rows_ * block_columns_;
  std::vector<int> position(static_cast<std::size_t>(columns), -1);
  start_.assign(1, 0);
  for (int i = 0; i < rows; ++i) {
    const PetscInt first = a.start[i * block_rows_], end = a.start[(i + 1) * block_rows_];
    const std::size_t begin = column_.size();
    for (PetscInt e = first; e < end; ++e)
      if (int& seen = position[a.column[e] / block_columns_]; seen < 0) {
        column_.push_back(a.column[e] / block_columns_);
        seen = 0;
      }
    std::sort(column_.begin() + static_cast<std::ptrdiff_t>(begin), column_.end());
    for (std::size_t b = begin; b < column_.size(); ++b) position[column_[b]] = static_cast<int>(b);
    value_.resize(column_.size() * static_cast<std::size_t>(size), 0.0F);
    for (int r = 0; r < block_rows_; ++r)
      for (PetscInt e = a.start[i * block_rows_ + r]; e < a.start[i * block_rows_ + r + 1]; ++e) {
        const std::ptrdiff_t block = position[a.column[e] / block_columns_];
        const int within = a.column[e] % block_columns_ * block_rows_ + r;
        value_[static_cast<std::size_t>(block * size + within)] =
            static_cast<float>(a.value[e] / scale_);
      }
    for (std::size_t b = begin; b < column_.size(); ++b) position[column_[b]] = -1;
    start_.push_back(static_cast<int>(column_.size()));
  }
}

/// What the products read.
struct SingleBlocks::Block {
  const SingleBlocks& of;
  const double* x;
  double* y;
  bool transpose;

  template <int rows, int columns>
  void operator()() const {
    using Entries = Eigen::Map<const Eigen::Matrix<float, rows, columns>>;
    using From = Eigen::Map<const Eigen::Matrix<double, columns, 1>>;
    using To = Eigen::Map<Eigen::Matrix<double, columns, 1>>;
    using Rows = Eigen::Matrix<double, rows, 1>;
    const auto entries = [&](int e) {
      return Entries(of.value_.data() + static_cast<std::ptrdiff_t>(e) * rows * columns)
          .template cast<double>();
    };
    const int count = static_cast<int>(of.start_.size()) - 1;
    for (int i = 0; i < count; ++i) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(i) * rows;
      if (transpose) {
        const Rows from = of.scale_ * Eigen::Map<const Rows>(x + row);
        for (int e = of.start_[i]; e < of.start_[i + 1]; ++e)
          To(y + static_cast<std::ptrdiff_t>(of.column_[e]) * columns).noalias() +=
              entries(e).transpose() * from;
        continue;
      }
      Rows sum = Rows::Zero();
      for (int e = of.start_[i]; e < of.start_[i + 1]; ++e)
        sum.noalias() +=
            entries(e) * From(x + static_cast<std::ptrdiff_t>(of.column_[e]) * columns);
      Eigen::Map<Rows>(y + row) += of.scale_ * sum;
    }
  }
};

void SingleBlocks::add_product(const double* x, double* y) const {
  with_sizes(block_rows_, block_columns_, Block{*this, x, y, false});
}

void SingleBlocks::add_transposed(const double* x, double* y) const {
  with_sizes(block_rows_, block_columns_, Block{*this, x, y, true});
}

template <class Take>
void SingleBlocks::read_row(int i, const Take& take) const {
  const int block = i / block_rows_, within = i % block_rows_;
  for (int e = start_[block]; e < start_[block + 1]; ++e)
    for (int c = 0; c < block_columns_; ++c) {
      const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(e) * block_columns_ + c;
      const float value = value_[static_cast<std::size_t>(place * block_rows_ + within)];
      if (value != 0.0F) take(column_[e] * block_columns_ + c, scale_ * value);
    }
}

double SingleBlocks::bytes() const {
  return static_cast<double>(sizeof(float) * value_.size() +
                             sizeof(int) * (start_.size() + column_.size()));
}

SingleMatrix::SingleMatrix(Mat a, int block_rows, int block_columns) {
  PetscInt rows = 0, columns = 0;
  Mat own = a, others = nullptr;
  const PetscInt* ghosts = nullptr;
  PetscBool of_several = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(a), MATMPIAIJ, &of_several));
  if (of_several == PETSC_TRUE) check(MatMPIAIJGetSeqAIJ(a, &own, &others, &ghosts));
  own_ = std::make_unique<SingleBlocks>(own, block_rows, block_columns);
  if (others != nullptr) {
    PetscInt count = 0;
    check(MatGetSize(others, nullptr, &count));
    columns_.assign(ghosts, ghosts + count);
    const bool blocks = are_blocks(ghosts, count, block_columns);
    others_ =
        std::make_unique<SingleBlocks>(others, blocks ? block_rows : 1, blocks ? block_columns : 1);
    Owned<IS> wanted;
    Owned<Vec> whole;
    check(ISCreateGeneral(PETSC_COMM_SELF, count, ghosts, PETSC_COPY_VALUES, wanted.put()));
    check(MatCreateVecs(a, whole.put(), nullptr));
    check(VecCreateSeq(PETSC_COMM_SELF, count, ghosts_.put()));
    check(VecScatterCreate(whole.get(), wanted.get(), ghosts_.get(), nullptr, halo_.put()));
  }
  check(MatGetSize(a, &rows, &columns));
  if (rows == columns) {
    check(MatCreateVecs(a, own_diagonal_.put(), diagonal_.put()));
    check(MatGetDiagonal(a, own_diagonal_.get()));
    check(VecCopy(own_diagonal_.get(), diagonal_.get()));
  }
  make_shell(a);
}

void SingleMatrix::add(Mat few, const std::vector<int>& rows) {
  if (few == nullptr && few_ == nullptr) return;
  few_ = few;
  check(VecCopy(own_diagonal_.get(), diagonal_.get()));
  if (few != nullptr) add_sizes(few, rows, diagonal_.get());
  // Whoever asked for the diagonal asks again.
  check(MatAssemblyBegin(shell_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(shell_.get(), MAT_FINAL_ASSEMBLY));
}

void SingleMatrix::only(const std::vector<int>& rows, Owned<Mat>& out) const {
  PetscInt count = 0, columns = 0, all_rows = 0, all_columns = 0, first = 0;
  check(MatGetLocalSize(shell_.get(), &count, &columns));
  check(MatGetSize(shell_.get(), &all_rows, &all_columns));
  check(MatGetOwnershipRangeColumn(shell_.get(), &first, nullptr));
  Rows kept;
  kept.start.assign(static_cast<std::size_t>(count) + 1, 0);
  std::vector<std::pair<int, double>> row;
  for (const int i : rows) {
    row.clear();
    own_->read_row(i, [&](int column, double value) { row.emplace_back(first + column, value); });
    if (others_)
      others_->read_row(i, [&](int column, double value) {
        row.emplace_back(columns_[static_cast<std::size_t>(column)], value);
      });
    std::sort(row.begin(), row.end());
    for (const auto& [column, value] : row) {
      kept.column.push_back(column);
      kept.value.push_back(value);
    }
    kept.start[i + 1] = static_cast<int>(row.size());
  }
  std::partial_sum(kept.start.begin(), kept.start.end(), kept.start.begin());
  check(MatCreate(PetscObjectComm(reinterpret_cast<PetscObject>(shell_.get())), out.put()));
  check(MatSetSizes(out.get(), count, columns, all_rows, all_columns));
  check(MatSetType(out.get(), MATAIJ));
  const HviPetscMatrix of = kept.view();
  check(MatSeqAIJSetPreallocationCSR(out.get(), of.start, of.column, of.value));
  check(MatMPIAIJSetPreallocationCSR(out.get(), of.start, of.column, of.value));
}

/// y = before + A x, or + A^T x; nothing before.
template <bool transpose>
PetscErrorCode SingleMatrix::product(Mat shell, Vec x, Vec before, Vec y) {
  void* self = nullptr;
  PetscCall(MatShellGetContext(shell, &self));
  if (before == nullptr) PetscCall(VecSet(y, 0.0));
  if (before != nullptr && before != y) PetscCall(VecCopy(before, y));
  const SingleMatrix& matrix = *static_cast<const SingleMatrix*>(self);
  return transpose ? matrix.add_transposed(x, y) : matrix.add_product(x, y);
}

template <bool transpose>
PetscErrorCode SingleMatrix::product_alone(Mat shell, Vec x, Vec y) {
  return product<transpose>(shell, x, nullptr, y);
}

PetscErrorCode SingleMatrix::diagonal(Mat shell, Vec d) {
  void* self = nullptr;
  PetscCall(MatShellGetContext(shell, &self));
  return VecCopy(static_cast<const SingleMatrix*>(self)->diagonal_.get(), d);
}

void SingleMatrix::make_shell(Mat a) {
  PetscInt rows = 0, columns = 0, all_rows = 0, all_columns = 0;
  check(MatGetLocalSize(a, &rows, &columns));
  check(MatGetSize(a, &all_rows, &all_columns));
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(a));
  check(MatCreateShell(comm, rows, columns, all_rows, all_columns, this, shell_.put()));
  const auto does = [&](MatOperation what, auto* how) {
    check(MatShellSetOperation(shell_.get(), what, reinterpret_cast<void (*)()>(how)));
  };
  does(MATOP_MULT, &SingleMatrix::product_alone<false>);
  does(MATOP_MULT_ADD, &SingleMatrix::product<false>);
  does(MATOP_MULT_TRANSPOSE, &SingleMatrix::product_alone<true>);
  does(MATOP_MULT_TRANSPOSE_ADD, &SingleMatrix::product<true>);
  does(MATOP_GET_DIAGONAL, &SingleMatrix::diagonal);
}

PetscErrorCode SingleMatrix::add_product(Vec x, Vec y) const {
  if (others_)
    PetscCall(VecScatterBegin(halo_.get(), x, ghosts_.get(), INSERT_VALUES, SCATTER_FORWARD));
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArray(y, &to));
  own_->add_product(from, to);
  if (others_) {
    const double* ghosts = nullptr;
    PetscCall(VecScatterEnd(halo_.get(), x, ghosts_.get(), INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecGetArrayRead(ghosts_.get(), &ghosts));
    others_->add_product(ghosts, to);
    PetscCall(VecRestoreArrayRead(ghosts_.get(), &ghosts));
  }
  PetscCall(VecRestoreArray(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  return few_ == nullptr ? 0 : MatMultAdd(few_, x, y, y);
}

PetscErrorCode SingleMatrix::add_transposed(Vec x, Vec y) const {
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  if (others_) {
    double* ghosts = nullptr;
    PetscCall(VecSet(ghosts_.get(), 0.0));
    PetscCall(VecGetArray(ghosts_.get(), &ghosts));
    others_->add_transposed(from, ghosts);
    PetscCall(VecRestoreArray(ghosts_.get(), &ghosts));
  }
  PetscCall(VecGetArray(y, &to));
  own_->add_transposed(from, to);
  PetscCall(VecRestoreArray(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  if (!others_) return 0;
  PetscCall(VecScatterBegin(halo_.get(), ghosts_.get(), y, ADD_VALUES, SCATTER_REVERSE));
  return VecScatterEnd(halo_.get(), ghosts_.get(), y, ADD_VALUES, SCATTER_REVERSE);
}

} // namespace hvi::petsc_module
