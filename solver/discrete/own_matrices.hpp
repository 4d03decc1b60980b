// The base matrices of a problem in one of several processes: its rows of them, assembled on its
// own cells, and what the first process asks of these.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/dealt_forms.hpp"
#include "solver/discrete/own_cells.hpp"
#include "solver/discrete/own_states.hpp"
#include "solver/linear/own_rows.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::solver {

/// A message is this, and numbers behind it: what `what` asks for, of the matrices `set`.
struct MatrixErrand {
  enum What : int {
    assemble,   ///< bytes of put_assembly, to be answered as assembled() reads it
    products,   ///< OwnRows::products of these columns
    precisely,  ///< OwnRows::precisely
    magnitudes, ///< OwnRows::magnitudes
    diagonal,   ///< OwnRows::diagonal
    transposed, ///< OwnRows::transposed of numbers of its rows
    asymmetry,  ///< OwnRows::asymmetry
    states,     ///< OwnChangingForms::take of these values, to be answered as assembled() reads it
    sum,        ///< OwnRows::combine by these coefficients
    stiffen,    ///< OwnRows::stiffen by these numbers
    place,      ///< OwnRows::place, `number` for the rows that are no unknown's
    leave,      ///< OwnRows::leave
    rounding,   ///< rounding_of_rows by the unit `number` of these columns and, behind, their sizes
    forget,     ///< the matrix
    end         ///< of the set
  };
  std::uint64_t set = 0;
  What what = end;
  int matrix = 0;
  double number = 0.0;
};

std::string message_of(const MatrixErrand& errand, std::span<const double> numbers = {});
std::string message_of(const MatrixErrand& errand, std::string_view bytes);
/// An answer's numbers.
std::span<const double> numbers_in(std::string_view answer);
/// The weights of the base matrices that a process has made of the forms, which are the same in
/// all; none where it took states. Throws the failure that it met with.
std::vector<Vector> assembled(std::string_view answer);

/// What process p needs to assemble its rows. `place`: by state entry, as PlacedRows::column;
/// `first_row`: of each process, and the end.
OwnEntries put_assembly(StateWriter& w, const Discretisation& discretisation,
                        const StateLayout& layout, std::span<const std::int32_t> part_of_node,
                        int p, std::span<const std::int32_t> place, std::span<const int> first_row,
                        const DealtForms& forms);

/// All sets of one process.
class OwnMatrices {
public:
  /// The answer to a message of the first process.
  std::string answer(std::string_view message);
  RowArrays placed(std::uint64_t set, int matrix) const {
    return sets_.at(set).rows.placed(matrix);
  }
  double bytes() const;

private:
  struct Set {
    OwnRows rows;
    std::unique_ptr<OwnChangingForms> changing; ///< null: states change nothing
  };
  std::string assemble(std::uint64_t set, std::string_view bytes);
  static std::string take_states(Set& of, std::span<const double> values);
  std::map<std::uint64_t, Set> sets_;
};

} // namespace hvi::solver
