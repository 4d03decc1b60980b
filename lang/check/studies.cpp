#include "lang/check/studies.hpp"

#include "lang/check/builtins.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hvi::lang {

/// May the study vary it? A parameter that no ladder has yet.
bool Studies::varies(const ast::Name& name, std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name.text) != known.end()) {
    mistakes_.error("E0302", name.span, fmt::format("`{}` is varied twice", name.text));
    return false;
  }
  known.push_back(name.text);
  const int index = names_.find(name.text);
  if (index < 0 && names_.is_silent(name.text)) return false;
  if (index >= 0 && std::holds_alternative<ast::Param>(*names_[index].statement)) return true;
  std::vector<std::string> params;
  for (const ModelParam& p : model_.params) params.push_back(p.name);
  mistakes_.add_once(
      name.text,
      diagnose("E0301", name.span, fmt::format("there is no parameter `{}` to vary", name.text))
          .with_help(did_you_mean(name.text, params)));
  return false;
}

/// A value as a parameter may be given it; false: said why not.
bool Studies::study_value(const ast::Expr& item, std::vector<std::string>& out) {
  const auto* w = std::get_if<ast::Reference>(&item.node);
  if (w && is_word(w->name)) {
    out.push_back(w->name);
    return true;
  }
  const auto v = evaluator_.constant(item, "a rung of a ladder");
  if (v) out.push_back(fmt::format("{}", *v));
  return v.has_value();
}

std::optional<StudyLadder> Studies::study_ladder(const ast::Ladder& ladder,
                                                 const ModelStudy& study) {
  std::vector<std::string> known;
  for (const StudyLadder& other : study.ladders) {
    known.push_back(other.parameter);
    for (const auto& [name, values] : other.more) known.push_back(name);
  }
  bool good = varies(ladder.parameter, known);
  StudyLadder out{ladder.parameter.text, ladder.span, {}};
  for (const ast::Name& name : ladder.more) {
    good = varies(name, known) && good;
    out.more.emplace_back(name.text, std::vector<std::string>{});
  }
  if (!good) return std::nullopt;
  const auto* list = std::get_if<ast::List>(&ladder.values.node);
  if (!list) {
    mistakes_.error("E0306", ladder.values.span, "a ladder is a list `[...]`");
    return std::nullopt;
  }
  for (const ast::Expr& item : list->items) {
    if (out.more.empty()) {
      if (study_value(item, out.values)) climbs(item, out);
      continue;
    }
    const auto* rung = std::get_if<ast::List>(&item.node);
    if (!rung || rung->items.size() != out.more.size() + 1) {
      mistakes_.error("E0307", item.span,
                      fmt::format("a rung is a list of {} values, one for each parameter",
                                  out.more.size() + 1));
      return std::nullopt;
    }
    good = study_value(rung->items[0], out.values);
    for (std::size_t k = 0; k < out.more.size(); ++k)
      good = study_value(rung->items[k + 1], out.more[k].second) && good;
    if (!good || !climbs(item, out)) return std::nullopt;
  }
  return out;
}

/// False (reported at `item`) where the last rung is one of those before it.
bool Studies::climbs(const ast::Expr& item, const StudyLadder& ladder) {
  const std::size_t last = ladder.values.size() - 1;
  const auto same = [&](std::size_t rung) {
    const auto is_last = [&](const auto& values) { return values[rung] == values[last]; };
    return is_last(ladder.values) && std::ranges::all_of(ladder.more, [&](const auto& other) {
             return is_last(other.second);
           });
  };
  for (std::size_t rung = 0; rung < last; ++rung) {
    if (!same(rung)) continue;
    mistakes_.error("E0302", item.span, "this rung stands on the ladder already",
                    "each setting is run once");
    return false;
  }
  return true;
}

/// By component of all unknowns; of several: a list with a solution for each.
std::vector<Symbol> Studies::exact_solution(const ast::Expr& written) {
  const auto unknowns = unknowns_of(model_.space);
  std::vector<const ast::Expr*> given{&written};
  if (unknowns.size() > 1) {
    const auto* list = std::get_if<ast::List>(&written.node);
    if (list == nullptr || list->items.size() != unknowns.size()) {
      mistakes_.error("E0307", written.span,
                      fmt::format("the exact solution of {} unknowns is a list of {}",
                                  unknowns.size(), unknowns.size()),
                      "write `exact [U, T]`, the solutions in the order of the find statement");
      return {};
    }
    given.clear();
    for (const auto& item : list->items) given.push_back(&item);
  }
  std::vector<Symbol> out;
  for (std::size_t b = 0; b < given.size(); ++b) {
    Scope scope;
    scope.what = "an exact solution";
    scope.position = scope.time = true;
    const auto f = evaluator_.field(*given[b], scope);
    if (!f) continue;
    const int n = unknowns_.components_of(static_cast<int>(b));
    if (static_cast<int>(f->components.size()) != n)
      mistakes_.error(
          "E0307", given[b]->span,
          fmt::format("the exact solution is {}, the unknown has {} components", describe(*f), n));
    std::ranges::copy(f->components, std::back_inserter(out));
  }
  return out;
}

/// `in V`: the space of an unknown. Of several it says whose error decides.
void Studies::norm_of_study(const ast::Name& space, ModelStudy& study) {
  study.norm = space.text;
  const auto unknowns = unknowns_of(model_.space);
  for (std::size_t b = 0; b < unknowns.size() && unknowns.size() > 1; ++b)
    if (unknowns[b].space == space.text && !study.unknown) study.unknown = b;
  const bool one = unknowns.size() == 1;
  if (one ? !unknowns_.known || unknowns[0].space == space.text : study.unknown.has_value()) return;
  mistakes_.error(
      "E0306", space.span,
      fmt::format("`{}` is not the space of {} unknown", space.text, one ? "the" : "an"),
      one ? fmt::format("write `in {}`", unknowns[0].space)
          : "errors of several unknowns are those of all together, or `in V`, of one");
}

void Studies::read(const ast::Program& script) {
  for (const ast::Statement& statement : script.statements) {
    const auto* s = std::get_if<ast::Study>(&statement);
    if (!s) continue;
    ModelStudy out;
    out.span = s->span;
    for (const ast::Ladder& ladder : s->ladders)
      if (auto rungs = study_ladder(ladder, out)) out.ladders.push_back(std::move(*rungs));
    out.reference = s->reference == ast::StudyReference::finest ? ModelStudy::Reference::finest
                    : s->reference == ast::StudyReference::richardson
                        ? ModelStudy::Reference::richardson
                    : s->reference == ast::StudyReference::exact ? ModelStudy::Reference::exact
                                                                 : ModelStudy::Reference::none;
    if (s->exact) out.exact = exact_solution(*s->exact);
    if (s->norm) norm_of_study(*s->norm, out);
    if (model_.study)
      mistakes_.error("E0302", s->keyword, "a script has one study statement");
    else
      model_.study = std::move(out);
  }
}

} // namespace hvi::lang
