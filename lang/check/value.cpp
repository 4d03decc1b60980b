// Shapes and descriptions of symbolic values.
#include "lang/check/value.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

Field scalar_field(Symbol symbol) {
  Field field;
  field.components = {std::move(symbol)};
  return field;
}

Field vector_field(std::vector<Symbol> components) {
  Field field;
  field.rank = 1;
  field.rows = static_cast<int>(components.size());
  field.components = std::move(components);
  return field;
}

Field matrix_field(int rows, int columns, std::vector<Symbol> components) {
  Field field;
  field.rank = 2;
  field.rows = rows;
  field.columns = columns;
  field.components = std::move(components);
  return field;
}

Field tensor_field(int dim, std::vector<Symbol> components) {
  Field field;
  field.rank = 4;
  field.rows = dim;
  field.columns = dim;
  field.components = std::move(components);
  return field;
}

std::string describe(const Field& field) {
  if (field.law_vector) return "the vector argument of a superpotential";
  switch (field.rank) {
  case 0:
    return "a scalar";
  case 1:
    return fmt::format("a vector of {}", field.rows);
  case 2:
    return fmt::format("a {} x {} matrix", field.rows, field.columns);
  default:
    return "a fourth-order tensor";
  }
}

std::string describe(const Value& value) {
  return std::visit(
      Overloaded{[](const Poison&) { return std::string("something wrong"); },
                 [](const Field& field) { return describe(field); },
                 [](const Word& word) { return fmt::format("the word `{}`", word.text); },
                 [](const TextValue&) { return std::string("a text"); },
                 [](const MeshValue&) { return std::string("a mesh"); },
                 [](const PartValue&) { return std::string("a part"); },
                 [](const SpaceValue&) { return std::string("a space"); },
                 [](const FunctionValue&) { return std::string("a function"); },
                 [](const KernelValue&) { return std::string("a kernel"); },
                 [](const LawValue&) { return std::string("a superpotential"); }},
      value);
}

std::string describe_with_number(const Value& value) {
  const auto* field = std::get_if<Field>(&value);
  const bool number = field && field->rank == 0 && is_constant(*field);
  return number ? fmt::format("the number {}", field->scalar().value()) : describe(value);
}

bool same_shape(const Field& a, const Field& b) {
  return a.rank == b.rank && a.rows == b.rows && a.columns == b.columns;
}

bool is_constant(const Field& field) {
  return std::all_of(field.components.begin(), field.components.end(),
                     [](const Symbol& symbol) { return symbol.is_constant(); }) &&
         field.laws.empty();
}

} // namespace hvi::lang
