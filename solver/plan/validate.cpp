#include "solver/plan/validate.hpp"

#include "solver/plan/tensor_form.hpp"
#include "solver/plan/validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

namespace hvi::solver {
namespace {

using namespace allowed;

/// Is this the series, at lags from none to beyond all relaxation times?
bool is_series(const Expr& kernel, const PronySeries& series) {
  const auto positive = [](double time) { return time > 0.0 && std::isfinite(time); };
  if (series.weights.size() != series.times.size() ||
      !std::ranges::all_of(series.times, positive) ||
      std::ranges::any_of(kernel.slots(), [](Slot s) { return s != slot::lag; }))
    return false;
  std::vector<double> lags{0.0};
  for (const double time : series.times) lags.insert(lags.end(), {0.5 * time, time, 4 * time});
  double size = std::abs(series.constant);
  for (const double weight : series.weights) size += std::abs(weight);
  return std::ranges::all_of(lags, [&](double lag) {
    const double value = evaluate(kernel, [&](Slot) { return lag; });
    return std::abs(value - series.value(lag)) <= 1e-12 * size; // false for NaN
  });
}

class ProblemValidation : private Validation {
public:
  ProblemValidation(const Problem& problem, int dim) : Validation(problem, dim) {}

  std::vector<Failure> failures() && {
    for (const auto& part : problem_.parts) region(part.region, part.origin);
    space();
    for (const auto& tensor : problem_.tensors) this->tensor(tensor);
    for (const auto& unknown : unknowns_of(problem_.space))
      if (unknown.domain != -1) part(unknown.domain, unknown.origin, "a space");
    for (const auto& form : problem_.forms) this->form(form);
    for (const auto& load : problem_.loads) this->load(load, of_load);
    for (const auto& load : problem_.state_loads) state_load(load);
    for (const auto& history : problem_.histories) this->history(history);
    for (const auto& law : problem_.laws) this->law(law);
    for (const auto& term : problem_.law_terms) law_term(term);
    for (const auto& state : problem_.states) this->state(state);
    time();
    return take();
  }

private:
  void region(const RegionSpec& spec, Origin origin) {
    using Kind = RegionSpec::Kind;
    if (spec.kind == Kind::where) variables(spec.predicate, of_place, origin, "a part's condition");
    for (const auto& child : spec.children) {
      region(child, origin);
      if (child.kind == Kind::pair) wrong(origin, "a pair is no part of another part");
    }
  }

  void space() {
    const auto& space = problem_.space;
    const auto unknowns = unknowns_of(space);
    if (count(unknowns) > slot::most_unknowns)
      wrong(space.origin,
            fmt::format("{} unknowns, more than {}", unknowns.size(), slot::most_unknowns));
    for (const auto& unknown : unknowns)
      if (unknown.order != 1 && unknown.order != 2)
        wrong(unknown.origin,
              fmt::format("the space has order {}; there are 1 and 2", unknown.order));
    for (const auto& d : space.dirichlet) {
      index(d.unknown, count(unknowns), d.origin, "an imposed value", "unknown");
      part(d.part, d.origin, "an imposed value");
      no_pair(d.part, d.origin, "an imposed value");
    }
    for (const auto& p : space.periodic) {
      index(p.unknown, count(unknowns), p.origin, "a periodic part", "unknown");
      for (const int of : {p.first, p.second}) {
        part(of, p.origin, "a periodic part");
        no_pair(of, p.origin, "a periodic part");
      }
    }
  }

  int tensor_dim() const { return problem_.mesh.axisymmetric ? 3 : dim_; }

  void tensor(const TensorSpec& tensor) {
    for (const auto& c : tensor.constants) variables(c, of_form, tensor.origin, "a tensor");
    const int wanted = count_constants(tensor.kind, tensor_dim());
    if (count(tensor.constants) != wanted)
      wrong(tensor.origin, fmt::format("a tensor has {} constants instead of {}",
                                       tensor.constants.size(), wanted));
  }

  /// A form that is said to be that of a tensor has its entries.
  void tensor_of(const FormTerm& form) {
    if (!form.tensor) return;
    const auto unknowns = unknowns_of(problem_.space);
    variables(form.tensor->factor, of_form, form.origin, "the factor of a tensor");
    if (!index(form.tensor->index, count(problem_.tensors), form.origin, "a form", "tensor") ||
        !index(form.tensor->unknown, count(unknowns), form.origin, "a tensor", "unknown"))
      return;
    const auto& tensor = problem_.tensors[static_cast<std::size_t>(form.tensor->index)];
    if (count(tensor.constants) == count_constants(tensor.kind, tensor_dim()) &&
        !has_entries_of_its_tensor(problem_, dim_, form))
      wrong(form.origin, fmt::format("the form is not that of the tensor {} that comes with it",
                                     form.tensor->index));
  }

  void form(const FormTerm& form) {
    tensor_of(form);
    part(form.part, form.origin, "a form");
    no_pair(form.part, form.origin, "a form");
    index(form.field, n_fields_, form.origin, "a form", "field");
    for (const auto& entry : form.entries) {
      derivative(entry.test, form.origin, "a form");
      derivative(entry.trial, form.origin, "a form");
      variables(entry.coefficient, of_form, form.origin, "a form");
      states_of_form(entry.coefficient, form);
    }
  }

  /// The states that an expression reads.
  std::vector<const StateTerm*> states_in(const Expr& e) const {
    std::vector<const StateTerm*> out;
    for (const Slot s : e.slots())
      if (slot::is_state(s) && s - slot::first_state < count(problem_.states))
        out.push_back(&problem_.states[static_cast<std::size_t>(s - slot::first_state)]);
    return out;
  }

  void states_of_part(const Expr& e, int part, Origin origin, std::string_view what) {
    for (const StateTerm* state : states_in(e))
      if (state->part != part)
        wrong(origin, fmt::format("{} reads the state `{}` of another part", what, state->name));
  }

  void states_of_form(const Expr& coefficient, const FormTerm& form) {
    states_of_part(coefficient, form.part, form.origin, "a form");
    only_loads_read(coefficient, form.origin, "a form");
    for (const StateTerm* state : states_in(coefficient))
      if (form.field == field_of_u(2))
        wrong(form.origin, fmt::format("the state `{}` changes a mass", state->name));
  }

  void load(const LoadTerm& load, const Allowed& allowed) {
    part(load.part, load.origin, "a load");
    no_pair(load.part, load.origin, "a load");
    for (const auto& entry : load.entries) {
      derivative(entry.test, load.origin, "a load");
      variables(entry.value, allowed, load.origin, "a load");
    }
  }

  void state_load(const LoadTerm& load) {
    this->load(load, of_state_load);
    for (const auto& entry : load.entries)
      states_of_part(entry.value, load.part, load.origin, "a load");
  }

  void history(const HistoryTerm& history) {
    const KernelSpec& kernel = history.kernel;
    variables(kernel.expression, {.time = true, .lag = true}, history.origin,
              "the kernel of a memory");
    if (kernel.series && !is_series(kernel.expression, *kernel.series))
      wrong(history.origin,
            fmt::format("the kernel `{}` is not the Prony series that comes with it", kernel.name));
  }

  void law(const LawSpec& law) {
    variables(law.expression,
              {.place = true,
               .time = true,
               .argument = true,
               .coupled = !law.coupled.empty(),
               .readings = std::min(count(law.readings), slot::most_readings),
               .law_states = count(law.states)},
              law.origin, "a law");
    if (count(law.readings) > slot::most_readings)
      wrong(law.origin, fmt::format("a law reads {} quantities, more than {}", law.readings.size(),
                                    slot::most_readings));
    const bool on_pairs = std::ranges::all_of(problem_.law_terms, [&](const LawTerm& term) {
      return term.law != &law - problem_.laws.data() || is_pair(term.part);
    });
    for (const auto& reading : law.readings) {
      variables(reading, of_report, law.origin, "what a law reads");
      for (const Slot s : reading.slots())
        if (s >= slot::first_field && !slot::is_multiplier(s) &&
            (!slot::is_field(s) || slot::field_of(s) == field_of_u(2) ||
             (slot::is_field_gradient(s) && !(on_pairs && may_be_mean(s)))))
          wrong(law.origin, "a law reads values of the unknowns, their rates and memories, and "
                            "multipliers, only");
    }
    if (count(law.states) > slot::most_law_states)
      wrong(law.origin, fmt::format("a law reads {} states; {} are the most", law.states.size(),
                                    slot::most_law_states));
    for (const int i : law.states)
      if (index(i, count(problem_.states), law.origin, "a law", "state"))
        only_loads_read(Expr::variable(slot::state(i)), law.origin, "a law");
  }

  /// What a load reads of the solution: at points of its own, read by loads alone.
  void algebraic_state(const StateTerm& state) {
    no_pair(state.part, state.origin, "a load");
    variables(state.rate, of_report, state.origin, "what a load reads");
    states_of_part(state.rate, state.part, state.origin, "a load");
    for (const Slot s : state.rate.slots())
      if (slot::is_multiplier(s) || (slot::is_field(s) && slot::field_of(s) == field_of_u(2)))
        wrong(state.origin, "a load reads unknowns, their rates, memories and gradients, only");
  }

  /// Only loads read algebraic states, which stand behind the others.
  void only_loads_read(const Expr& e, Origin origin, std::string_view what) {
    for (const StateTerm* state : states_in(e))
      if (state->algebraic)
        wrong(origin, fmt::format("{} reads `{}`, which loads alone read", what, state->name));
  }

  void state(const StateTerm& state) {
    part(state.part, state.origin, "a state");
    only_loads_read(state.rate, state.origin, "the rate of a state");
    if (state.algebraic) return algebraic_state(state);
    if (&state != problem_.states.data() && (&state - 1)->algebraic)
      wrong(state.origin, fmt::format("the state `{}` stands behind an algebraic one", state.name));
    if (problem_.time.is_static)
      wrong(state.origin, "a state changes with time, and a static problem has none");
    if (!(state.low <= state.high))
      wrong(state.origin,
            fmt::format("the state `{}` is kept in [{}, {}]", state.name, state.low, state.high));
    variables(state.initial, of_place, state.origin, "the initial value of a state");
    variables(state.rate, of_report, state.origin, "the rate of a state");
    const bool with_laws = std::ranges::any_of(
        problem_.law_terms, [&](const LawTerm& term) { return term.part == state.part; });
    for (const Slot s : state.rate.slots())
      if (with_laws && slot::is_field(s) &&
          (slot::field_of(s) > highest_derivative ||
           (slot::is_field_gradient(s) && !(is_pair(state.part) && may_be_mean(s)))))
        wrong(state.origin,
              fmt::format("the rate of `{}` reads a memory or a gradient; it may read "
                          "values of the unknown and of its rate",
                          state.name));
  }

  static bool may_be_mean(Slot s) { return slot::may_be_mean(slot::derivative_of(s)); }

  void fields_seen(const LawTerm& term) {
    if (term.seen.empty()) return;
    if (term.seen.size() != term.rows.size())
      return wrong(term.origin, "a law says of some of its rows only what they see");
    for (const auto& row : term.seen) {
      if (row.empty()) wrong(term.origin, "a row of a law sees nothing");
      for (const SeenField& seen : row) {
        index(seen.field, n_fields_, term.origin, "a law", "field");
        if (!std::isfinite(seen.times)) wrong(term.origin, "a law sees a field infinitely often");
      }
    }
  }

  void law_term(const LawTerm& term) {
    part(term.part, term.origin, "a law");
    const auto reads_gap = [](const LawTerm::Row& row) { return row.offset.depends_on(slot::gap); };
    if (!is_pair(term.part) && std::ranges::any_of(term.rows, reads_gap))
      wrong(term.origin, "a law reads the gap of a pair on another part");
    if (term.mean && !is_pair(term.part))
      wrong(term.origin, "a law acts on the mean of both sides, and on no pair");
    if (index(term.field, n_fields_, term.origin, "a law", "field") &&
        term.field != field_of_u(0) && problem_.time.is_static)
      wrong(term.origin, "a law acts on a rate or a memory, and a static problem has none");
    fields_seen(term);
    variables(term.factor, of_facet, term.origin, "the factor of a law");
    const auto unknowns = unknowns_of(problem_.space);
    const int components =
        index(term.unknown, count(unknowns), term.origin, "a law", "unknown")
            ? components_of(unknowns[static_cast<std::size_t>(term.unknown)], dim_)
            : 0;
    if (term.rule_of) index(*term.rule_of, count(unknowns), term.origin, "a rule", "unknown");
    for (const auto& row : term.rows) {
      for (std::size_t i = 0; i < row.u.size(); ++i) {
        variables(row.u[i], of_facet, term.origin, "the argument of a law");
        const int component = slot::component_of(static_cast<int>(i));
        if (component >= components && i != slot::hoop && !row.u[i].is(0.0))
          wrong(term.origin, fmt::format("the argument of a law has component {} of u, of {}",
                                         component, components));
      }
      variables(row.offset, of_argument, term.origin, "the argument of a law");
    }
    if (term.sees_gradient() && (is_pair(term.part) || term.rule == Rule::nodal))
      wrong(term.origin, "a law sees a gradient at nodes or on a pair, where there is none");
    if (!index(term.law, count(problem_.laws), term.origin, "a law term", "law")) return;
    const auto& law = problem_.laws[static_cast<std::size_t>(term.law)];
    const int most = law.radial ? slot::most_arguments : 1;
    if (term.rows.empty() || count(term.rows) > most)
      wrong(term.origin, fmt::format("the argument of a law has {} rows; {} law has {}",
                                     term.rows.size(), law.radial ? "a radial" : "a scalar",
                                     law.radial ? fmt::format("1 to {}", most) : "1"));
    if (!law.coupled.empty() &&
        std::none_of(problem_.law_terms.begin(), problem_.law_terms.end(),
                     [&](const LawTerm& other) { return other.name == law.coupled; }))
      wrong(term.origin, fmt::format("the bound of a law is the multiplier of `{}`, which is not "
                                     "among the terms",
                                     law.coupled));
  }

  void time() {
    const auto& time = problem_.time;
    if (!time.initial.empty() && count(time.initial) != components_)
      wrong(time.origin, fmt::format("the initial state has {} components instead of {}",
                                     time.initial.size(), components_));
    for (const auto& value : time.initial)
      variables(value, of_place, time.origin, "the initial state");
    motion();
  }

  void motion() {
    const auto& time = problem_.time;
    const bool moves = in_motion(problem_);
    if (needs_inertia(time.scheme) && !moves)
      wrong(time.origin,
            fmt::format("the scheme {} is for problems with a form in u''", name_of(time.scheme)));
    if (!(time.hht_alpha >= -1.0 / 3.0 && time.hht_alpha <= 0.0))
      wrong(time.origin, fmt::format("alpha of hht is {}, not between -1/3 and 0", time.hht_alpha));
    if (!time.velocity) return;
    if (!moves) wrong(time.velocity_origin, "an initial velocity, and no form in u''");
    if (count(*time.velocity) != components_)
      wrong(time.velocity_origin,
            fmt::format("the initial velocity has {} components instead of {}",
                        time.velocity->size(), components_));
    for (const auto& value : *time.velocity)
      variables(value, of_place, time.velocity_origin, "the initial velocity");
  }
};

class ReportValidation : private Validation {
public:
  ReportValidation(const Problem& problem, int dim) : Validation(problem, dim) {}

  std::vector<Failure> failures(const ReportSpec& report) && {
    for (int i = 0; i < count(report.probes); ++i)
      probe(report.probes[static_cast<std::size_t>(i)], i);
    for (const auto& table : report.tables) {
      every(table.every, table.origin);
      for (const int i : table.probes)
        index(i, count(report.probes), table.origin, "a table", "probe");
    }
    for (const auto& fields : report.fields) {
      every(fields.every, fields.origin);
      for (const auto& one : fields.fields) field(one, fields.origin);
    }
    for (const auto& picture : report.pictures) field(picture.field, picture.origin);
    for (const auto& line : report.lines) {
      for (const auto& of : line.fields) field(of, line.origin);
      if (line.points < 2) wrong(line.origin, "a line has two points or more");
    }
    return take();
  }

private:
  void field(const FieldSpec& field, Origin origin) {
    const int n = count(field.components);
    const bool tensor = n == dim_ * dim_ || (n == 9 && problem_.mesh.axisymmetric);
    if (n != 1 && n != dim_ && !tensor)
      wrong(origin, fmt::format("the field `{}` has {} components", field.name, n));
    if (!field.across.empty() && (n != 4 || field.across.size() != 3))
      wrong(origin, fmt::format("the field `{}` is no stress of plane strain", field.name));
    for (const auto* entries : {&field.components, &field.across})
      for (const auto& entry : *entries) variables(entry, of_report, origin, "a field");
  }

  void every(int steps, Origin origin) {
    if (steps < 1) wrong(origin, fmt::format("output every {} steps", steps));
  }

  void probe(const Probe& probe, int i) {
    using Kind = Probe::Kind;
    if (probe.kind == Kind::integral) part(probe.part, probe.origin, "an integral");
    if (probe.kind == Kind::largest || probe.kind == Kind::smallest)
      part(probe.part, probe.origin, "an extreme");
    if (probe.kind == Kind::reaction) part(probe.part, probe.origin, "a reaction");
    if (probe.kind == Kind::at_point && probe.part != -1) part(probe.part, probe.origin, "a point");
    if (probe.kind == Kind::norm_v || probe.kind == Kind::reaction) return;
    const Allowed allowed =
        probe.kind == Kind::combination ? Allowed{.time = true, .probes = i} : of_report;
    variables(probe.expression, allowed, probe.origin, fmt::format("`{}`", probe.name));
  }
};

} // namespace

std::vector<Failure> validate(const Problem& problem, int dim) {
  return ProblemValidation(problem, dim).failures();
}

std::vector<Failure> validate(const SolverOptions& options) {
  std::vector<Failure> out;
  const auto wrong = [&](const std::string& message) {
    out.emplace_back(FailureKind::bad_value, Origin{}, message);
  };
  const auto positive = [&](double value, std::string_view what) {
    if (!(value > 0.0) || !std::isfinite(value))
      wrong(fmt::format("the {} is {}, not positive", what, value));
  };
  positive(options.tolerance, "tolerance of the certificate");
  positive(options.memory_tolerance, "tolerance of the memory");
  if (options.threads < 1) wrong(fmt::format("{} threads", options.threads));
  return out;
}

std::vector<Failure> validate(const ReportSpec& report, const Problem& problem, int dim) {
  return ReportValidation(problem, dim).failures(report);
}

std::vector<Failure> validate(const Plan& plan, int dim) {
  auto out = validate(plan.problem, dim);
  std::ranges::move(validate(plan.options), std::back_inserter(out));
  std::ranges::move(validate(plan.report, plan.problem, dim), std::back_inserter(out));
  if (plan.start) std::ranges::move(validate(*plan.start, dim), std::back_inserter(out));
  return out;
}

} // namespace hvi::solver
