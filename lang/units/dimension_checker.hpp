// The pass that infers dimensions. It evaluates expressions as the checker does, functions with the
// arguments of each call, so that a function has as many dimensions as it is called with; a value
// is its dimension and, for exponents, its number. One class over several files.
#pragma once

#include "lang/units/units.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace hvi::lang::units {

/// What is known of a value: nothing of one that is no quantity or was reported before.
struct Measured {
  std::optional<Dimension> dimension;
  std::optional<double> number; ///< where it is a constant
};

class DimensionChecker {
public:
  DimensionChecker(const std::vector<ast::Program>& programs, const ScriptUnits& units,
                   Model& model, Diagnostics& diagnostics);
  void run();
  /// Of every function and law, also of those that nobody calls.
  std::vector<std::string> signatures();

private:
  using Locals = std::map<std::string, Measured>;
  struct Named {
    const ast::Statement* statement = nullptr;
    bool library = false;
    std::optional<Measured> value = std::nullopt;
    bool busy = false;
  };
  /// A quantity with the place where it stands, for messages.
  struct Side {
    const Measured* value;
    const ast::Expr* place;
  };

  // --- values (dimensions_of_values.cpp)
  Measured value(const ast::Expr& e, const Locals& locals);
  Measured value_of_node(const ast::Expr& e, const Locals& locals);
  Measured literal(double number);
  Measured quantity(const ast::Quantity& q, const Locals& locals);
  Measured reference(const std::string& name, const Locals& locals);
  Measured declared(Named& named);
  Measured built_in_name(const std::string& name);
  Measured list(const ast::List& l, const Locals& locals);
  Measured binary(const ast::Binary& b, const Locals& locals);
  Measured power(const ast::Binary& b, const Measured& base, const Measured& exponent);
  Measured member(const ast::Member& m, const Locals& locals);
  Measured cases(const ast::Cases& c, const Locals& locals);
  void condition(const ast::Condition& c, const Locals& locals);
  Measured clarke(const ast::Clarke& c, const Locals& locals);
  Dimension potential(const ast::Superpotential& law, const Measured& argument, Locals parameters);

  // --- calls (dimensions_of_calls.cpp)
  using Arguments = std::vector<const ast::Expr*>;
  Measured call(const ast::Expr& e, const ast::Call& c, const Locals& locals);
  Measured call_declared(const ast::Expr& e, const ast::Call& c, Named& named,
                         const Locals& locals);
  Measured call_law(const ast::Call& c, const ast::Superpotential& law, const Locals& locals);
  Measured call_built_in(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured pointwise(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured material(const ast::Call& c, const Locals& locals);
  Measured series(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured history(const ast::Call& c, const Locals& locals);
  Measured over_region(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured all_same(const ast::Call& c, const Locals& locals);
  static Arguments matched(const ast::Call& c, const std::vector<std::string>& names);

  // --- statements (dimensions_of_statements.cpp)
  void declarations();
  void mesh(const ast::Expr& e);
  void region(const ast::Region& r);
  void param(const ast::Param& p);
  void state(const ast::State& s);
  void find(const ast::Find& f);
  void time(const ast::TimeClause& clause);
  /// An integral of the inequality.
  struct Term {
    const ast::Integral* integral = nullptr;
    Dimension dimension;
  };
  void forms(const ast::Find& f);
  std::optional<Dimension> of_term(const ast::FormTerm& term);
  void tell_misfit(const Term& wrong, const Term& other, const char* others);
  void report(const ast::Report& r);
  void field(const ast::Expr& e);
  void table(const ast::TableItem& item);
  void line(const ast::LineItem& item);
  void expect(const ast::Expect& e);
  void study(const ast::Study& s);
  void rungs(const ast::Ladder& ladder);

  // --- what is wrong (dimension_mistakes.cpp)
  bool same(Side left, Side right, const std::string& what);
  /// Has to be of this dimension; `what` it is, "a length of a mesh".
  bool wants(Side given, const Dimension& dimension, const std::string& what);
  bool wants_each(const ast::Expr& list, const Dimension& dimension, const std::string& what);
  bool wants_number(const ast::Expr& e, const Measured& given, const std::string& what);
  void report_mistake(Diagnostic diagnostic);
  std::string shown(const Dimension& dimension) const;
  std::string shown_with_words(const Dimension& dimension) const;
  std::string help_for_bare(Side given, const Dimension& wanted) const;
  bool is_bare(Side given) const;

  // --- functions in general (signatures.cpp)
  using Signature = std::vector<std::pair<std::string, Dimension>>;
  std::string signature(const ast::Fn& fn);
  std::string signature(const ast::Superpotential& law);
  void settle_powers();
  std::string shown_by(const Signature& names, const Dimension& dimension) const;

  // --- what the model learns (dimensions_of_results.cpp)
  void tell_model();
  std::optional<Dimension> of_column(const std::string& name) const;
  std::optional<Dimension> of_energy() const;
  void tell_report();
  void tell_params();
  void tell_ladders();

  Dimension resolved(const Dimension& d) const { return inference_.resolved(d); }
  Dimension length() const { return Dimension::base(0); }
  Dimension duration() const { return Dimension::base(2); }
  Dimension measure_of(const std::string& part);
  Dimension force(std::size_t unknown) const;
  std::optional<std::size_t> unknown_named(const std::string& name) const;
  std::string unit_of(const Dimension& dimension) const;

  const std::vector<ast::Program>& programs_;
  const ScriptUnits& units_;
  Model& model_;
  Diagnostics& diagnostics_;
  Inference inference_;
  std::unordered_map<std::string, Named> named_;
  const ast::Find* find_ = nullptr;
  std::vector<Dimension> of_unknown_, of_test_;
  Dimension of_form_; ///< of every integral of the inequality
  std::map<std::string, Dimension> of_state_, of_multiplier_, of_measure_, of_column_;
  std::map<std::string, Dimension> of_argument_;                ///< of laws
  std::map<std::string, Dimension> of_kernel_;                  ///< their values
  std::map<std::pair<int, std::uint32_t>, Dimension> of_field_; ///< by file and place
  std::vector<Span> calls_; ///< of functions and laws whose bodies are read
  std::set<int> library_;   ///< files of the standard library
  long evaluations_ = 0;
  bool reads_law_ = false; ///< the body of a law
  bool general_ = false;   ///< no call: an argument may become any number
  std::vector<std::pair<Dimension, Dimension>> powers_; ///< then: bases and what they give
};

} // namespace hvi::lang::units
