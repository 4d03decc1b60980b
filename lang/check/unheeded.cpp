#include "lang/check/unheeded.hpp"

#include "lang/check/builtins.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

const ast::Setting* find_setting(const ast::Find& find, std::string_view name) {
  const auto at = std::ranges::find_if(find.settings,
                                       [&](const ast::Setting& s) { return s.name.text == name; });
  return at == find.settings.end() ? nullptr : &*at;
}

/// Stands the word itself there, not a parameter that has it now?
bool is_written_out(const ast::Setting& setting) {
  const auto* word = std::get_if<ast::Reference>(&setting.value.node);
  return word != nullptr && is_word(word->name);
}

class Unheeded {
public:
  Unheeded(const ast::Find& find, const Model& model) : find_(find), model_(model) {}

  /// Why the setting changes nothing; "": it may.
  std::string why(const std::string& name) const {
    const bool of_time = name == "scheme" || name == "hht_alpha" || name == "load" ||
                         name == "interpolant" || name == "memory" || name == "memory_tolerance";
    if (of_time && !model_.has_time) return "a static problem has no steps";
    if (name == "hht_alpha") return of_another_scheme();
    if (name == "load" && !loads_change()) return "no load changes in time";
    if (name == "interpolant" && !has_times()) return "no result is asked for `at t = ...`";
    if ((name == "memory" || name == "memory_tolerance") && model_.histories.empty())
      return "the problem has no memory";
    if (name == "branch" && !has_law([](const ModelTerm&) { return true; }))
      return "no law acts: there is one branch";
    if (name == "quadrature" && !has_law([](const ModelTerm& term) { return !term.rule_given; }))
      return "it is the rule of laws that bring none, and there is none of these";
    return {};
  }

private:
  std::string of_another_scheme() const {
    if (model_.time.scheme == solver::Scheme::hht) return {};
    const ast::Setting* scheme = find_setting(find_, "scheme");
    if (scheme != nullptr && !is_written_out(*scheme)) return {};
    return fmt::format("it is of the scheme `hht`, and this one is `{}`",
                       solver::name_of(model_.time.scheme));
  }

  bool loads_change() const {
    return std::ranges::any_of(model_.terms, [](const ModelTerm& term) {
      return term.right && (term.factor * term.integrand.scalar()).depends_on(slot::t);
    });
  }

  /// What is read between two steps.
  bool has_times() const {
    return std::ranges::any_of(model_.report.probes,
                               [](const auto& p) { return p.time.has_value(); });
  }

  bool has_law(auto&& chosen) const {
    return std::ranges::any_of(model_.terms, [&](const ModelTerm& term) {
      return !term.integrand.laws.empty() && chosen(term);
    });
  }

  const ast::Find& find_;
  const Model& model_;
};

} // namespace

void tell_unheeded_settings(const ast::Find& find, const Model& model, Mistakes& mistakes) {
  const Unheeded unheeded(find, model);
  for (const ast::Setting& setting : find.settings)
    if (const std::string why = unheeded.why(setting.name.text); !why.empty())
      mistakes.add(diagnose("W0109", setting.name.span,
                            fmt::format("`{}` changes nothing: {}", setting.name.text, why))
                       .with_help("leave it out"));
}

} // namespace hvi::lang
