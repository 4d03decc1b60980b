#include "lang/units/dimensions_of_statements.hpp"

#include "lang/check/meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::lang::units {

bool DimensionsOfStatements::wants_each(const ast::Expr& e, const Dimension& dimension,
                                        const std::string& what) {
  const auto* list = std::get_if<ast::List>(&e.node);
  if (list == nullptr) {
    const Measured given = values_.value(e, {});
    return mistakes_.wants({&given, &e}, dimension, what);
  }
  for (const ast::Expr& item : list->items)
    if (!wants_each(item, dimension, what)) return false;
  return true;
}

/// Counts, ratios, tolerances: a number, or each of a list of them.
void DimensionsOfStatements::wants_number(const ast::Expr& e, const std::string& what) {
  if (const auto* list = std::get_if<ast::List>(&e.node))
    for (const ast::Expr& item : list->items) wants_number(item, what);
  else
    mistakes_.wants_number(e, values_.value(e, {}), what);
}

void DimensionsOfStatements::run() {
  declarations();
  if (names_.find != nullptr) find(*names_.find);
  for (const ast::Statement& statement : programs_.front().statements) {
    if (const auto* s = std::get_if<ast::State>(&statement)) state(*s);
    if (const auto* r = std::get_if<ast::Report>(&statement)) report(*r);
  }
  for (const ast::Statement& statement : programs_.front().statements) {
    if (const auto* e = std::get_if<ast::Expect>(&statement)) expect(*e);
    if (const auto* s = std::get_if<ast::Study>(&statement)) study(*s);
  }
}

void DimensionsOfStatements::declarations() {
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      if (const auto* p = std::get_if<ast::Param>(&statement); p && !program.library) param(*p);
      if (const auto* m = std::get_if<ast::Mesh>(&statement); m && !program.library) mesh(m->value);
      if (const auto* part = std::get_if<ast::Part>(&statement)) region(part->region);
      if (const auto* t = std::get_if<ast::Tensor>(&statement))
        if (auto* own = names_.declaration(t->name.text); own->statement == &statement)
          values_.declared(*own);
    }
}

void DimensionsOfStatements::param(const ast::Param& p) {
  const Measured own = values_.declared(*names_.declaration(p.name.text));
  if (!own.dimension) return;
  if (const auto set = units_.of_defines.find(p.name.text);
      set != units_.of_defines.end() && !inference_.unify(*own.dimension, set->second))
    mistakes_.report(diagnose("E0331", p.value.span,
                              fmt::format("`{}` is declared in {} and set in {}", p.name.text,
                                          mistakes_.shown_with_words(*own.dimension),
                                          mistakes_.shown_with_words(set->second))));
  if (p.range) wants_each(*p.range, *own.dimension, fmt::format("the range of `{}`", p.name.text));
}

void DimensionsOfStatements::mesh(const ast::Expr& e) {
  if (const auto* sum = std::get_if<ast::Binary>(&e.node)) {
    mesh(*sum->left), mesh(*sum->right);
    return;
  }
  const auto* c = std::get_if<ast::Call>(&e.node);
  const auto* callee = c ? std::get_if<ast::Reference>(&c->callee->node) : nullptr;
  if (callee == nullptr) return;
  const auto names = mesh_arguments(callee->name);
  std::size_t next = 0;
  for (const ast::Argument& a : c->arguments) {
    const std::size_t at =
        a.name ? static_cast<std::size_t>(std::ranges::find(names, a.name->text) - names.begin())
               : next++;
    // Constants of a geometry file have names of their own, and may be anything.
    if (at < names.size()) mesh_argument(names[at], a.value);
  }
}

void DimensionsOfStatements::mesh_argument(const std::string& name, const ast::Expr& e) {
  constexpr std::array words{"pattern", "axisymmetric", "file", "split"};
  constexpr std::array<std::pair<std::string_view, const char*>, 4> numbers{
      {{"cells", "the number of cells"},
       {"adapted", "the number of cells"},
       {"refinements", "the number of refinements"},
       {"grading", "the grading of a mesh"}}};
  if (std::ranges::find(words, name) != words.end()) return;
  for (const auto& [number, what] : numbers)
    if (name == number) return wants_number(e, what);
  wants_each(e, length(), "a length of a mesh");
}

void DimensionsOfStatements::region(const ast::Region& r) {
  for (const ast::RegionTerm& term : r.terms) {
    if (const auto* inner = std::get_if<Box<ast::Region>>(&term.term)) region(**inner);
    const auto* e = std::get_if<ast::Expr>(&term.term);
    const auto* c = e ? std::get_if<ast::Call>(&e->node) : nullptr;
    for (std::size_t i = 0; c != nullptr && i < c->arguments.size(); ++i) {
      const ast::Argument& a = c->arguments[i];
      const bool point = !a.name && std::holds_alternative<ast::List>(a.value.node);
      if (point) wants_each(a.value, length(), "the coordinates of a point");
      if (a.name && a.name->text == "reach") wants_each(a.value, length(), "the reach of a pair");
    }
  }
  if (r.where) values_.condition(*r.where, {});
}

void DimensionsOfStatements::state(const ast::State& s) {
  MeasuredDeclaration* found = names_.declaration(s.name.text);
  if (found == nullptr) return;
  const Measured own = values_.declared(*found);
  if (!own.dimension) return;
  const std::string what = fmt::format("the state `{}`", s.name.text);
  wants_each(s.initial.value, *own.dimension, what);
  const Measured rate = values_.value(s.rate, {});
  if (rate.dimension)
    mistakes_.wants({&rate, &s.rate}, *own.dimension / duration(),
                    fmt::format("the rate of the state `{}`", s.name.text));
  if (s.range) wants_each(*s.range, *own.dimension, what);
}

void DimensionsOfStatements::find(const ast::Find& f) {
  const auto of = [&](const ast::Name& unknown) {
    const auto b = names_.unknown(unknown.text);
    return b ? names_.of_unknown[*b] : inference_.fresh();
  };
  for (const ast::ImposedValue& imposed : f.imposed)
    wants_each(imposed.value, of(imposed.unknown),
               fmt::format("the value of `{}`", imposed.unknown.text));
  for (const ast::Setting& s : f.settings) setting(s);
  if (f.time) {
    time(*f.time);
    for (const ast::InitialValue& initial : f.time->initial) {
      const auto* word = std::get_if<ast::Reference>(&initial.value.node);
      if (word != nullptr && word->name == "static") continue;
      const Dimension own = of(initial.unknown);
      wants_each(initial.value, initial.rate ? own / duration() : own,
                 fmt::format("the initial {} of `{}`", initial.rate ? "rate" : "value",
                             initial.unknown.text));
    }
  }
  forms(f);
}

void DimensionsOfStatements::time(const ast::TimeClause& clause) {
  wants_each(clause.range, duration(), "the time");
  if (clause.by_steps) return wants_number(clause.steps, "the number of steps");
  const auto* graded = std::get_if<ast::Call>(&clause.steps.node); // graded(N, power)
  if (graded == nullptr) return void(wants_each(clause.steps, duration(), "the time"));
  for (const ast::Argument& a : graded->arguments) wants_number(a.value, "an argument of `graded`");
}

/// The words among them have no unit.
void DimensionsOfStatements::setting(const ast::Setting& s) {
  constexpr std::array numbers{"hht_alpha", "tolerance", "memory_tolerance", "accuracy", "threads"};
  if (std::ranges::find(numbers, s.name.text) != numbers.end())
    wants_number(s.value, fmt::format("the setting `{}`", s.name.text));
}

/// All integrals of an inequality are of one dimension: that of a force times the test function.
/// Where most do not fit the first, it is the first that is wrong.
void DimensionsOfStatements::forms(const ast::Find& f) {
  std::vector<Term> fit, misfits;
  for (const ast::Form* form : {&f.left, &f.right})
    for (const ast::FormTerm& term : form->terms) {
      if (!term.integral) continue;
      const auto own = of_term(term);
      if (!own) continue;
      (inference_.unify(*own, names_.of_form) ? fit : misfits).push_back({&*term.integral, *own});
    }
  if (misfits.empty() || fit.empty()) return;
  if (fit.size() == 1 && misfits.size() > 1)
    tell_misfit(fit.front(), misfits.front(), "those behind it are");
  else
    for (const Term& wrong : misfits) tell_misfit(wrong, fit.front(), "those before it are");
}

std::optional<Dimension> DimensionsOfStatements::of_term(const ast::FormTerm& term) {
  Dimension own = names_.measure_of(term.integral->domain.text);
  bool known = true;
  const auto times = [&](const ast::Expr& e) {
    const Measured factor = values_.value(e, {});
    known = known && factor.dimension;
    if (known) own = own * *factor.dimension;
  };
  for (const ast::Expr& factor : term.factors) times(factor);
  times(term.integral->integrand);
  return known ? std::optional(own) : std::nullopt;
}

void DimensionsOfStatements::tell_misfit(const Term& wrong, const Term& other, const char* others) {
  Diagnostic out =
      diagnose("E0331", wrong.integral->integrand.span,
               fmt::format("this integral is {}, and {} {}", mistakes_.shown(wrong.dimension),
                           others, mistakes_.shown(other.dimension)))
          .with_secondary(other.integral->span, "one of them")
          .with_help(
              fmt::format("over cells loads are N/m^3, over boundaries N/m^2, beside stresses in "
                          "Pa{}",
                          model_.dim == 2 && !model_.mesh.axisymmetric
                              ? "; in 2D all is for one unit of thickness"
                              : ""));
  const auto unknowns = solver::unknowns_of(model_.space);
  for (std::size_t b = 0; b < unknowns.size(); ++b)
    if (unknowns[b].vector && !names_.find->unknowns[b].unit)
      out.notes.push_back(fmt::format(
          "a vector is a displacement unless its unit is declared: `find {} [m/s] in {}`",
          names_.find->unknowns[b].unknown.text, names_.find->unknowns[b].space.text));
  mistakes_.report(std::move(out));
}

void DimensionsOfStatements::report(const ast::Report& r) {
  const auto at_time = [&](const std::optional<ast::Expr>& t) {
    if (t) wants_each(*t, duration(), "the time");
  };
  const auto every = [&](const std::optional<ast::Expr>& steps) {
    if (steps) wants_number(*steps, "the number of steps behind `every`");
  };
  for (const ast::ReportItem& item : r.items)
    std::visit(Overloaded{[&](const ast::TableItem& one) {
                            table(one);
                            every(one.every);
                          },
                          [&](const ast::FieldsItem& one) {
                            for (const ast::Expr& e : one.fields) field(e);
                            every(one.every);
                          },
                          [&](const ast::PictureItem& one) {
                            field(one.field);
                            for (const ast::Expr& e : one.more) field(e);
                            const auto* times =
                                one.time ? std::get_if<ast::List>(&one.time->node) : nullptr;
                            if (times == nullptr) at_time(one.time);
                            for (std::size_t i = 0; times && i < times->items.size(); ++i)
                              wants_each(times->items[i], duration(), "the time");
                            if (one.deformed)
                              wants_number(*one.deformed, "the factor of a deformed picture");
                          },
                          [&](const ast::LineItem& one) {
                            line(one);
                            at_time(one.time);
                          },
                          [&](const ast::PlotItem&) {}},
               item);
}

void DimensionsOfStatements::field(const ast::Expr& e) {
  const Measured of = values_.value(e, {});
  if (of.dimension) names_.of_field[{e.span.file, e.span.begin}] = *of.dimension;
}

void DimensionsOfStatements::table(const ast::TableItem& item) {
  for (const ast::Binding& b : item.columns) {
    const auto* c = std::get_if<ast::Call>(&b.value.node);
    const auto* callee = c ? std::get_if<ast::Reference>(&c->callee->node) : nullptr;
    // norm(u) alone is the norm of V: not a pointwise quantity.
    const auto* of = callee && callee->name == "norm" && !b.point && c->arguments.size() == 1
                         ? std::get_if<ast::Reference>(&c->arguments[0].value.node)
                         : nullptr;
    const auto unknown = of != nullptr ? names_.unknown(of->name) : std::nullopt;
    const Measured now = values_.value(b.value, {});
    const auto dimension = unknown ? names_.norm_of_space(*unknown) : now.dimension;
    if (now.dimension && dimension) names_.of_column[b.name.text] = *dimension;
    if (b.point) wants_each(*b.point, length(), "the coordinates of a point");
    if (b.time) wants_each(*b.time, duration(), "the time");
  }
}

void DimensionsOfStatements::line(const ast::LineItem& item) {
  for (const ast::Expr& e : item.fields) field(e);
  wants_each(item.from, length(), "the coordinates of a point");
  wants_each(item.end, length(), "the coordinates of a point");
  wants_number(item.points, "the number of points");
}

void DimensionsOfStatements::expect(const ast::Expect& e) {
  if (e.time) wants_each(*e.time, duration(), "the time");
  if (e.when) values_.condition(*e.when, {});
  if (e.relative) wants_number(e.tolerance, "a relative tolerance");
  const auto column = names_.column(e.probe.text);
  if (!column) return;
  wants_each(e.value, *column, fmt::format("the column `{}`", e.probe.text));
  if (!e.relative)
    wants_each(e.tolerance, *column, fmt::format("the tolerance of `{}`", e.probe.text));
}

void DimensionsOfStatements::study(const ast::Study& s) {
  for (const ast::Ladder& ladder : s.ladders) rungs(ladder);
  if (!s.exact) return;
  const auto* several = std::get_if<ast::List>(&s.exact->node);
  for (std::size_t b = 0; b < names_.of_unknown.size(); ++b) {
    const bool listed = names_.of_unknown.size() > 1 && several && b < several->items.size();
    wants_each(listed ? several->items[b] : *s.exact, names_.of_unknown[b],
               fmt::format("the exact `{}`", names_.find->unknowns[b].unknown.text));
  }
}

void DimensionsOfStatements::rungs(const ast::Ladder& ladder) {
  std::vector<const ast::Name*> names{&ladder.parameter};
  for (const ast::Name& name : ladder.more) names.push_back(&name);
  const auto* list = std::get_if<ast::List>(&ladder.values.node);
  for (std::size_t k = 0; list != nullptr && k < names.size(); ++k) {
    MeasuredDeclaration* found = names_.declaration(names[k]->text);
    const Measured own = found ? values_.declared(*found) : Measured{};
    for (const ast::Expr& item : list->items) {
      const auto* rung = std::get_if<ast::List>(&item.node);
      const ast::Expr& one = rung && k < rung->items.size() ? rung->items[k] : item;
      const std::string what = fmt::format("a rung of `{}`", names[k]->text);
      if (own.dimension && !wants_each(one, *own.dimension, what)) break; // the unit of all of them
    }
  }
}

} // namespace hvi::lang::units
