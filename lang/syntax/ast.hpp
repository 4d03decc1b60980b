// The syntax tree: what stands in the script, without meaning. Made by lang/syntax/parser.hpp, read
// by lang/check. Every node knows its span; words and operators that a message may underline have
// spans of their own. Parentheses are not nodes: they are counted (`parens`) and lie in the span.
#pragma once

#include "lang/syntax/ast_expression.hpp"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace hvi::lang::ast {

// --- regions -----------------------------------------------------------------------------------

struct Region;

/// One term of a region with the sign before it.
struct RegionTerm {
  Span span;
  bool minus = false;
  Span op;                              // "+" or "-"; invalid for the first term
  std::variant<Expr, Box<Region>> term; // a path such as slab.group("roof"), or (region)
};

struct Region {
  Span span;
  std::vector<RegionTerm> terms; // at least one, the first without a sign
  std::optional<Condition> where;
};

// --- declarations ------------------------------------------------------------------------------
// `keyword` is the statement word, `span` the whole statement.

struct Import {
  Span span;
  Span keyword;
  std::variant<Name, Text> module;
};

/// units mm, N, s: what the script is computed in.
struct Units {
  Span span;
  Span keyword;
  std::vector<UnitText> units; // at least one
};

struct Param {
  Span span;
  Span keyword;
  Name name;
  Expr value;
  std::optional<Expr> range; // a List
  std::optional<Text> doc;
};

struct Mesh {
  Span span;
  Span keyword;
  Name name;
  Expr value; // a Call
};

struct Part {
  Span span;
  Span keyword;
  Name name;
  Region region;
};

struct Tensor {
  Span span;
  Span keyword;
  Name name;
  Expr value;
};

/// kernel C(lag) = ... or kernel C(t, s) = ...
struct Kernel {
  Span span;
  Span keyword;
  Name name;
  std::vector<Name> parameters; // one or two
  Expr value;
};

/// A parameter of a superpotential behind the first: mu or mu = 0.3.
struct LawParameter {
  Name name;
  std::optional<Expr> value;
};

struct Superpotential {
  Span span;
  Span keyword;
  Name name;
  Name argument;
  std::vector<LawParameter> parameters;
  bool by_slope = false; // "with slope expr" instead of "= expr"
  Expr value;
};

/// from u = value
struct InitialValue {
  Span span;
  Name unknown;
  Expr value;
  bool rate = false; // name' = value
};

/// state beta on glue with rate -beta from beta = 1 in [0, 1]
struct State {
  Span span;
  Span keyword;
  Name name;
  Name part;
  Expr rate;
  InitialValue initial;
  std::optional<Expr> range; // a List
};

struct Fn {
  Span span;
  Span keyword;
  Name name;
  std::vector<Name> parameters; // may be empty
  Expr value;
};

/// zero [.component] on part
struct ZeroCondition {
  Span span;
  std::optional<Name> component;
  Name part;
};

/// periodic [.component] first = second
struct PeriodicCondition {
  Span span;
  std::optional<Name> component;
  Name first, second; // parts
};

struct Space {
  Span span;
  Span keyword;
  Name name;
  bool vector = false;
  Span shape_word; // "scalar" or "vector"
  Name element;    // P1, P2
  Name domain;
  std::vector<ZeroCondition> zero;
  std::vector<PeriodicCondition> periodic;
};

// --- the inequality ----------------------------------------------------------------------------

/// u[.component] = value on part
struct ImposedValue {
  Span span;
  Name unknown;
  std::optional<Name> component;
  Expr value;
  Name part;
};

/// for t in [t0, T] by N steps from u = u0, u' = v0; or at [times]
struct TimeClause {
  Span span;
  Expr range;           // a List
  bool by_steps = true; // "by expr steps"; otherwise "at expr"
  Expr steps;           // the number of steps, or the times
  std::vector<InitialValue> initial;
};

/// name = value behind "using"
struct Setting {
  Span span;
  Name name;
  Expr value;
};

/// integral(domain, integrand, rule = ...)
struct Integral {
  Span span;
  Span word; // "integral"
  Name domain;
  Expr integrand;
  std::vector<Setting> options;
};

/// [sign] { factor * } integral(...), or [sign] 0
struct FormTerm {
  Span span; // without the sign
  bool minus = false;
  Span sign; // "+" or "-"; invalid when the first term has none
  std::vector<Expr> factors;
  std::optional<Integral> integral; // empty: the term is the literal 0
};

struct Form {
  Span span;
  std::vector<FormTerm> terms; // at least one
};

/// unknown [unit] in space ..., for all test in test_space
struct Unknown {
  Name unknown;
  std::optional<UnitText> unit;
  Name space;
  Name test;
  Name test_space;
};

struct Find {
  Span span;
  Span keyword;
  std::vector<Unknown> unknowns; // at least one
  Span with_word;                // of the imposed values; invalid when there are none
  std::vector<ImposedValue> imposed;
  std::optional<TimeClause> time;
  Span using_word; // of the settings; invalid when there are none
  std::vector<Setting> settings;
  Span such_that;
  Form left;
  bool inequality = true; // ">="; otherwise "="
  Span relation;          // the sign itself
  Form right;
};

// --- results -----------------------------------------------------------------------------------

/// name = value [at point] [at t = time]
struct Binding {
  Span span;
  Name name;
  Expr value;
  std::optional<Expr> point; // a List
  std::optional<Name> side;  // a part of cells: the point is one of these
  std::optional<Expr> time;
};

struct TableItem {
  Span span;
  Span keyword;
  std::vector<Binding> columns;
  std::optional<Expr> every; // steps
  Span from_start;           // invalid: not from the start
  std::optional<Text> to;
};

struct FieldsItem {
  Span span;
  Span keyword;
  std::vector<Expr> fields;
  std::optional<Expr> every; // steps
  Span from_start;           // invalid: not from the start
  std::optional<Text> to;
};

/// picture field [deformed = factor] [at t = time]; or of laws and kernels, one beside the other
struct PictureItem {
  Span span;
  Span keyword;
  Expr field;
  std::vector<Expr> more; // further ones
  std::optional<Expr> deformed;
  std::optional<Expr> time;
  std::optional<Text> to;
};

/// line expr, ... from point to point by n points [at t = time]
struct LineItem {
  Span span;
  Span keyword;
  std::vector<Expr> fields;
  Expr from, end; // Lists
  Expr points;    // how many
  std::optional<Expr> time;
  std::optional<Text> to;
};

/// plot column, ... against column
struct PlotItem {
  Span span;
  Span keyword;
  std::vector<Name> columns;
  Name against;
  std::optional<Text> to;
};

using ReportItem = std::variant<TableItem, FieldsItem, PictureItem, LineItem, PlotItem>;

struct Report {
  Span span;
  Span keyword;
  std::vector<ReportItem> items;
};

/// expect probe [at t = time] = value within tolerance [relative] [when condition] ["source"]
struct Expect {
  Span span;
  Span keyword;
  Name probe;
  std::optional<Expr> time;
  Expr value;
  Expr tolerance;
  bool relative = false;
  std::optional<Condition> when;
  std::optional<Text> source;
};

/// name in [values], or names in [[values of a rung], ...]
struct Ladder {
  Span span;
  Name parameter;
  std::vector<Name> more; // climb together with the first
  Expr values;            // a List
};

enum class StudyReference { finest, richardson, exact, none };

struct Study {
  Span span;
  Span keyword;
  std::vector<Ladder> ladders;
  Span against_word; // invalid without a reference
  StudyReference reference = StudyReference::finest;
  Span reference_word;
  std::optional<Expr> exact; // present for StudyReference::exact
  std::optional<Name> norm;
};

using Statement = std::variant<Import, Units, Param, Mesh, Part, Tensor, Kernel, Superpotential,
                               State, Fn, Space, Find, Report, Expect, Study>;

/// One file. A statement with a syntax error is left out (its declared name is in `broken`, so that
/// later phases do not call it unknown).
struct Program {
  int file = no_file;
  std::size_t size = 0; // of the text, in bytes
  std::vector<Statement> statements;
  std::vector<Name> broken;
  std::vector<UnitText> units; // all that stand in it
  bool library = false;    // a module of the standard library: the script's names win over its own
  bool names_lost = false; // an unknown name may be one of a module or line not read
};

} // namespace hvi::lang::ast
