// A script on its way through the pipeline: what each phase has made of it.
#pragma once

#include "lang/check/model.hpp"
#include "lang/diag/diagnostic.hpp"
#include "lang/diag/source.hpp"
#include "lang/syntax/ast.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/result_json.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// Each stage is kept, so that it can be dumped.
struct Script {
  std::string path;
  std::optional<std::string> text; ///< instead of what the file holds
  SourceMap sources;
  Diagnostics diagnostics;
  std::vector<ast::Program> programs; ///< [0] is the script, then its imports
  std::optional<Model> model;
  std::optional<solver::Plan> plan;
};

/// Reads and parses the script and what it imports.
void parse_script(Script& script);

/// The place of an origin in the script; invalid: none.
Span span_of(const Script& script, solver::Origin origin);
/// Line (from 1) of an origin in the script's own file; 0 when it lies elsewhere.
int line_of(const Script& script, solver::Origin origin);
/// Of t, columns, unknowns, sigma, states and parameters by their names, as far as the script
/// tells.
/// Where a parameter and a column have one name, that of the parameter.
solver::UnitsByName units_told(const Script& script);
/// The same apart: of "params", "variables" (t, unknowns, sigma, states) and "columns".
std::map<std::string, solver::UnitsByName> units_by_kind(const Script& script);
/// Parameters and lines for the JSON of a script, which must outlive it.
solver::ResultContext json_context(const Script& script);

} // namespace hvi::lang
