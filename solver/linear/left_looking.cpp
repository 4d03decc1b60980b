// Supernode after supernode; see left_looking.hpp. Called by the factor (cholesky_factor.cpp).
//
// A supernode waits in the list of the next supernode that it contributes to: the one that holds
// the first of its rows that were not taken yet.
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/left_looking.hpp"

#include "solver/linear/dense_blocks.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace hvi::solver {
namespace {

template <class Entry>
class LeftLooking {
public:
  LeftLooking(const PermutedLower& a, const cholmod_factor& l, int interior, Entry* values)
      : a_(a), of_(arrays_of(l)), interior_(interior), x_(values), supernode_(l.n), place_(l.n),
        first_waiting_(l.nsuper, none), next_waiting_(l.nsuper, none), taken_(l.nsuper, 0),
        product_(std::make_unique_for_overwrite<Entry[]>(l.maxcsize)) {
    for (std::size_t s = 0; s < l.nsuper; ++s)
      std::fill(supernode_.begin() + of_.super[s], supernode_.begin() + of_.super[s + 1],
                static_cast<int>(s));
  }

  /// The first column of supernode s whose pivot is not positive, or -1.
  Long factor(int s) {
    const Block own = block(s);
    for (int i = 0; i < own.rows; ++i) place_[own.row[i]] = i;
    take_matrix(s, own);
    for (int d = first_waiting_[s]; d != none;) {
      const int next = next_waiting_[d];
      subtract_product(d, own);
      wait(d, block(d));
      d = next;
    }
    if (own.eliminated == 0) return -1;
    const int info = dense_blocks::cholesky(own.eliminated, own.value, own.rows);
    if (info != 0) return own.first + info - 1;
    if (own.rows == own.eliminated) return -1;
    dense_blocks::solve_below(own.rows - own.eliminated, own.eliminated, own.value,
                              own.value + own.eliminated, own.rows);
    if (const int kept = own.columns - own.eliminated; kept > 0) {
      Entry* const below = own.value + own.eliminated;
      dense_blocks::subtract_products(
          kept, own.rows - own.columns, own.eliminated, below, own.rows,
          below + static_cast<std::ptrdiff_t>(own.eliminated) * own.rows, own.rows);
    }
    taken_[s] = own.columns;
    wait(s, own);
    return -1;
  }

private:
  static constexpr int none = -1;

  /// A supernode: a dense block of `rows` rows by columns, whose first rows are its own columns.
  /// The first ones of these are eliminated.
  struct Block {
    Long first;
    int columns, eliminated, rows;
    const Long* row;
    Entry* value;
  };

  Block block(int s) const {
    const Long first = of_.super[s], rows = of_.row_start[s];
    const auto columns = static_cast<int>(of_.super[s + 1] - first);
    return {first,
            columns,
            static_cast<int>(std::clamp<Long>(interior_ - first, 0, columns)),
            static_cast<int>(of_.row_start[s + 1] - rows),
            of_.row + rows,
            x_ + of_.value_start[s]};
  }

  /// Into the list of the supernode that comes next for it.
  void wait(int s, const Block& its) {
    if (taken_[s] == its.rows) return;
    const int at = supernode_[its.row[taken_[s]]];
    next_waiting_[s] = first_waiting_[at];
    first_waiting_[at] = s;
  }

  void take_matrix(int s, const Block& own) {
    std::fill_n(own.value, static_cast<std::ptrdiff_t>(own.rows) * own.columns, Entry{0});
    const Pattern& pattern = a_.pattern();
    for (Long j = own.first; j < of_.super[s + 1]; ++j) {
      Entry* const column = own.value + (j - own.first) * own.rows;
      for (Long at = pattern.start[j]; at < pattern.start[j + 1]; ++at)
        column[place_[pattern.row[at]]] = static_cast<Entry>(a_.values()[at]);
    }
  }

  /// Subtracts L_d L_d^T on the columns of `own`, and moves on to the next rows of d.
  void subtract_product(int d, const Block& own) {
    const Block other = block(d);
    const int from = taken_[d], rows = other.rows - from;
    const Long* const row = other.row + from;
    const auto end = own.first + own.columns;
    int columns = 0;
    while (columns < rows && row[columns] < end) ++columns;
    taken_[d] += columns;
    const Entry* const l = other.value + from;
    Entry* const c = product_.get();
    dense_blocks::self_product(columns, other.eliminated, l, other.rows, c, rows);
    if (rows > columns)
      dense_blocks::product(rows - columns, columns, other.eliminated, l + columns, l, other.rows,
                            c + columns, rows);
    subtract(row, rows, columns, own);
  }

  /// Subtracts the product, whose lower triangle has these rows, and as many of them as columns.
  void subtract(const Long* row, int rows, int columns, const Block& own) {
    place_of_row_.resize(static_cast<std::size_t>(rows));
    for (int i = 0; i < rows; ++i) place_of_row_[i] = place_[row[i]];
    const int* const place = place_of_row_.data();
    // Places rise, so that rows from i on lie side by side where the first and the last ones do.
    int together = rows;
    while (together > 0 && place[rows - 1] - place[together - 1] == rows - together) --together;
    for (int j = 0; j < columns; ++j) {
      const Entry* const from = product_.get() + static_cast<std::ptrdiff_t>(j) * rows;
      Entry* const to = own.value + static_cast<std::ptrdiff_t>(place[j]) * own.rows;
      int i = j;
      for (; i < together; ++i) to[place[i]] -= from[i];
      if (i == rows) continue;
      Entry* const end = to + place[i] - i;
      for (; i < rows; ++i) end[i] -= from[i];
    }
  }

  const PermutedLower& a_;
  SupernodalArrays of_;
  Long interior_;
  Entry* x_;
  std::vector<int> supernode_; ///< of a column
  std::vector<int> place_;     ///< of a row in the block of the supernode at hand
  std::vector<int> first_waiting_, next_waiting_;
  std::vector<int> taken_; ///< rows of a supernode that other ones had
  std::unique_ptr<Entry[]> product_;
  std::vector<int> place_of_row_;
};

} // namespace

template <class Entry>
Long factor_left_looking(const PermutedLower& a, const cholmod_factor& l, int interior,
                         Entry* values) {
  LeftLooking work(a, l, interior, values);
  for (int s = 0; s < static_cast<int>(l.nsuper); ++s)
    if (const Long failed = work.factor(s); failed >= 0) return failed;
  return interior;
}

template Long factor_left_looking(const PermutedLower&, const cholmod_factor&, int, double*);
template Long factor_left_looking(const PermutedLower&, const cholmod_factor&, int, float*);

} // namespace hvi::solver
