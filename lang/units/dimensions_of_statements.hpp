// Dimensions of statements: each has places whose dimension is known.
#pragma once

#include "lang/units/dimensions_of_values.hpp"

#include <optional>
#include <string>

namespace hvi::lang::units {

class DimensionsOfStatements {
public:
  DimensionsOfStatements(const DimensionContext& context, DimensionsOfValues& values)
      : programs_(context.programs), units_(context.units), model_(context.model),
        inference_(context.inference), names_(context.names), mistakes_(context.mistakes),
        values_(values) {}
  void run();

private:
  void declarations();
  void mesh(const ast::Expr& e);
  void mesh_argument(const std::string& name, const ast::Expr& e);
  void region(const ast::Region& r);
  void param(const ast::Param& p);
  void state(const ast::State& s);
  void find(const ast::Find& f);
  void time(const ast::TimeClause& clause);
  void setting(const ast::Setting& s);
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

  /// A value, or each of a list of them.
  bool wants_each(const ast::Expr& e, const Dimension& dimension, const std::string& what);
  void wants_number(const ast::Expr& e, const std::string& what);

  const std::vector<ast::Program>& programs_;
  const ScriptUnits& units_;
  Model& model_;
  Inference& inference_;
  NamedDimensions& names_;
  DimensionMistakes& mistakes_;
  DimensionsOfValues& values_;
};

} // namespace hvi::lang::units
