// Expressions and conditions of the syntax tree, see ast.hpp.
#pragma once

#include "lang/diag/source.hpp"
#include "lang/syntax/box.hpp"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace hvi::lang::ast {

/// A name as written, with its place.
struct Name {
  std::string text;
  Span span;
};

/// Text between quotes, without them; the span includes them.
struct Text {
  std::string text;
  Span span;
};

// --- expressions -------------------------------------------------------------------------------

struct Expr;
struct Condition;
struct Argument;
struct Case;

struct Number {
  double value = 0;
};

struct String {
  std::string text;
};

/// A unit between brackets, `kg/m^3`, without blanks; the span has the brackets in it.
struct UnitText {
  std::string text;
  Span span;
};

/// 70 [GPa], (a/2) [mm]: a number with its unit. `[0, 10] [s]` gives each entry its unit.
struct Quantity {
  Box<Expr> value;
  UnitText unit;
};

/// A name used as a value: u, lag, pi, P1.
struct Reference {
  std::string name;
};

/// [a, b, ...]; a matrix is a list of lists.
struct List {
  std::vector<Expr> items;
};

/// -a
struct Negate {
  Span op;
  Box<Expr> operand;
};

enum class BinaryOp { add, subtract, multiply, divide, contract, power }; // + - * / : ^

/// a op b. Sums, products and contractions are left associative, powers right associative.
struct Binary {
  BinaryOp op = BinaryOp::add;
  Span op_span;
  Box<Expr> left;
  Box<Expr> right;
};

/// | condition -> value ... | otherwise -> value
struct Cases {
  std::vector<Case> cases; // at least one
  Span otherwise_bar;
  Span otherwise_word;
  Span otherwise_arrow;
  Box<Expr> otherwise;
};

/// object.member: u.nu, slab.top, layer.xi
struct Member {
  Box<Expr> object;
  Name member;
};

/// u'
struct Prime {
  Span op;
  Box<Expr> operand;
};

/// f(a, name = b). The callee is a Reference or Members of one (slab.group).
struct Call {
  Box<Expr> callee;
  Span open;  // "("
  Span close; // ")"
  std::vector<Argument> arguments;
};

/// law^0(at; direction): the generalised directional derivative of Clarke.
struct Clarke {
  Box<Expr> law;
  Span op; // "^0("
  Box<Expr> at;
  Box<Expr> direction;
};

struct Expr {
  using Node = std::variant<Number, Quantity, String, Reference, List, Negate, Binary, Cases,
                            Member, Prime, Call, Clarke>;
  Span span;      // includes the parentheses around it
  int parens = 0; // pairs of parentheses around it; they matter to the formatter only
  int depth = 1;  // height of the tree below, limited so that recursion is safe
  Node node;
};

struct Argument {
  Span span;
  std::optional<Name> name;
  Expr value;
};

// --- conditions --------------------------------------------------------------------------------

enum class CompareOp { less, less_equal, greater, greater_equal, equal, not_equal };

struct Compare {
  CompareOp op = CompareOp::less;
  Span op_span;
  Expr left;
  Expr right;
};

/// inside(part)
struct Inside {
  Span word;
  Name part;
};

struct Not {
  Span op;
  Box<Condition> operand;
};

struct And {
  std::vector<Condition> operands; // at least two
};

struct Or {
  std::vector<Condition> operands; // at least two
};

struct Condition {
  using Node = std::variant<Compare, Inside, Not, And, Or>;
  Span span;
  int parens = 0;
  int depth = 1;
  Node node;
};

struct Case {
  Span span;  // from "|" on
  Span arrow; // "->"
  Condition condition;
  Expr value;
};

} // namespace hvi::lang::ast
