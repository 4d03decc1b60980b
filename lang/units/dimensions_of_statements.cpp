// Dimensions of statements: each has places whose dimension is known.
#include "lang/units/dimension_checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::lang::units {

DimensionChecker::DimensionChecker(const std::vector<ast::Program>& programs,
                                   const ScriptUnits& units, Model& model, Diagnostics& diagnostics)
    : programs_(programs), units_(units), model_(model), diagnostics_(diagnostics) {
  for (const ast::Program& program : programs_) {
    if (program.library) library_.insert(program.file);
    for (const ast::Statement& statement : program.statements) {
      if (const auto* f = std::get_if<ast::Find>(&statement)) find_ = f;
      const std::string name = std::visit(
          [](const auto& s) -> std::string {
            if constexpr (requires { s.name.text; })
              return s.name.text;
            else
              return {};
          },
          statement);
      if (name.empty()) continue;
      const auto [known, fresh] = named_.try_emplace(name, Named{&statement, program.library});
      if (!fresh && known->second.library && !program.library)
        known->second = Named{&statement, false}; // the script's own names win
    }
  }
  of_form_ = inference_.fresh();
}

void DimensionChecker::run() {
  const auto unknowns = solver::unknowns_of(model_.space);
  for (std::size_t b = 0; find_ != nullptr && b < find_->unknowns.size(); ++b) {
    const auto& declared = find_->unknowns[b].unit;
    const auto unit = declared ? units_.read.find(declared->text) : units_.read.end();
    // A vector is a displacement unless the script says otherwise; of a scalar its forms tell.
    const bool displacement = b < unknowns.size() && unknowns[b].vector;
    of_unknown_.push_back(unit != units_.read.end() ? unit->second.dimension
                          : displacement            ? length()
                                                    : inference_.fresh());
    of_test_.push_back(inference_.fresh());
  }
  declarations();
  if (find_ != nullptr) find(*find_);
  for (const ast::Statement& statement : programs_.front().statements) {
    if (const auto* s = std::get_if<ast::State>(&statement)) state(*s);
    if (const auto* r = std::get_if<ast::Report>(&statement)) report(*r);
  }
  for (const ast::Statement& statement : programs_.front().statements) {
    if (const auto* e = std::get_if<ast::Expect>(&statement)) expect(*e);
    if (const auto* s = std::get_if<ast::Study>(&statement)) study(*s);
  }
  if (!diagnostics_.has_errors()) tell_model();
}

void DimensionChecker::declarations() {
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      if (const auto* p = std::get_if<ast::Param>(&statement); p && !program.library) param(*p);
      if (const auto* m = std::get_if<ast::Mesh>(&statement); m && !program.library) mesh(m->value);
      if (const auto* part = std::get_if<ast::Part>(&statement)) region(part->region);
      if (const auto* t = std::get_if<ast::Tensor>(&statement))
        if (const auto found = named_.find(t->name.text); found->second.statement == &statement)
          declared(found->second);
    }
}

void DimensionChecker::param(const ast::Param& p) {
  const auto found = named_.find(p.name.text);
  const Measured own = declared(found->second);
  if (!own.dimension) return;
  if (const auto set = units_.of_defines.find(p.name.text);
      set != units_.of_defines.end() && !inference_.unify(*own.dimension, set->second))
    report_mistake(
        diagnose("E0331", p.value.span,
                 fmt::format("`{}` is declared in {} and set in {}", p.name.text,
                             shown_with_words(*own.dimension), shown_with_words(set->second))));
  if (p.range) wants_each(*p.range, *own.dimension, fmt::format("the range of `{}`", p.name.text));
}

void DimensionChecker::mesh(const ast::Expr& e) {
  if (const auto* sum = std::get_if<ast::Binary>(&e.node)) {
    mesh(*sum->left), mesh(*sum->right);
    return;
  }
  const auto* c = std::get_if<ast::Call>(&e.node);
  if (c == nullptr) return;
  constexpr std::array lengths{"width", "height", "depth", "length", "origin", "at"};
  for (const ast::Argument& a : c->arguments) {
    const bool is_length = !a.name || std::ranges::find(lengths, a.name->text) != lengths.end();
    if (is_length) wants_each(a.value, length(), "a length of a mesh");
  }
}

void DimensionChecker::region(const ast::Region& r) {
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
  if (r.where) condition(*r.where, {});
}

void DimensionChecker::state(const ast::State& s) {
  const auto found = named_.find(s.name.text);
  if (found == named_.end()) return;
  const Measured own = declared(found->second);
  if (!own.dimension) return;
  const std::string what = fmt::format("the state `{}`", s.name.text);
  wants_each(s.initial.value, *own.dimension, what);
  const Measured rate = value(s.rate, {});
  if (rate.dimension)
    wants({&rate, &s.rate}, *own.dimension / duration(),
          fmt::format("the rate of the state `{}`", s.name.text));
  if (s.range) wants_each(*s.range, *own.dimension, what);
}

void DimensionChecker::find(const ast::Find& f) {
  const auto of = [&](const ast::Name& unknown) {
    const auto b = unknown_named(unknown.text);
    return b ? of_unknown_[*b] : inference_.fresh();
  };
  for (const ast::ImposedValue& imposed : f.imposed)
    wants_each(imposed.value, of(imposed.unknown),
               fmt::format("the value of `{}`", imposed.unknown.text));
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

void DimensionChecker::time(const ast::TimeClause& clause) {
  wants_each(clause.range, duration(), "the time");
  if (!clause.by_steps) wants_each(clause.steps, duration(), "the time");
}

/// All integrals of an inequality are of one dimension: that of a force times the test function.
/// Where most do not fit the first, it is the first that is wrong.
void DimensionChecker::forms(const ast::Find& f) {
  std::vector<Term> fit, misfits;
  for (const ast::Form* form : {&f.left, &f.right})
    for (const ast::FormTerm& term : form->terms) {
      if (!term.integral) continue;
      const auto own = of_term(term);
      if (!own) continue;
      (inference_.unify(*own, of_form_) ? fit : misfits).push_back({&*term.integral, *own});
    }
  if (misfits.empty() || fit.empty()) return;
  if (fit.size() == 1 && misfits.size() > 1)
    tell_misfit(fit.front(), misfits.front(), "those behind it are");
  else
    for (const Term& wrong : misfits) tell_misfit(wrong, fit.front(), "those before it are");
}

std::optional<Dimension> DimensionChecker::of_term(const ast::FormTerm& term) {
  Dimension own = measure_of(term.integral->domain.text);
  bool known = true;
  const auto times = [&](const ast::Expr& e) {
    const Measured factor = value(e, {});
    known = known && factor.dimension;
    if (known) own = own * *factor.dimension;
  };
  for (const ast::Expr& factor : term.factors) times(factor);
  times(term.integral->integrand);
  return known ? std::optional(own) : std::nullopt;
}

void DimensionChecker::tell_misfit(const Term& wrong, const Term& other, const char* others) {
  Diagnostic out = diagnose("E0331", wrong.integral->integrand.span,
                            fmt::format("this integral is {}, and {} {}", shown(wrong.dimension),
                                        others, shown(other.dimension)))
                       .with_secondary(other.integral->span, "one of them")
                       .with_help(fmt::format(
                           "over cells loads are N/m^3, over boundaries N/m^2, beside stresses in "
                           "Pa{}",
                           model_.dim == 2 && !model_.mesh.axisymmetric
                               ? "; in 2D all is for one unit of thickness"
                               : ""));
  const auto unknowns = solver::unknowns_of(model_.space);
  for (std::size_t b = 0; b < unknowns.size(); ++b)
    if (unknowns[b].vector && !find_->unknowns[b].unit)
      out.notes.push_back(fmt::format(
          "a vector is a displacement unless its unit is declared: `find {} [m/s] in {}`",
          find_->unknowns[b].unknown.text, find_->unknowns[b].space.text));
  report_mistake(std::move(out));
}

void DimensionChecker::report(const ast::Report& r) {
  const auto at_time = [&](const std::optional<ast::Expr>& t) {
    if (t) wants_each(*t, duration(), "the time");
  };
  for (const ast::ReportItem& item : r.items)
    std::visit(Overloaded{[&](const ast::TableItem& one) { table(one); },
                          [&](const ast::FieldsItem& one) {
                            for (const ast::Expr& e : one.fields) field(e);
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
                              wants_number(*one.deformed, value(*one.deformed, {}),
                                           "the factor of a deformed picture");
                          },
                          [&](const ast::LineItem& one) {
                            line(one);
                            at_time(one.time);
                          },
                          [&](const ast::PlotItem&) {}},
               item);
}

void DimensionChecker::field(const ast::Expr& e) {
  const Measured of = value(e, {});
  if (of.dimension) of_field_[{e.span.file, e.span.begin}] = *of.dimension;
}

void DimensionChecker::table(const ast::TableItem& item) {
  for (const ast::Binding& b : item.columns) {
    const auto* c = std::get_if<ast::Call>(&b.value.node);
    const auto* callee = c ? std::get_if<ast::Reference>(&c->callee->node) : nullptr;
    // norm(u) alone is the norm of V: not a pointwise quantity, and told without a unit.
    const auto* of = callee && callee->name == "norm" && !b.point && c->arguments.size() == 1
                         ? std::get_if<ast::Reference>(&c->arguments[0].value.node)
                         : nullptr;
    const bool norm_of_space = of != nullptr && unknown_named(of->name).has_value();
    const Measured now = value(b.value, {});
    if (now.dimension && !norm_of_space) of_column_[b.name.text] = *now.dimension;
    if (b.point) wants_each(*b.point, length(), "the coordinates of a point");
    if (b.time) wants_each(*b.time, duration(), "the time");
  }
}

void DimensionChecker::line(const ast::LineItem& item) {
  for (const ast::Expr& e : item.fields) field(e);
  wants_each(item.from, length(), "the coordinates of a point");
  wants_each(item.end, length(), "the coordinates of a point");
}

void DimensionChecker::expect(const ast::Expect& e) {
  if (e.time) wants_each(*e.time, duration(), "the time");
  if (e.when) condition(*e.when, {});
  if (e.relative) wants_number(e.tolerance, value(e.tolerance, {}), "a relative tolerance");
  const auto column = of_column(e.probe.text);
  if (!column) return;
  wants_each(e.value, *column, fmt::format("the column `{}`", e.probe.text));
  if (!e.relative)
    wants_each(e.tolerance, *column, fmt::format("the tolerance of `{}`", e.probe.text));
}

void DimensionChecker::study(const ast::Study& s) {
  for (const ast::Ladder& ladder : s.ladders) rungs(ladder);
  if (!s.exact) return;
  const auto* several = std::get_if<ast::List>(&s.exact->node);
  for (std::size_t b = 0; b < of_unknown_.size(); ++b) {
    const bool listed = of_unknown_.size() > 1 && several && b < several->items.size();
    wants_each(listed ? several->items[b] : *s.exact, of_unknown_[b],
               fmt::format("the exact `{}`", find_->unknowns[b].unknown.text));
  }
}

void DimensionChecker::rungs(const ast::Ladder& ladder) {
  std::vector<const ast::Name*> names{&ladder.parameter};
  for (const ast::Name& name : ladder.more) names.push_back(&name);
  const auto* list = std::get_if<ast::List>(&ladder.values.node);
  for (std::size_t k = 0; list != nullptr && k < names.size(); ++k) {
    const auto found = named_.find(names[k]->text);
    const Measured own = found == named_.end() ? Measured{} : declared(found->second);
    for (const ast::Expr& item : list->items) {
      const auto* rung = std::get_if<ast::List>(&item.node);
      const ast::Expr& one = rung && k < rung->items.size() ? rung->items[k] : item;
      if (own.dimension)
        wants_each(one, *own.dimension, fmt::format("a rung of `{}`", names[k]->text));
    }
  }
}

} // namespace hvi::lang::units
