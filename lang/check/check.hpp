// Second phase: from syntax trees to the typed model. All mistakes of a script are reported at
// once, none twice; consequences of a mistake are not reported.
#pragma once

#include "lang/check/model.hpp"
#include "lang/diag/diagnostic.hpp"
#include "lang/diag/words.hpp"
#include "lang/syntax/ast.hpp"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// What a declared name turned out to be, whether the script has mistakes or not: for editors.
struct NameFacts {
  Span name;
  std::string what;                ///< "a fourth-order tensor", "the number 0.3"
  std::vector<std::string> groups; ///< of a mesh
};

/// One unit as a number in the units that a script is computed in, times/over: two numbers, so that
/// 5 [mm] in metres is 5/1000, which rounds like 0.005.
struct UnitFactor {
  double times = 1, over = 1;
};

struct CheckOptions {
  std::map<std::string, std::string> defines; ///< parameter -> value
  std::string folder = ".";                   ///< of the script: what it may read lies below
  std::string title; ///< what names of files begin with that it does not give
  bool allow_geo = false;
  Words words;
  std::map<std::string, UnitFactor> units; ///< by the text that stands in the script
  std::function<void(const NameFacts&)> on_name = nullptr; ///< called for each at the end
};

/// Checks a script with its imports; programs[0] is the script itself. Nothing when it has errors.
std::optional<Model> check(const std::vector<ast::Program>& programs, const CheckOptions& options,
                           Diagnostics& diagnostics);

} // namespace hvi::lang
