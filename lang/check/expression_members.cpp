// Members of values: `u.nu`, `sigma.xy`, `layer.xi`.
#include "lang/check/across.hpp"
#include "lang/check/expressions.hpp"
#include "lang/check/pairs.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::lang {

namespace {

/// Index 0..2 of x, y, z; nothing for other words.
std::optional<int> axis_of(const std::string& member) {
  if (member.size() != 1 || member[0] < 'x' || member[0] > 'z') return std::nullopt;
  return member[0] - 'x';
}

/// A number without components yet, of the same functions as f.
Field number_like(const Field& f) {
  Field out;
  out.test = f.test;
  out.trial = f.trial;
  out.rate = f.rate;
  out.acceleration = f.acceleration;
  out.memory = f.memory;
  out.read = f.read;
  return out;
}

} // namespace

Value Expressions::member(const ast::Expr& e, const ast::Member& m, const Scope& scope) {
  if (const auto* r = std::get_if<ast::Reference>(&m.object->node)) {
    const int index = names_.find(r->name);
    if (index >= 0 && !scope.locals.count(r->name)) {
      const ast::Statement& statement = *names_[index].statement;
      if (std::holds_alternative<ast::Superpotential>(statement)) {
        evaluator_.value_of(index, m.object->span);
        return laws_.member(m, index, scope);
      }
    }
  }
  Value object = expr(*m.object, scope);
  if (is_poison(object)) return Poison{};
  if (auto* f = std::get_if<Field>(&object)) return field_member(e, m, *f, scope);
  if (std::holds_alternative<MeshValue>(object) || std::holds_alternative<PartValue>(object)) {
    auto spec = parts_.region_path(e);
    if (!spec) return Poison{};
    mistakes_.error("E0306", e.span, "a part is used by its name", "declare it: `part p = ...`");
    return Poison{};
  }
  mistakes_.error("E0303", m.member.span,
                  fmt::format("{} has no member `{}`", describe(object), m.member.text));
  return Poison{};
}

Value Expressions::field_member(const ast::Expr&, const ast::Member& m, const Field& f,
                                const Scope& scope) {
  const std::string& name = m.member.text;
  auto no_member = [&](const std::vector<std::string>& members) -> Value {
    if (f.rank == 0 && (name == "nu" || name == "tau")) { // a space that is not one of vectors
      mistakes_.error_once("." + name + " of a scalar", "E0303", m.member.span,
                           fmt::format("{} has no member `{}`", describe(f), name),
                           "parts along a normal are those of a vector: `space V = vector P1 on "
                           "...`; a law on a scalar is `j^0(p; q)`");
      return Poison{};
    }
    const bool matrix = f.rank == 2 && !f.law_vector;
    const std::string along = name == "nu" || name == "tau"
                                  ? "; the traction on a side is `dot(sigma, normal)`, in integrals"
                                  : "";
    mistakes_.error("E0303", m.member.span, fmt::format("{} has no member `{}`", describe(f), name),
                    matrix ? fmt::format("its entries are `xx`, `xy`, `yy` and so on{}", along)
                    : members.empty() ? (f.rank == 0 && f.rows == 1 && name.size() == 1
                                             ? "products are `*`, `:` and `dot`"
                                             : "")
                                      : did_you_mean(name, members));
    return Poison{};
  };
  if (f.law_vector || f.rank == 0 || f.rank > 2) return no_member({});
  Field out = number_like(f);
  if (f.rank == 2) { // sigma.xy
    if (name.size() != 2) return no_member({"xx", "yy", "xy"});
    const auto i = axis_of(name.substr(0, 1)), j = axis_of(name.substr(1, 1));
    if (!i || !j) return no_member({"xx", "yy", "xy"});
    if (*i == 2 && *j == 2 && f.rows == 2 && f.test == Degree::none && !f.across.empty()) {
      out.components = {normal_across(f.across[0])}; // in plane strain
      return out;
    }
    if (*i >= f.rows || *j >= f.columns) {
      mistakes_.error("E0315", m.member.span,
                      fmt::format("{} has no component `{}`", describe(f), name));
      return Poison{};
    }
    out.components = {f.components[*i * f.columns + *j]};
    return out;
  }
  if (const auto i = axis_of(name)) {
    if (*i >= f.rows) {
      mistakes_.error("E0315", m.member.span,
                      fmt::format("{} has no component `{}`", describe(f), name));
      return Poison{};
    }
    out.components = {f.components[*i]};
    return out;
  }
  if (name != "nu" && name != "tau") return no_member({"nu", "tau", "x", "y", "z"});
  if (f.rows != model_.dim) return no_member({"x", "y", "z"});
  return part_along_normal(m, f, scope);
}

/// `f.nu` and `f.tau`.
Value Expressions::part_along_normal(const ast::Member& m, const Field& f, const Scope& scope) {
  const std::string& name = m.member.text;
  const bool on_pair = has_jumps(f.components.front()); // where that is, there is a normal
  const bool read = on_pair || f.read; // the part that the law acts on has one, or it is said
  if (!scope.normal && !read) {
    // One wrong part makes every `.nu` of its integral wrong: one error says it.
    if (scope.test && std::exchange(at_hand_.normal_missed, true)) return Poison{};
    mistakes_.error("E0309", m.member.span,
                    fmt::format("`.{}` cannot be used in {}: there is no normal", name, scope.what),
                    "normal and tangential parts belong to integrals over parts of the boundary");
    return Poison{};
  }
  std::vector<Symbol> n;
  Symbol along = 0.0;
  for (int i = 0; i < model_.dim; ++i) {
    n.push_back(Symbol::variable(solver::slot::normal(i)));
    along = along + f.components[i] * n[i];
  }
  Field out = number_like(f);
  if (name == "nu") {
    out.components = {along};
    return out;
  }
  out.rank = 1;
  out.rows = f.rows;
  for (int i = 0; i < model_.dim; ++i) out.components.push_back(f.components[i] - along * n[i]);
  return out;
}

} // namespace hvi::lang
