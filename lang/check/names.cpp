#include "lang/check/names.hpp"

#include "lang/check/builtins.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/syntax/token.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <utility>

namespace hvi::lang {

namespace {

/// The declared name of a statement; find, report, expect, study and import declare none.
const ast::Name* declared_name(const ast::Statement& statement) {
  return std::visit(
      [](const auto& s) -> const ast::Name* {
        using T = std::decay_t<decltype(s)>;
        if constexpr (std::is_same_v<T, ast::Param> || std::is_same_v<T, ast::Mesh> ||
                      std::is_same_v<T, ast::Part> || std::is_same_v<T, ast::Tensor> ||
                      std::is_same_v<T, ast::Kernel> || std::is_same_v<T, ast::Superpotential> ||
                      std::is_same_v<T, ast::State> || std::is_same_v<T, ast::Fn> ||
                      std::is_same_v<T, ast::Space>)
          return &s.name;
        else
          return nullptr;
      },
      statement);
}

/// The names in parentheses behind the declared one.
std::vector<const ast::Name*> argument_names(const ast::Statement& statement) {
  std::vector<const ast::Name*> names;
  if (const auto* fn = std::get_if<ast::Fn>(&statement))
    for (const ast::Name& name : fn->parameters) names.push_back(&name);
  if (const auto* kernel = std::get_if<ast::Kernel>(&statement))
    for (const ast::Name& name : kernel->parameters) names.push_back(&name);
  if (const auto* law = std::get_if<ast::Superpotential>(&statement)) {
    names.push_back(&law->argument);
    for (const ast::LawParameter& parameter : law->parameters) names.push_back(&parameter.name);
  }
  return names;
}

} // namespace

void Names::declare(const ast::Name& name, int program, const ast::Statement& statement) {
  if (is_reserved_builtin(name.text)) {
    mistakes_.error("E0311", name.span,
                    fmt::format("`{}` is built in and cannot be declared", name.text),
                    "choose another name");
    silenced_.insert(name.text);
    return;
  }
  auto found = by_name_.find(name.text);
  if (found != by_name_.end()) {
    const Declaration& first = declarations_[found->second];
    if (programs_[static_cast<std::size_t>(program)].library && first.program == 0) return;
    mistakes_.add(diagnose("E0302", name.span, fmt::format("`{}` is declared twice", name.text))
                      .with_secondary(first.span, "first declared here")
                      .with_help("every name is declared once; reading order does not matter"));
    return;
  }
  by_name_[name.text] = static_cast<int>(declarations_.size());
  Declaration declaration;
  declaration.name = name.text;
  declaration.span = name.span;
  declaration.program = program;
  declaration.statement = &statement;
  declarations_.push_back(std::move(declaration));
}

/// False (reported) when two arguments of a function, kernel or superpotential share a name.
bool Names::arguments_differ(const ast::Statement& statement) {
  const auto names = argument_names(statement);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (names[i]->text != names[k]->text) continue;
      mistakes_.add(diagnose("E0302", names[i]->span,
                             fmt::format("the argument `{}` is declared twice", names[i]->text))
                        .with_secondary(names[k]->span, "first declared here"));
      return false;
    }
  return true;
}

void Names::collect() {
  for (std::size_t p = 0; p < programs_.size(); ++p) {
    for (const ast::Name& broken : programs_[p].broken) silenced_.insert(broken.text);
    for (const ast::Statement& statement : programs_[p].statements)
      if (const ast::Name* name = declared_name(statement))
        arguments_differ(statement) ? declare(*name, static_cast<int>(p), statement)
                                    : void(silenced_.insert(name->text));
  }
}

int Names::find(const std::string& name) const {
  auto found = by_name_.find(name);
  return found == by_name_.end() ? -1 : found->second;
}

bool Names::is_silent(const std::string& name) const {
  const bool foreign = std::any_of(name.begin(), name.end(),
                                   [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
  return foreign || reserved_word(name) || silenced_.count(name) > 0; // told by the parser
}

Value Names::report_unknown(const Span& span, const std::string& name, const Scope& scope) {
  if (is_silent(name)) return Poison{};
  const std::string near = nearest(name, scope);
  const bool may_be_imported =
      std::any_of(programs_.begin(), programs_.end(), [](const auto& p) { return p.names_lost; });
  if (near.empty() && may_be_imported) return Poison{};
  mistakes_.add_once(
      name, diagnose("E0301", span, fmt::format("unknown name `{}`", name)).with_help(near));
  return Poison{};
}

/// Which name may be meant; looked for once, and for so many names only: each is held against all
/// that there are.
std::string Names::nearest(const std::string& name, const Scope& scope) {
  constexpr std::size_t most_names = 100;
  const auto [known, fresh] = nearest_.try_emplace(name);
  if (!fresh || nearest_.size() > most_names) return known->second;
  Suggestion suggestion(name);
  for (const auto& [local, value] : scope.locals) suggestion.consider(local);
  for (const Declaration& d : declarations_) suggestion.consider(d.name);
  for (const std::string_view built_in : visible_built_ins()) suggestion.consider(built_in);
  if (scope.unknown && find_)
    for (const ast::Unknown& u : find_->unknowns) suggestion.consider(u.unknown.text);
  if (scope.test && find_)
    for (const ast::Unknown& u : find_->unknowns) suggestion.consider(u.test.text);
  return known->second = suggestion.help();
}

} // namespace hvi::lang
