// The one table of what is built into the language: functions with their arguments and a line of
// documentation, words that stand for themselves, names that cannot be redefined.
#pragma once

#include "solver/kernel/expr.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

enum class BuiltInKind {
  pointwise,    ///< number -> number
  differential, ///< eps grad div
  algebraic,    ///< tr dev norm dot transpose identity
  tensor,       ///< isotropic ... prony table
  memory,       ///< history
  interface,    ///< jump, gap, pair: names that scripts may take for themselves
  region,       ///< integral, point, inside
  mesh
};

struct BuiltIn {
  std::string_view name;
  BuiltInKind kind;
  std::string_view usage; ///< "max(a, b)"
  std::string_view doc;
};

/// Every built-in function, sorted by kind, then name.
std::span<const BuiltIn> built_ins();
const BuiltIn* find_built_in(std::string_view name);

bool is_function_name(std::string_view name);
/// P1, P2, bdf2, nodal, ...: words that are values.
bool is_word(std::string_view name);
std::span<const std::string_view> words();
/// What may stand behind `using`.
std::span<const std::string_view> setting_names();
/// Functions and x y z t pi lag: cannot be declared.
bool is_reserved_builtin(std::string_view name);
/// Names for suggestions.
std::vector<std::string_view> visible_built_ins();

/// Number of arguments of a pointwise function (nothing: not a pointwise function; min and max:
/// 2+).
std::optional<int> pointwise_arity(std::string_view name);
solver::Op pointwise_op(std::string_view name);

/// A whole text as a finite number.
std::optional<double> parse_number(std::string_view text);

} // namespace hvi::lang
