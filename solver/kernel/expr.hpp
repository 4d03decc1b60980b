// Scalar pointwise expressions: immutable, shared, simplified as they are built. The symbolic half
// of the kernel: derivatives, substitution, printing. What runs is the tape (tape.hpp).
#pragma once

#include "solver/kernel/slot.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::solver {

class Table; // table.hpp: a tabulated function of one variable

enum class Op : unsigned char {
  constant,
  slot,
  add,
  mul,
  div,
  neg,
  pow, // n-ary sums and products are nested binary ones; a - b is a + (-b)
  min,
  max,
  abs,
  sign,
  exp,
  log,
  sqrt,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  atan2,
  sinh,
  cosh,
  tanh,
  erf,
  erfc,
  gamma,
  bessel_j,       // bessel_j(order, x)
  erfcx,          // (n, x): exp(x^2) i^n erfc(x)
  mittag_leffler, // (alpha, beta, x): E_{alpha,beta}(x)
  less,
  less_equal,
  equal, // 1 or 0; NaN (unknown) where an operand is NaN
  logic_and,
  logic_or,
  logic_not,   // three-valued: 0 and NaN = 0, 1 or NaN = 1
  select,      // (condition, then, otherwise); the branch not taken may be NaN
  table,       // table(x)
  table_slope, // derivative of a table
  polygamma    // polygamma(n, x): n-th derivative of digamma, what gamma' needs
};

/// A scalar expression. Copying shares; nothing is ever changed in place.
class Expr {
public:
  struct Node;

  Expr(double value = 0.0); // NOLINT: numbers are expressions
  static Expr variable(Slot slot);
  /// A node with constant folding and the usual identities (0*x, 1*x, x+0, --x, x-x, ...).
  static Expr make(Op op, std::vector<Expr> args);
  static Expr tabulated(std::shared_ptr<const Table> table, Expr x, bool slope = false);

  Op op() const;
  double value() const; ///< of a constant
  Slot slot() const;    ///< of a variable
  std::span<const Expr> args() const;
  const std::shared_ptr<const Table>& table() const;

  bool is_constant() const { return op() == Op::constant; }
  bool is(double v) const { return is_constant() && value() == v; }
  bool depends_on(Slot slot) const;
  bool depends_on_any(Slot first, Slot past) const; ///< any slot in [first, past)
  std::span<const Slot> slots() const;              ///< all slots it depends on, sorted
  std::size_t hash() const;
  const void* id() const { return node_.get(); } ///< of the shared node: a key for memo tables
  /// Structural equality (the same tree after simplification).
  friend bool operator==(const Expr& a, const Expr& b);

private:
  friend struct ExprAccess; // node.hpp: the kernel's own files build nodes
  explicit Expr(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
  std::shared_ptr<const Node> node_;
};

Expr operator+(const Expr& a, const Expr& b);
Expr operator-(const Expr& a, const Expr& b);
Expr operator-(const Expr& a);
Expr operator*(const Expr& a, const Expr& b);
Expr operator/(const Expr& a, const Expr& b);
Expr pow(const Expr& a, const Expr& b);
Expr min(const Expr& a, const Expr& b);
Expr max(const Expr& a, const Expr& b);
Expr abs(const Expr& a);
Expr exp(const Expr& a);
Expr log(const Expr& a);
Expr sqrt(const Expr& a);
Expr sin(const Expr& a);
Expr cos(const Expr& a);
Expr select(const Expr& condition, const Expr& then, const Expr& otherwise);
Expr less(const Expr& a, const Expr& b);
Expr less_equal(const Expr& a, const Expr& b);

/// d expr / d slot. Kinks (abs, min, max, select) differentiate branch by branch. Throws
/// Failure(bad_value) when the order of a Bessel function or of erfcx or a parameter of
/// mittag_leffler depends on the slot: those derivatives have no expression here.
Expr derivative(const Expr& expr, Slot slot);
Expr substitute(const Expr& expr, std::span<const std::pair<Slot, Expr>> replacements);
/// Rebuilds the tree bottom-up, replacing each node f(node with new args) -> Expr.
Expr transform(const Expr& expr, const std::function<Expr(const Expr&)>& f);
/// All slots the expression depends on, sorted.
std::vector<Slot> slots_of(const Expr& expr);
/// One value, slowly; `value_of` gives each slot's value. For set-up, never for a hot loop.
double evaluate(const Expr& expr, const std::function<double(Slot)>& value_of);
/// The name of an operation: the language's word where there is one.
std::string_view op_name(Op op);
/// The expression in the language's notation, numbers with all their digits. Text beyond a megabyte
/// is cut: a shared graph can be exponentially long when written out.
std::string to_string(const Expr& expr);

} // namespace hvi::solver
