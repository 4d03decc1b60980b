#include "lang/check/declared_values.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::lang {

Value& DeclaredValues::value_of(int index, const Span& use) {
  Declaration& declaration = names_[index];
  declaration.used = true;
  if (declaration.state == Declaration::State::busy) {
    mistakes_.error("E0313", use, fmt::format("`{}` is defined by itself", declaration.name),
                    "break the circle: a value cannot depend on itself");
    declaration.value = Poison{};
    return declaration.value;
  }
  places_.note_use(index);
  if (declaration.state != Declaration::State::untouched) return declaration.value;
  auto value = limits_.of_declaration(use, [&] {
    declaration.state = Declaration::State::busy;
    const int outer = std::exchange(at_hand_.declaration, index);
    Value made = evaluate(index);
    at_hand_.declaration = outer;
    return made;
  });
  if (value) {
    declaration.value = std::move(*value);
    declaration.state = Declaration::State::done;
  }
  return declaration.value;
}

Value DeclaredValues::evaluate(int index) {
  const ast::Statement& statement = *names_[index].statement;
  if (const auto* param = std::get_if<ast::Param>(&statement)) return parameters_.value(*param);
  if (const auto* m = std::get_if<ast::Mesh>(&statement)) return meshes_.mesh(*m);
  if (const auto* part = std::get_if<ast::Part>(&statement)) {
    return parts_.part(*part);
  }
  if (const auto* tensor = std::get_if<ast::Tensor>(&statement)) {
    Scope scope;
    scope.what = "a tensor";
    scope.position = true;
    auto f = evaluator_.field(tensor->value, scope);
    if (!f) return Poison{};
    if (f->rank == 0 || f->rank == 1)
      mistakes_.error(
          "E0306", tensor->value.span,
          fmt::format("a tensor is expected here, not {}", describe(*f)),
          f->rank == 0 ? "a scalar coefficient is declared with `fn k() = ...` or `param`" : "");
    if (f->rank < 2) return Poison{};
    if (!is_constant(*f)) places_.note(tensor->value.span, *f, false);
    if (f->rank == 4) tensors_.name_tensor(*f, tensor->name);
    return *f;
  }
  if (std::holds_alternative<ast::Kernel>(statement)) return KernelValue{index};
  if (std::holds_alternative<ast::Superpotential>(statement)) return LawValue{index};
  if (std::holds_alternative<ast::State>(statement)) return states_.state(index);
  if (std::holds_alternative<ast::Fn>(statement)) return FunctionValue{index};
  if (const auto* s = std::get_if<ast::Space>(&statement)) {
    auto made = spaces_.space(*s);
    return made ? Value(SpaceValue{*made}) : Value(Poison{});
  }
  return Poison{};
}

} // namespace hvi::lang
