// Results: tables, fields, pictures, expectations and studies.
#include "lang/check/across.hpp"
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::Probe;

namespace {

Scope report_scope() {
  Scope scope;
  scope.what = "a report";
  scope.position = scope.time = scope.unknown = scope.report = scope.states = true;
  return scope;
}

bool is_reference_to(const ast::Expr& e, const std::string& name) {
  const auto* r = std::get_if<ast::Reference>(&e.node);
  return r && r->name == name;
}

} // namespace

/// norm(u) as written: of which unknown; -1: it is something else.
int Checker::norm_of_unknown(const ast::Expr& e) const {
  const auto* call = std::get_if<ast::Call>(&e.node);
  const bool norm = call && is_reference_to(*call->callee, "norm") && call->arguments.size() == 1 &&
                    !call->arguments[0].name;
  if (!norm) return -1;
  const auto* r = std::get_if<ast::Reference>(&call->arguments[0].value.node);
  return r ? unknown_named(r->name) : -1;
}

/// The first unknown that is a vector, else the first.
int Checker::first_vector_unknown() const {
  const auto all = unknowns_of(model_.space);
  const auto found = std::ranges::find(all, true, &solver::UnknownSpec::vector);
  return found == all.end() ? 0 : static_cast<int>(found - all.begin());
}

/// The stress, the sum of all that is contracted with eps(v): sigma_ij = d integrand / d
/// (dv_i/dx_j), symmetrised, on cells; axisymmetric: 3 x 3, zz along the circles. Of the first
/// unknown that is a vector, else of the first.
Field Checker::stress() {
  const int unknown = first_vector_unknown();
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  const int d = components_of(unknown);
  const auto of = [&](int derivative) { return slot::test(slot::of_unknown(unknown, derivative)); };
  Field out = matrix_field(d, model_.dim, std::vector<Symbol>(d * model_.dim, Symbol(0.0)));
  if (vector && d == 2 && !model_.mesh.axisymmetric) out.across = {Symbol(0.0)};
  const bool ring = model_.mesh.axisymmetric && vector;
  Symbol hoop = 0.0;
  for (const ModelTerm& term : model_.terms) {
    if (term.right || model_.parts[term.part].kind != Group::Kind::cells) continue;
    const bool whole = model_.parts[term.part].region.kind == solver::RegionSpec::Kind::all_cells;
    const Symbol where = whole ? Symbol(1.0) : Symbol::variable(slot::inside(term.part));
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < model_.dim; ++j) {
        Symbol entry = derivative(term.integrand.scalar(), of(slot::gradient(i, j)));
        out.components[i * model_.dim + j] =
            out.components[i * model_.dim + j] + term.factor * where * entry;
      }
    const auto across = across_of_scalar(term.integrand);
    if (across.empty()) out.across.clear();
    if (!out.across.empty()) out.across[0] = out.across[0] + term.factor * where * across[0];
    if (ring)
      hoop = hoop + term.factor * where * derivative(term.integrand.scalar(), of(slot::hoop));
  }
  if (ring) {
    const std::vector<Symbol> s = out.components;
    out = matrix_field(3, 3, {s[0], s[1], 0.0, s[2], s[3], 0.0, 0.0, 0.0, hoop});
  }
  if (!vector) {
    out.rank = 1;
    out.rows = model_.dim;
    out.columns = 1;
  }
  out.trial = Degree::linear;
  return out;
}

int Checker::probe(Probe p) {
  model_.report.probes.push_back(std::move(p));
  return static_cast<int>(model_.report.probes.size()) - 1;
}

/// `other.xi` in a superpotential: the multiplier of a scalar law at the same point.
Value Checker::coupled_multiplier(const ast::Member& m, int declaration) {
  const std::string& law = declarations_[declaration].name;
  if (coupled_.empty()) coupled_ = law;
  if (coupled_ == law) return scalar_field(Symbol::variable(slot::coupled));
  error("E0309", m.member.span,
        fmt::format("a law reads one other law's multiplier, not those of `{}` and `{}`", coupled_,
                    law));
  return Poison{};
}

Value Checker::law_member(const ast::Member& m, int declaration, const Scope& scope) {
  const std::string& law = declarations_[declaration].name;
  if (m.member.text != "xi") {
    error("E0303", m.member.span, fmt::format("a superpotential has no member `{}`", m.member.text),
          fmt::format("its multiplier is `{}.xi`", law));
    return Poison{};
  }
  if (scope.law) return coupled_multiplier(m, declaration);
  if (scope.test && !scope.source) { // to be read again when all laws are known
    reads_multiplier_ = true;
    return Poison{};
  }
  if (!scope.report && !scope.source) {
    error("E0309", m.member.span, fmt::format("`{}.xi` is a result", law),
          "it may stand in `report`, in sources on the part of the law and in superpotentials");
    return Poison{};
  }
  int application = 0;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      if (use.name == law) {
        const auto& spec = model_.laws[use.law].spec;
        const int n = spec.radial ? static_cast<int>(use.rows.size()) : 1;
        std::vector<Symbol> xi;
        for (int c = 0; c < n; ++c)
          xi.push_back(Symbol::variable(slot::multiplier(application, c)));
        Field f = spec.radial ? vector_field(xi) : scalar_field(xi[0]);
        f.trial = Degree::nonlinear;
        return f;
      }
      ++application;
    }
  // Its term may have been left out because of an error in it.
  if (diagnostics_.has_errors()) return Poison{};
  if (scope.source)
    error("E0447", m.object->span,
          fmt::format("no other integral of the inequality has the law `{}` in it", law),
          "a source that reads a multiplier stands in an integral of its own");
  else
    error("E0301", m.object->span,
          fmt::format("the law `{}` does not stand in the inequality", law),
          "its multiplier exists only where it acts");
  return Poison{};
}

std::optional<double> Checker::report_time(const ast::Expr& e) {
  auto t = constant(e, "a time");
  if (!t) return std::nullopt;
  if (!model_.has_time) {
    error("E0412", e.span, "a static problem has no times");
    return std::nullopt;
  }
  const auto& grid = model_.time.grid;
  if (grid.empty()) return std::nullopt;
  if (*t < grid.front() || *t > grid.back()) {
    error("E0422", e.span,
          fmt::format("t = {} is outside [{}, {}]", *t, grid.front(), grid.back()));
    return std::nullopt;
  }
  return t;
}

/// A column of a table. A vector has a column for each component: `force` gives `force_x`,
/// `force_y`.
void Checker::binding(const ast::Binding& b, solver::TableSpec& table) {
  Probe p;
  p.name = b.name.text;
  p.origin = model_.origin(b.value.span);
  bool good = true;
  if (b.time) {
    p.time = report_time(*b.time);
    good = p.time.has_value();
  }
  const std::size_t first = model_.report.probes.size();
  if (const int normed = b.point ? -1 : norm_of_unknown(b.value); normed >= 0) {
    p.kind = Probe::Kind::norm_v;
    p.unknown = normed;
    if (good) column(b, std::move(p), table);
    return;
  }
  gap_part_ = -1;
  auto value = column_value(b);
  if (b.point) {
    auto at = constant_list(*b.point, "a point");
    if (!at || !value || !good) return;
    if (static_cast<int>(at->size()) != model_.dim) {
      error("E0307", b.point->span, fmt::format("a point in {0}D has {0} coordinates", model_.dim));
      return;
    }
    p.kind = Probe::Kind::at_point;
    p.origin = model_.origin(b.point->span);
    for (int i = 0; i < model_.dim; ++i) p.point[i] = (*at)[i];
  } else {
    if (!value || !good) return;
    if (!has_one_value(b, *value)) return;
    p.kind = Probe::Kind::combination;
  }
  for (std::size_t i = 0; i < value->components.size(); ++i) {
    Probe of = p;
    of.expression = value->components[i];
    if (b.point && !take_jumps_at_point(b.value.span, of.expression, of)) return;
    if (value->rank == 1) of.name += fmt::format("_{}", "xyz"[i]);
    if (of.kind == Probe::Kind::combination && of.time) take_at_its_time(first, of);
    if (!column(b, std::move(of), table)) return;
  }
}

/// A number, or a vector.
std::optional<Field> Checker::column_value(const ast::Binding& b) {
  auto value = field(b.value, report_scope());
  if (!value || (value->rank <= 1 && !value->law_vector)) return value;
  error("E0306", b.value.span,
        fmt::format("a column is a scalar or a vector, not {}", describe(*value)));
  return std::nullopt;
}

/// Is it made of numbers of the report and of t only?
bool Checker::has_one_value(const ast::Binding& b, const Field& value) {
  for (const Symbol& component : value.components)
    for (solver::Slot s : solver::slots_of(component)) {
      if (s >= slot::first_probe || s == slot::t) continue;
      error("E0306", b.value.span, fmt::format("`{}` has a value at every point", b.name.text),
            fmt::format("say where: `{} = ... at [{}]`, or take its integral", b.name.text,
                        model_.dim == 1   ? "0.5"
                        : model_.dim == 2 ? "1, 0"
                                          : "1, 0, 0"));
      return false;
    }
  return true;
}

bool Checker::column(const ast::Binding& b, Probe p, solver::TableSpec& table) {
  for (const Probe& known : model_.report.probes)
    if (known.name == p.name) {
      error("E0302", b.name.span, fmt::format("the column `{}` is there twice", p.name));
      return false;
    }
  table.probes.push_back(probe(std::move(p)));
  return true;
}

/// A combination of integrals at a time of its own: its integrals, the probes from `first` on, are
/// taken then, and t is that time.
void Checker::take_at_its_time(std::size_t first, Probe& p) {
  for (std::size_t i = first; i < model_.report.probes.size(); ++i)
    model_.report.probes[i].time = p.time;
  const std::pair<solver::Slot, Symbol> then[] = {{slot::t, Symbol(*p.time)}};
  p.expression = substitute(p.expression, then);
}

std::optional<std::string> Checker::output_name(const std::optional<ast::Text>& to) {
  if (!to) return std::string();
  const std::filesystem::path path(to->text);
  const bool plain = !to->text.empty() && path == path.filename() && to->text[0] != '.';
  if (plain && !outputs_.insert(to->text).second)
    error("E0302", to->span, fmt::format("two results go to `{}`", to->text),
          "give each its own name");
  if (plain) return to->text;
  error("E0604", to->span, fmt::format("`{}` is not a plain file name", to->text),
        "results go into " + options_.words.output_folder);
  return std::nullopt;
}

/// `from start`, which is of problems in time.
bool Checker::from_start(const Span& words) {
  if (!words.valid()) return false;
  if (!model_.has_time)
    error("E0412", words, "a static problem does not start",
          "add `for t in [0, T] by N steps from u = 0` to the find statement");
  return model_.has_time;
}

void Checker::table(const ast::TableItem& item) {
  solver::TableSpec spec;
  spec.origin = model_.origin(item.span);
  if (item.every)
    if (auto n = positive_integer(*item.every, "`every`")) spec.every = *n;
  spec.from_start = from_start(item.from_start);
  auto file = output_name(item.to);
  for (const ast::Binding& b : item.columns) binding(b, spec);
  if (!file) return;
  spec.file = *file;
  model_.report.tables.push_back(std::move(spec));
}

std::optional<solver::FieldSpec> Checker::output_field(const ast::Expr& e) {
  Scope scope = report_scope();
  auto f = field(e, scope);
  if (!f) return std::nullopt;
  for (const Symbol& c : f->components)
    if (has_jumps(c) || c.depends_on(slot::gap)) {
      error("E0441", e.span, "a jump or a gap is written at points, not as a field",
            "probe it (`jump(u).nu at [..]`) or integrate it; `layer.xi` of a law on the pair is a "
            "field");
      return std::nullopt;
    }
  if (f->rank > 2 || f->law_vector) {
    error("E0306", e.span, fmt::format("{} cannot be written as a field", describe(*f)));
    return std::nullopt;
  }
  for (const Symbol& c : f->components)
    if (c.depends_on_any(slot::first_probe, slot::first_probe + 100000)) {
      error("E0306", e.span, "an integral is a number, not a field", "put it into a `table`");
      return std::nullopt;
    }
  solver::FieldSpec spec;
  spec.origin = model_.origin(e.span);
  spec.components = f->components;
  // The text of the script without the blanks is the field's name: u, sigma, layer.xi, u.x
  std::function<std::string(const ast::Expr&)> name = [&](const ast::Expr& part) -> std::string {
    if (const auto* r = std::get_if<ast::Reference>(&part.node)) return r->name;
    if (const auto* m = std::get_if<ast::Member>(&part.node))
      return name(*m->object) + "." + m->member.text;
    if (const auto* p = std::get_if<ast::Prime>(&part.node)) {
      const auto* inner = std::get_if<ast::Prime>(&p->operand->node);
      return inner ? name(*inner->operand) + "_acceleration" : name(*p->operand) + "_rate";
    }
    if (const auto* c = std::get_if<ast::Call>(&part.node))
      return c->arguments.empty() ? name(*c->callee)
                                  : name(*c->callee) + "_" + name(c->arguments[0].value);
    return fmt::format("field{}", model_.report.fields.size());
  };
  spec.name = name(e);
  return spec;
}

void Checker::fields(const ast::FieldsItem& item) {
  solver::FieldsSpec spec;
  spec.origin = model_.origin(item.span);
  if (item.every)
    if (auto n = positive_integer(*item.every, "`every`")) spec.every = *n;
  spec.from_start = from_start(item.from_start);
  auto file = output_name(item.to);
  for (const ast::Expr& e : item.fields)
    if (auto f = output_field(e)) spec.fields.push_back(std::move(*f));
  if (!file) return;
  spec.file = *file;
  model_.report.fields.push_back(std::move(spec));
}

void Checker::reports() {
  for (const ast::Statement& statement : programs_[0].statements) {
    const auto* report = std::get_if<ast::Report>(&statement);
    if (!report || !spaces_known_) continue;
    for (const ast::ReportItem& item : report->items) {
      if (const auto* t = std::get_if<ast::TableItem>(&item)) table(*t);
      if (const auto* f = std::get_if<ast::FieldsItem>(&item)) fields(*f);
      if (const auto* p = std::get_if<ast::PictureItem>(&item)) picture(*p);
      if (const auto* l = std::get_if<ast::LineItem>(&item)) line(*l);
    }
  }
}

/// After all tables: plots show their columns.
void Checker::plots() {
  for (const ast::Statement& statement : programs_[0].statements)
    if (const auto* report = std::get_if<ast::Report>(&statement); report && spaces_known_)
      for (const ast::ReportItem& item : report->items)
        if (const auto* p = std::get_if<ast::PlotItem>(&item)) plot(*p);
}

void Checker::expectations() {
  std::vector<std::string> names;
  for (const Probe& p : model_.report.probes)
    if (!p.name.empty()) names.push_back(p.name);
  for (const ast::Statement& statement : programs_[0].statements) {
    const auto* e = std::get_if<ast::Expect>(&statement);
    if (!e) continue;
    Expectation out;
    out.span = e->span;
    out.probe = e->probe.text;
    if (std::find(names.begin(), names.end(), out.probe) == names.end() &&
        !diagnostics_.has_errors())
      error("E0319", e->probe.span, fmt::format("no table has a column `{}`", out.probe),
            did_you_mean(out.probe, names));
    if (e->time) out.time = report_time(*e->time);
    auto value = constant(e->value, "an expected value");
    auto tolerance = constant(e->tolerance, "a tolerance");
    if (tolerance && *tolerance < 0.0)
      error("E0408", e->tolerance.span, "a tolerance is not negative");
    out.relative = e->relative;
    if (e->when) {
      Scope scope;
      scope.what = "the condition of an expectation";
      auto when = condition(*e->when, scope);
      out.active = when && when->value() != 0.0; // the scope has no name that varies
    }
    if (e->source) out.source = e->source->text;
    if (!value || !tolerance) continue;
    out.value = *value;
    out.tolerance = *tolerance;
    model_.expectations.push_back(std::move(out));
  }
}

/// May the study vary it? A parameter that no ladder has yet.
bool Checker::varies(const ast::Name& name, std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name.text) != known.end()) {
    error("E0302", name.span, fmt::format("`{}` is varied twice", name.text));
    return false;
  }
  known.push_back(name.text);
  const int index = find_declaration(name.text);
  if (index < 0 && is_silent(name.text)) return false;
  if (index >= 0 && std::holds_alternative<ast::Param>(*declarations_[index].statement))
    return true;
  std::vector<std::string> params;
  for (const ModelParam& p : model_.params) params.push_back(p.name);
  diagnostics_.add_once(
      name.text,
      diagnose("E0301", name.span, fmt::format("there is no parameter `{}` to vary", name.text))
          .with_help(did_you_mean(name.text, params)));
  return false;
}

/// A value as a parameter may be given it; false: said why not.
bool Checker::study_value(const ast::Expr& item, std::vector<std::string>& out) {
  const auto* w = std::get_if<ast::Reference>(&item.node);
  if (w && is_word(w->name)) {
    out.push_back(w->name);
    return true;
  }
  const auto v = constant(item, "a rung of a ladder");
  if (v) out.push_back(fmt::format("{}", *v));
  return v.has_value();
}

std::optional<StudyLadder> Checker::study_ladder(const ast::Ladder& ladder,
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
    error("E0306", ladder.values.span, "a ladder is a list `[...]`");
    return std::nullopt;
  }
  for (const ast::Expr& item : list->items) {
    if (out.more.empty()) {
      study_value(item, out.values);
      continue;
    }
    const auto* rung = std::get_if<ast::List>(&item.node);
    if (!rung || rung->items.size() != out.more.size() + 1) {
      error("E0307", item.span,
            fmt::format("a rung is a list of {} values, one for each parameter",
                        out.more.size() + 1));
      return std::nullopt;
    }
    good = study_value(rung->items[0], out.values);
    for (std::size_t k = 0; k < out.more.size(); ++k)
      good = study_value(rung->items[k + 1], out.more[k].second) && good;
    if (!good) return std::nullopt;
  }
  return out;
}

/// By component of all unknowns; of several: a list with a solution for each.
std::vector<Symbol> Checker::exact_solution(const ast::Expr& written) {
  const auto unknowns = unknowns_of(model_.space);
  std::vector<const ast::Expr*> given{&written};
  if (unknowns.size() > 1) {
    const auto* list = std::get_if<ast::List>(&written.node);
    if (list == nullptr || list->items.size() != unknowns.size()) {
      error("E0307", written.span,
            fmt::format("the exact solution of {} unknowns is a list of {}", unknowns.size(),
                        unknowns.size()),
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
    const auto f = field(*given[b], scope);
    if (!f) continue;
    const int n = components_of(static_cast<int>(b));
    if (static_cast<int>(f->components.size()) != n)
      error(
          "E0307", given[b]->span,
          fmt::format("the exact solution is {}, the unknown has {} components", describe(*f), n));
    std::ranges::copy(f->components, std::back_inserter(out));
  }
  return out;
}

/// `in V`: the space of an unknown. Of several it says whose error decides.
void Checker::norm_of_study(const ast::Name& space, ModelStudy& study) {
  study.norm = space.text;
  const auto unknowns = unknowns_of(model_.space);
  for (std::size_t b = 0; b < unknowns.size() && unknowns.size() > 1; ++b)
    if (unknowns[b].space == space.text && !study.unknown) study.unknown = b;
  if (unknowns.size() > 1 && !study.unknown)
    error("E0306", space.span, fmt::format("`{}` is not the space of an unknown", space.text),
          "errors of several unknowns are those of all together, or `in V`, of one");
}

void Checker::study() {
  for (const ast::Statement& statement : programs_[0].statements) {
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
      error("E0302", s->keyword, "a script has one study statement");
    else
      model_.study = std::move(out);
  }
}

} // namespace hvi::lang
