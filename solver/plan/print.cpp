// The plan as text: what `hvi-run dump --plan` shows. Stable: golden files compare it.
#include "solver/common/joined.hpp"
#include "solver/plan/plan.hpp"

#include <fmt/format.h>

namespace hvi::solver {
namespace {

template <std::size_t N>
std::string name_of(const std::array<const char*, N>& names, auto value) {
  return names.at(static_cast<std::size_t>(value));
}

std::string to_string(Rule rule) {
  return name_of(std::array{"exact", "nodal", "midpoint", "gauss"}, rule);
}

std::string to_string(Effect effect) {
  return name_of(std::array{"inertia", "viscosity", "elasticity", "memory", "body force",
                            "traction", "normal law", "friction", "other"},
                 effect);
}

std::string to_string(EffectNote::State state) {
  return name_of(std::array{"on", "off", "dropped", "asleep"}, state);
}

std::string to_string(HistoryRoute route) {
  return name_of(std::array{"automatic", "recursion", "fit", "tree", "direct"}, route);
}

std::string to_string(Branch branch) {
  return name_of(std::array{"continuing", "release", "least energy"}, branch);
}

std::string to_string(LinearSolver solver) {
  return name_of(std::array{"direct", "iterative", "automatic", "direct if it fits"}, solver);
}

/// Numbers with all their digits, the same on every machine.
std::string number(double value) { return fmt::format("{}", value); }

template <class Range>
std::string numbers(const Range& values) {
  return fmt::format("[{}]", joined(values));
}

std::string expressions(const std::vector<Expr>& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(to_string(value));
  return fmt::format("[{}]", joined(texts));
}

/// A function or one of its derivatives, by derivative index (slot.hpp); `u[1]` is the part of u
/// that is the second of several unknowns.
std::string derivative_name(const std::string& function, int index) {
  constexpr std::array axes{'x', 'y', 'z'};
  const int unknown = slot::unknown_of(index), own = index % slot::own_derivatives;
  const std::string of = unknown == 0 ? function : fmt::format("{}[{}]", function, unknown);
  const char component = axes.at(static_cast<std::size_t>(slot::component_of(index)));
  if (slot::is_value(index)) return fmt::format("{}.{}", of, component);
  return fmt::format("d{}.{}/d{}", of, component, axes.at(static_cast<std::size_t>(own % 3)));
}

std::string field_name(int field) {
  if (field == field_of_u(0)) return "u";
  if (field == field_of_u(1)) return "u'";
  if (field == field_of_u(2)) return "u''";
  return fmt::format("w{}", memory_of(field));
}

class Printer {
public:
  /// `starts_static`: from the last state of another problem, not from given values.
  Printer(const Problem& problem, bool starts_static)
      : problem_(problem), starts_static_(starts_static) {}

  std::string print(const SolverOptions& options, const ReportSpec& report) && {
    line("plan `{}`", problem_.title);
    mesh(problem_.mesh);
    for (std::size_t p = 0; p < problem_.parts.size(); ++p)
      line("part {} `{}` = {}", p, problem_.parts[p].name, region(problem_.parts[p].region));
    space();
    for (std::size_t m = 0; m < problem_.histories.size(); ++m)
      history(m, problem_.histories[m].kernel);
    for (std::size_t i = 0; i < problem_.tensors.size(); ++i) tensor(i);
    for (const auto& term : problem_.forms) form(term);
    for (std::size_t l = 0; l < problem_.laws.size(); ++l) law(l);
    for (std::size_t l = 0; l < problem_.law_terms.size(); ++l) law_term(l);
    for (std::size_t i = 0; i < problem_.states.size(); ++i) state(i);
    for (const LoadTerm* const term : all_loads(problem_)) load(*term);
    time();
    print(options);
    print(report);
    for (const auto& effect : problem_.effects)
      line("effect {}: {}{}", effect.name, to_string(effect.state),
           effect.why.empty() ? "" : " (" + effect.why + ")");
    return std::move(out_);
  }

private:
  template <class... Args>
  void line(fmt::format_string<Args...> text, Args&&... args) {
    out_ += fmt::format(text, std::forward<Args>(args)...) + "\n";
  }

  std::string part(int index) const {
    const bool known = index >= 0 && index < static_cast<int>(problem_.parts.size());
    return known ? "`" + problem_.parts[index].name + "`" : fmt::format("part {}", index);
  }

  void mesh(const MeshSpec& m) {
    const auto kind =
        name_of(std::array{"interval", "rectangle", "box", "file", "geometry", "pieces"}, m.kind);
    switch (m.kind) {
    case MeshSpec::Kind::pieces:
      line("mesh `{}` of {} pieces", m.name, m.pieces.size());
      for (const MeshSpec& piece : m.pieces) mesh(piece);
      return;
    case MeshSpec::Kind::file:
      line("mesh `{}` file \"{}\"", m.name, m.path);
      for (const auto& [name, value] : m.constants) line("  constant {} = {}", name, number(value));
      break;
    case MeshSpec::Kind::geometry:
      line("mesh `{}` {} {} {}", m.name, kind, m.geometry, numbers(m.numbers));
      break;
    default:
      line("mesh `{}` {} low {} high {} cells {}", m.name, kind, numbers(m.low), numbers(m.high),
           numbers(m.cells));
      if (m.crossed) line("  crossed");
    }
    for (int axis = 0; axis < 3; ++axis)
      if (!m.grading[axis].empty()) line("  grading {}: {}", "xyz"[axis], numbers(m.grading[axis]));
    if (m.axisymmetric) line("  axisymmetric");
    if (m.refinements > 0) line("  refinements {}", m.refinements);
    if (m.adapted > 0) line("  adapted to {} cells", m.adapted);
    if (m.at != Point{}) line("  at {}", numbers(m.at));
    for (const std::string& group : m.split) line("  cut along \"{}\"", group);
  }

  std::string region(const RegionSpec& r) const {
    using Kind = RegionSpec::Kind;
    switch (r.kind) {
    case Kind::all_cells:
      return "all";
    case Kind::boundary:
      return "boundary";
    case Kind::group:
      return "group \"" + r.name + "\"";
    case Kind::point:
      return "point " + numbers(r.point);
    case Kind::unite:
      return fmt::format("({} + {})", region(r.children.at(0)), region(r.children.at(1)));
    case Kind::subtract:
      return fmt::format("({} - {})", region(r.children.at(0)), region(r.children.at(1)));
    case Kind::pair:
      return fmt::format("pair({}, {}, {})", region(r.children.at(0)), region(r.children.at(1)),
                         r.reach);
    case Kind::where:
      return fmt::format("({} where {})", region(r.children.at(0)), to_string(r.predicate));
    }
    return {};
  }

  bool several() const { return !problem_.space.more.empty(); }

  std::string name_of_unknown(int unknown) const {
    const auto all = unknowns_of(problem_.space);
    const bool known = unknown >= 0 && unknown < static_cast<int>(all.size());
    return known ? all[unknown].name : fmt::format("unknown {}", unknown);
  }
  /// " of `theta`" where there are several.
  std::string of_unknown(int unknown) const {
    return several() ? fmt::format(" of `{}`", name_of_unknown(unknown)) : std::string();
  }

  void space() {
    const auto& s = problem_.space;
    for (const auto& unknown : unknowns_of(s))
      line("space `{}` {} P{}{}{}", unknown.space, unknown.vector ? "vector" : "scalar",
           unknown.order, several() ? fmt::format(" of `{}`", unknown.name) : std::string(),
           unknown.domain < 0 ? std::string() : " on " + part(unknown.domain));
    for (const auto& d : s.dirichlet)
      line("  on {} {}{} = {}", part(d.part),
           d.component < 0 ? std::string("all components")
                           : fmt::format("component {}", d.component),
           of_unknown(d.unknown), d.value.empty() ? "0" : expressions(d.value));
    for (const auto& p : s.periodic)
      line("  periodic {} = {}{}{}", part(p.first), part(p.second),
           p.unknown == 0 ? std::string() : fmt::format(" unknown {}", p.unknown),
           p.component < 0 ? std::string() : fmt::format(" component {}", p.component));
  }

  void history(std::size_t m, const KernelSpec& kernel) {
    line("history w{} kernel `{}` = {}", m, kernel.name, to_string(kernel.expression));
    if (kernel.series)
      line("  Prony series: constant {}, weights {}, times {}", number(kernel.series->constant),
           numbers(kernel.series->weights), numbers(kernel.series->times));
  }

  void tensor(std::size_t i) {
    const TensorSpec& t = problem_.tensors[i];
    const auto kind =
        name_of(std::array{"isotropic", "orthotropic", "transverse", "general"}, t.kind);
    line("tensor {} `{}` {} {}", i, t.name, kind, expressions(t.constants));
    if (t.axes != TensorSpec{}.axes)
      line("  axes {}, {}, {}", numbers(t.axes[0]), numbers(t.axes[1]), numbers(t.axes[2]));
  }

  void form(const FormTerm& term) {
    line("form {} over {} on {}, rule {}", to_string(term.effect), part(term.part),
         field_name(term.field), to_string(term.rule));
    if (term.tensor)
      line("  {} * tensor {} : eps({}) : eps(v){}", to_string(term.tensor->factor),
           term.tensor->index, field_name(term.field),
           term.tensor->unknown == 0 ? "" : fmt::format(", unknown {}", term.tensor->unknown));
    for (const auto& e : term.entries)
      line("  {} {} * {}", to_string(e.coefficient),
           derivative_name(field_name(term.field), e.trial), derivative_name("v", e.test));
  }

  void load(const LoadTerm& term) {
    line("load {} over {}, rule {}", to_string(term.effect), part(term.part), to_string(term.rule));
    for (const auto& e : term.entries)
      line("  {} * {}", to_string(e.value), derivative_name("v", e.test));
  }

  void law(std::size_t l) {
    const auto& spec = problem_.laws[l];
    line("law {} `{}`{} {} = {}", l, spec.name, spec.radial ? " radial" : "",
         spec.by_slope ? "slope" : "potential", to_string(spec.expression));
    if (!spec.coupled.empty()) line("  its bound reads the multiplier of `{}`", spec.coupled);
    for (std::size_t i = 0; i < spec.readings.size(); ++i)
      line("  reads {} = {}", to_string(Expr::variable(slot::reading(static_cast<int>(i)))),
           to_string(spec.readings[i]));
    for (std::size_t k = 0; k < spec.states.size(); ++k)
      line("  its state[{}] is state {}", k, spec.states[k]);
  }

  void state(std::size_t i) {
    const auto& s = problem_.states[i];
    line("state {} `{}` over {}, {} {}", i, s.name, part(s.part), s.algebraic ? "value" : "rate",
         to_string(s.rate));
    if (s.algebraic) return;
    line("  from {} in [{}, {}]", to_string(s.initial), number(s.low), number(s.high));
  }

  std::string seen_by(const LawTerm& term, std::size_t row) {
    if (term.seen.empty()) return field_name(term.field);
    std::string sum;
    for (const SeenField& seen : term.seen[row])
      sum += fmt::format("{}{} {}", sum.empty() ? "" : " + ", number(seen.times),
                         field_name(seen.field));
    return "(" + sum + ")";
  }

  void law_term(std::size_t l) {
    const auto& term = problem_.law_terms[l];
    line("law term {} {} * `{}` over {}{}, {}, rule {}{}", l, to_string(term.factor), term.name,
         part(term.part), of_unknown(term.unknown), to_string(term.effect), to_string(term.rule),
         term.rule_of ? " of the elements" + of_unknown(*term.rule_of) : std::string());
    const bool known = term.law >= 0 && term.law < static_cast<int>(problem_.laws.size());
    if (!known || problem_.laws[term.law].name != term.name) line("  by law {}", term.law);
    if (term.mean) line("  of the mean of both sides");
    for (std::size_t c = 0; c < term.rows.size(); ++c) {
      const auto& row = term.rows[c];
      const auto gradient = row.u.begin() + slot::gradient(0, 0);
      const std::string seen = seen_by(term, c),
                        of_gradient = row.sees_gradient()
                                          ? fmt::format(" + {} . grad {}",
                                                        expressions({gradient, row.u.end()}), seen)
                                          : "";
      line("  argument {} . {}{} + {}", expressions({row.u.begin(), gradient}), seen, of_gradient,
           to_string(row.offset));
    }
  }

  void time() {
    const auto& t = problem_.time;
    if (t.is_static) {
      line("static");
      return;
    }
    line("time {}{}, loads at {}", name_of(t.scheme),
         t.scheme == Scheme::hht ? fmt::format(" (alpha {})", number(t.hht_alpha)) : std::string(),
         t.sampling == LoadSampling::average ? "average of the step" : "end of the step");
    if (t.grid.size() <= 12)
      line("  grid {}", numbers(t.grid));
    else
      line("  grid {} ... {}, {} steps", number(t.grid.front()), number(t.grid.back()),
           t.grid.size() - 1);
    if (t.interpolant == Interpolant::constant) line("  constant between grid times");
    if (starts_static_)
      line("  from the solution of the static problem");
    else
      line("  from {}", t.initial.empty() ? "0" : expressions(t.initial));
    if (in_motion(problem_))
      line("  with the velocity {}", t.velocity ? expressions(*t.velocity) : "0");
  }

  void print(const SolverOptions& o) {
    line("options tolerance {}, memory {} (route {}), branch {}, solver {}, threads {}",
         number(o.tolerance), number(o.memory_tolerance), to_string(o.route), to_string(o.branch),
         to_string(o.solver), o.threads);
    if (o.factor == FactorEntries::singles) line("factor in single precision");
  }

  void probe(std::size_t i, const Probe& p) {
    const auto when = p.time ? " at t = " + number(*p.time) : std::string();
    switch (p.kind) {
    case Probe::Kind::at_point:
      line("probe {} `{}` = {} at {}{}{}", i, p.name, to_string(p.expression), numbers(p.point),
           p.on_pair ? " of " + part(p.part) : std::string(), when);
      break;
    case Probe::Kind::integral:
      line("probe {} `{}` = integral over {} of {}, rule {}{}", i, p.name, part(p.part),
           to_string(p.expression), to_string(p.rule), when);
      break;
    case Probe::Kind::largest:
    case Probe::Kind::smallest:
      line("probe {} `{}` = {} over {} of {}{}", i, p.name,
           p.kind == Probe::Kind::largest ? "largest" : "smallest", part(p.part),
           to_string(p.expression), when);
      break;
    case Probe::Kind::reaction:
      line("probe {} `{}` = reaction of {}{}, component {}{}", i, p.name, part(p.part),
           of_unknown(p.unknown), p.component, when);
      break;
    case Probe::Kind::norm_v:
      line("probe {} `{}` = norm of {}{}", i, p.name, several() ? name_of_unknown(p.unknown) : "u",
           when);
      break;
    case Probe::Kind::combination:
      line("probe {} `{}` = {}", i, p.name, to_string(p.expression));
      break;
    }
  }

  void print(const ReportSpec& r) {
    for (std::size_t i = 0; i < r.probes.size(); ++i) probe(i, r.probes[i]);
    for (const auto& table : r.tables)
      line("table {} every {}{}{}", numbers(table.probes), table.every, of_start(table.from_start),
           to_file(table.file));
    for (const auto& fields : r.fields) {
      line("fields every {}{}{}", fields.every, of_start(fields.from_start), to_file(fields.file));
      for (const auto& field : fields.fields)
        line("  `{}` = {}", field.name, expressions(field.components));
    }
    for (const auto& picture : r.pictures)
      line("{} `{}`{}{}{}", picture.in_row > 0 ? "picture" : "  beside it", picture.field.name,
           picture.deformed != 0.0 ? " deformed " + number(picture.deformed) : "",
           at_time(picture.time), to_file(picture.file));
    for (const auto& l : r.lines) {
      line("line from {} to {} by {} points{}{}", numbers(l.from), numbers(l.to), l.points,
           at_time(l.time), to_file(l.file));
      for (const auto& field : l.fields)
        line("  `{}` = {}", field.name, expressions(field.components));
    }
    for (const auto& plot : r.plots)
      line("plot {} against {}{}", joined(plot.columns), plot.against, to_file(plot.file));
    for (const auto& graphs : r.graphs) {
      std::vector<std::string> names;
      for (const auto& graph : graphs.graphs) names.push_back(graph.name);
      line("graph {}{}", joined(names), to_file(graphs.file));
    }
  }

  std::string at_time(const std::optional<double>& time) const {
    return time ? " at t = " + number(*time) : "";
  }
  static std::string to_file(const std::string& file) {
    return file.empty() ? "" : " to \"" + file + "\"";
  }

  static std::string of_start(bool from_start) { return from_start ? " from the start" : ""; }

  const Problem& problem_;
  bool starts_static_;
  std::string out_;
};

} // namespace

std::string to_string(const Plan& plan) {
  return Printer(plan.problem, plan.start != nullptr).print(plan.options, plan.report);
}

} // namespace hvi::solver
