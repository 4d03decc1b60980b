#include "lang/check/find_statement.hpp"

#include "lang/check/builtins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace hvi::lang {

FindStatement::FindStatement(const Context& context, const FindParts& with)
    : mistakes_(context.mistakes), names_(context.names), model_(context.model),
      unknowns_(context.unknowns), places_(with.places), series_(with.series),
      memories_(with.memories), states_(with.states), spaces_(with.spaces),
      imposed_(context, with.groups, with.parts, with.pairs), time_(context),
      forms_(context, with.parts, with.pairs, with.states, with.sources), settings_(context),
      form_checks_(context) {}

bool FindStatement::read(const ast::Find& find) {
  spaces_.take_unknowns(find);
  // Whose names are not clear cannot be read: one mistake, not one for each use.
  const bool readable = check_names(find);
  for (const ast::Unknown& u : find.unknowns) {
    model_.unknowns.push_back(u.unknown.text);
    model_.tests.push_back(u.test.text);
  }
  if (!readable) return false;
  time_.read(find);
  if (unknowns_.known) imposed_.read(find);
  forms_.read(find);
  states_.read_rates();
  places_.place_all();
  settings_.read(find);
  series_.check_tables();
  memories_.check_kernels_in_time();
  form_checks_.check_relation(find);
  if (!mistakes_.has_errors()) {
    form_checks_.check_clauses(find);
    form_checks_.check_one_law_per_part();
    form_checks_.check_multipliers_read();
    states_.check_states_of_laws();
    form_checks_.check_symmetry();
  }
  return true;
}

bool FindStatement::check_names(const ast::Find& find) {
  bool good = true;
  std::map<std::string, const ast::Name*> seen;
  std::vector<const ast::Name*> names;
  for (const ast::Unknown& u : find.unknowns) names.push_back(&u.unknown);
  for (const ast::Unknown& u : find.unknowns) names.push_back(&u.test);
  if (find.unknowns.size() > solver::slot::most_unknowns) {
    mistakes_.error("E0443", find.unknowns[solver::slot::most_unknowns].unknown.span,
                    fmt::format("more than {} unknowns", solver::slot::most_unknowns));
    return false;
  }
  for (const ast::Name* name : names) {
    if (const auto [before, fresh] = seen.try_emplace(name->text, name); !fresh) {
      mistakes_.add(
          diagnose("E0302", name->span,
                   find.unknowns.size() == 1
                       ? std::string("the unknown and the test function have the same name")
                       : fmt::format("two of the unknowns and test functions are called `{}`",
                                     name->text))
              .with_secondary(before->second->span, "the first one"));
      good = false;
      continue;
    }
    if (is_reserved_builtin(name->text)) {
      mistakes_.error("E0311", name->span,
                      fmt::format("`{}` is built in and cannot be declared", name->text),
                      "choose another name");
      good = false;
      continue;
    }
    const int index = names_.find(name->text);
    if (index < 0) continue;
    good = false;
    mistakes_.add(diagnose("E0302", name->span, fmt::format("`{}` is declared twice", name->text))
                      .with_secondary(names_[index].span, "first declared here"));
  }
  for (const ast::Unknown& u : find.unknowns) {
    if (u.test_space.text == u.space.text) continue;
    // In another order: what each form then says of whom is no second mistake.
    const bool of_another = std::ranges::any_of(find.unknowns, [&](const ast::Unknown& other) {
      return other.space.text == u.test_space.text;
    });
    mistakes_.error("E0312", u.test_space.span,
                    fmt::format("the test functions run through `{}`, the space of the unknown{}",
                                u.space.text,
                                of_another ? fmt::format(" `{}`", u.unknown.text) : ""),
                    of_another ? "each unknown has its own, in the same order" : "");
    good = good && !of_another;
  }
  return good;
}

} // namespace hvi::lang
