// The pass that infers dimensions. It evaluates expressions as the checker does, functions with the
// arguments of each call, so that a function has as many dimensions as it is called with; a value
// is its dimension and, for exponents, its number. Each part has a header of its own, and is given
// what it uses when it is made.
#include "lang/units/dimensions_of_statements.hpp"
#include "lang/units/signatures.hpp"
#include "lang/units/units_of_results.hpp"

namespace hvi::lang::units {

namespace {

class DimensionChecker {
public:
  DimensionChecker(const std::vector<ast::Program>& programs, const ScriptUnits& units,
                   Model& model, Diagnostics& diagnostics)
      : names_(programs, units, model, inference_),
        mistakes_(programs, units.system, names_, inference_, diagnostics),
        context_{programs, units, model, inference_, names_, mistakes_} {}

  void run() {
    DimensionsOfStatements(context_, values_).run();
    if (mistakes_.none_yet()) UnitsOfResults(context_, values_).tell_model();
  }
  std::vector<std::string> signatures() {
    run();
    return Signatures(context_, values_).all();
  }

private:
  Inference inference_;
  NamedDimensions names_;
  DimensionMistakes mistakes_;
  DimensionContext context_;
  DimensionsOfValues values_{context_};
};

} // namespace

void check_units(const std::vector<ast::Program>& programs, const ScriptUnits& units, Model& model,
                 Diagnostics& diagnostics) {
  if (units.used && !programs.empty()) DimensionChecker(programs, units, model, diagnostics).run();
}

std::vector<std::string> signatures(const std::vector<ast::Program>& programs, const Model& model) {
  CheckOptions options;
  Diagnostics none;
  Model unchanged = model;
  const ScriptUnits units = read_units(programs, options, none);
  return DimensionChecker(programs, units, unchanged, none).signatures();
}

} // namespace hvi::lang::units
