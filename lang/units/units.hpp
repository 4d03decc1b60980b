// Units of a script: read before it is checked, their dimensions checked behind that. A script
// without any is left as it is.
#pragma once

#include "lang/check/check.hpp"
#include "lang/units/system.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang::units {

/// The units that stand in a script and its files.
struct ScriptUnits {
  bool used = false; ///< does any stand there?
  System system;
  std::map<std::string, Unit> read;            ///< by their texts
  std::map<std::string, Dimension> of_defines; ///< parameters that are set with a unit
};

/// Reads them, says what is wrong with them, and gives the checker the factors. Values of
/// parameters that are set from outside become numbers in the units of the script: a bare one is in
/// the unit in which the parameter is declared.
ScriptUnits read_units(const std::vector<ast::Program>& programs, CheckOptions& options,
                       Diagnostics& diagnostics);

/// Infers the dimension of all that a checked script computes and says where two do not fit. The
/// model learns the units of its results.
void check_units(const std::vector<ast::Program>& programs, const ScriptUnits& units, Model& model,
                 Diagnostics& diagnostics);

/// `ramp(a [a], length [a]) [1]`: in which dimensions the functions and laws of a checked script
/// and of what it imports may be called, and what they give; dimensions by the names of arguments.
std::vector<std::string> signatures(const std::vector<ast::Program>& programs, const Model& model);

/// "a pressure", "a length"; nothing where a dimension has no word.
std::string in_words(const Dimension& dimension);

} // namespace hvi::lang::units
