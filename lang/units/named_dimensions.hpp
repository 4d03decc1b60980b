// What is known of all that has a name in a script: of its unknowns and declarations, of the
// columns of its tables.
#pragma once

#include "lang/units/units.hpp"

#include <cstdint>
#include <map>
#include <optional>
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

/// The arguments of the function or law whose body is read.
using Locals = std::map<std::string, Measured>;

struct MeasuredDeclaration {
  const ast::Statement* statement = nullptr;
  bool library = false;
  std::optional<Measured> value = std::nullopt;
  bool busy = false;
};

inline Dimension length() { return Dimension::base(0); }
inline Dimension duration() { return Dimension::base(2); }

class NamedDimensions {
public:
  NamedDimensions(const std::vector<ast::Program>& programs, const ScriptUnits& units,
                  const Model& model, Inference& inference);

  /// Null: nothing is declared by that name.
  MeasuredDeclaration* declaration(const std::string& name);
  template <class Statement>
  const Statement* declared_as(const std::string& name) {
    const MeasuredDeclaration* found = declaration(name);
    return found ? std::get_if<Statement>(found->statement) : nullptr;
  }
  std::optional<std::size_t> unknown(const std::string& name) const;
  /// Of displacements, where there are any: the first unknown that is a vector.
  std::size_t vector_unknown() const;

  /// Of a part by its name, of the cells without one.
  Dimension measure_of(const std::string& part);
  /// Of the norm of its space: none where that adds values to gradients (SpaceNorm).
  std::optional<Dimension> norm_of_space(std::size_t unknown);
  /// What an unknown's equation is in.
  Dimension force(std::size_t unknown) const;
  std::optional<Dimension> stress();
  Dimension multiplier(const std::string& law);
  Dimension state(const std::string& name);
  /// Of a column, or of a component of it: `held_y` of the vector `held`.
  std::optional<Dimension> column(const std::string& name) const;

  const ast::Find* find = nullptr;
  Dimension of_form; ///< of every integral of the inequality
  std::vector<Dimension> of_unknown, of_test;
  std::unordered_map<std::string, MeasuredDeclaration> declarations;
  std::map<std::string, Dimension> of_state, of_multiplier, of_column;
  std::map<std::string, Dimension> of_argument;                ///< of laws
  std::map<std::string, Dimension> of_kernel;                  ///< their values
  std::map<std::pair<int, std::uint32_t>, Dimension> of_field; ///< by file and place

private:
  void declare(const std::vector<ast::Program>& programs);

  const Model& model_;
  Inference& inference_;
  std::map<std::string, Dimension> of_measure_;
};

} // namespace hvi::lang::units
