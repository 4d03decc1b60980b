// Switches of a law: the places where a pointwise expression changes from one smooth function to
// another (cases, abs, min, max, sign, tables), and its specialisation to one side of each.
#pragma once

#include "solver/kernel/expr.hpp"
#include "solver/mesh/mesh.hpp"

#include <limits>
#include <vector>

namespace hvi::solver {

/// A node whose value depends on which side of its switch function's roots r lies.
struct Switch {
  enum class Kind {
    two_sided, ///< comparisons, min, max, abs, sign: the sign of `function` decides
    table,     ///< which interval of the table holds `function`
    singular   ///< sqrt, log, division, real powers: no choice, but a derivative may blow up
  };
  Expr node;
  Expr function; ///< roots (table: points where it meets an abscissa) are breaks
  Kind kind = Kind::two_sided;
  bool nested = false; ///< `function` contains switches itself
};

/// One outcome per switch: the sign of its function (-1, 0, 1), or the table's interval
/// (0: below the first abscissa ... n: above the last), 0 for a singular one.
using Signature = std::vector<int>;
/// In a signature: this switch is left as it is.
constexpr int open_outcome = std::numeric_limits<int>::min();

/// Every switch of the expressions that depends on slot::argument(0), inner ones first.
std::vector<Switch> find_switches(std::span<const Expr> expressions);

/// The outcome of a switch when its function has this value.
int outcome_of(const Switch& s, double value);

/// Does `part` stand somewhere in `expr`?
bool contains(const Expr& expr, const Expr& part);

/// The expression with each of the first `signature.size()` switches resolved.
Expr specialise(const Expr& expr, const std::vector<Switch>& switches, const Signature& signature);

/// sqrt(a^2) and even powers under a root become powers of |a|, so that the kink is seen.
Expr expose_kinks(const Expr& expr);

} // namespace hvi::solver
