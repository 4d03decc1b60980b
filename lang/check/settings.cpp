// The settings of a find statement: `with scheme = bdf2, tolerance = 1e-10`.
#include "lang/check/settings.hpp"

#include "lang/check/builtins.hpp"
#include "lang/check/inertia.hpp"
#include "lang/diag/suggest.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

void Settings::set_scheme(const ast::Setting& setting) {
  using solver::Scheme;
  const auto chosen = evaluator_.word(
      setting.value, "scheme", {"backward_euler", "euler", "bdf2", "newmark", "hht", "midpoint"});
  if (!chosen) return;
  for (const Scheme scheme :
       {Scheme::backward_euler, Scheme::bdf2, Scheme::newmark, Scheme::hht, Scheme::midpoint})
    if (*chosen == solver::name_of(scheme)) model_.time.scheme = scheme;
  if (solver::needs_inertia(model_.time.scheme) && !has_second_derivative(model_))
    mistakes_.error(
        "E0431", setting.value.span,
        fmt::format("the scheme `{}` is for problems with `{}''`", *chosen, unknowns_.name_of(0)),
        "without inertia there are `backward_euler` and `bdf2`");
}

void Settings::set_hht_alpha(const ast::Setting& setting) {
  const auto alpha = evaluator_.constant(setting.value, setting.name.text);
  if (!alpha) return;
  if (*alpha >= -1.0 / 3.0 && *alpha <= 0.0)
    model_.time.hht_alpha = *alpha;
  else
    mistakes_.error("E0408", setting.value.span, "`hht_alpha` is between -1/3 and 0");
}

/// `out` becomes what the word of the setting stands for; any other word is reported.
template <class T>
void Settings::choose(const ast::Setting& setting, const std::string& what,
                      const std::vector<std::pair<std::string, T>>& choices, T& out) {
  std::vector<std::string> words;
  for (const auto& choice : choices) words.push_back(choice.first);
  const auto chosen = evaluator_.word(setting.value, what, words);
  for (const auto& choice : choices)
    if (chosen == choice.first) out = choice.second;
}

void Settings::set_positive(const ast::Setting& setting, double& out) {
  const auto v = evaluator_.constant(setting.value, setting.name.text);
  if (v && !(*v > 0.0))
    mistakes_.error("E0408", setting.value.span,
                    fmt::format("`{}` is positive", setting.name.text));
  if (v && *v > 0.0) out = *v;
}

/// A relative error. Beyond that of which a run is certified it would say nothing.
void Settings::set_tolerance(const ast::Setting& setting, double& out) {
  constexpr double largest = 1e-2;
  double given = 0.0;
  set_positive(setting, given);
  if (given > largest)
    mistakes_.error("E0408", setting.value.span,
                    fmt::format("`{}` is a relative error of at most {}, not {}", setting.name.text,
                                largest, given),
                    fmt::format("left out, it is {}", out));
  else if (given > 0.0)
    out = given;
}

void Settings::set_threads(const ast::Setting& setting) {
  constexpr int most = 256; // as many as the command line takes
  const auto n = evaluator_.positive_integer(setting.value, setting.name.text);
  if (n && *n > most)
    mistakes_.error("E0408", setting.value.span,
                    fmt::format("`{}` are {} at most", setting.name.text, most));
  else if (n)
    model_.options.threads = *n;
}

/// The rule of all laws that bring none.
void Settings::set_quadrature(const ast::Setting& setting) {
  using solver::Rule;
  std::optional<Rule> rule;
  choose<std::optional<Rule>>(
      setting, "quadrature",
      {{"nodal", Rule::nodal}, {"midpoint", Rule::midpoint}, {"gauss", Rule::gauss}}, rule);
  for (ModelTerm& term : model_.terms)
    if (rule && !term.integrand.laws.empty() && !term.rule_given) term.rule = *rule;
}

void Settings::set_accuracy_of(const ast::Setting& setting) {
  if (const auto* r = std::get_if<ast::Reference>(&setting.value.node))
    model_.accuracy_of = r->name;
  else
    mistakes_.error("E0306", setting.value.span,
                    "`accuracy_of` is the name of a column of the table");
}

void Settings::setting(const ast::Setting& s) {
  using solver::Branch, solver::FactorEntries, solver::HistoryRoute, solver::Interpolant,
      solver::LinearSolver, solver::LoadSampling;
  const std::string& name = s.name.text;
  solver::SolverOptions& options = model_.options;
  if (name == "scheme") {
    set_scheme(s);
  } else if (name == "hht_alpha") {
    set_hht_alpha(s);
  } else if (name == "load") {
    choose(s, "load sampling",
           {{"endpoint", LoadSampling::endpoint}, {"average", LoadSampling::average}},
           model_.time.sampling);
  } else if (name == "interpolant") {
    choose(s, "interpolant", {{"affine", Interpolant::affine}, {"constant", Interpolant::constant}},
           model_.time.interpolant);
  } else if (name == "quadrature") {
    set_quadrature(s);
  } else if (name == "tolerance") {
    set_tolerance(s, options.tolerance);
  } else if (name == "memory_tolerance") {
    set_tolerance(s, options.memory_tolerance);
  } else if (name == "branch") {
    choose(s, "branch",
           {{"continuing", Branch::continuing},
            {"release", Branch::release},
            {"least_energy", Branch::least_energy}},
           options.branch);
  } else if (name == "solver") {
    choose(s, "solver",
           {{"direct", LinearSolver::direct},
            {"iterative", LinearSolver::iterative},
            {"automatic", LinearSolver::automatic}},
           options.solver);
  } else if (name == "factor") {
    choose(s, "precision of a factor",
           {{"double", FactorEntries::doubles}, {"single", FactorEntries::singles}},
           options.factor);
  } else if (name == "memory") {
    choose(s, "memory route",
           {{"automatic", HistoryRoute::automatic},
            {"recursion", HistoryRoute::recursion},
            {"fit", HistoryRoute::fit},
            {"tree", HistoryRoute::tree},
            {"direct", HistoryRoute::direct}},
           options.route);
  } else if (name == "accuracy") {
    double v = 0.0;
    set_positive(s, v);
    if (v > 0.0) model_.accuracy = v;
  } else if (name == "threads") {
    set_threads(s);
  } else {
    set_accuracy_of(s);
  }
}

void Settings::read(const ast::Find& find) {
  const auto known = setting_names();
  std::vector<std::string> seen;
  for (const ast::Setting& s : find.settings) {
    const std::string& name = s.name.text;
    if (std::ranges::find(known, name) == known.end()) {
      const std::string near = did_you_mean(name, known);
      mistakes_.error("E0316", s.name.span, fmt::format("there is no setting `{}`", name),
                      near.empty() ? fmt::format("settings: {}", solver::joined(known)) : near);
    } else if (std::ranges::find(seen, name) != seen.end()) {
      mistakes_.error("E0302", s.name.span, fmt::format("the setting `{}` is given twice", name));
    } else {
      seen.push_back(name);
      setting(s);
    }
  }
  check_accuracy_of(find);
}

/// It says of which column the accuracy is that is asked for beside it.
void Settings::check_accuracy_of(const ast::Find& find) {
  const auto given = [&](const char* name) {
    return std::ranges::find_if(find.settings,
                                [&](const ast::Setting& s) { return s.name.text == name; });
  };
  const auto of = given("accuracy_of");
  if (of == find.settings.end() || given("accuracy") != find.settings.end()) return;
  mistakes_.error("E0412", of->name.span, "`accuracy_of` without an `accuracy`: none is asked for",
                  "say how large the error of the column may be: `accuracy = 1e-3, accuracy_of = "
                  "...`");
}

} // namespace hvi::lang
