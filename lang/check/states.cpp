#include "lang/check/states.hpp"

#include "solver/plan/membership.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// What a rate reads that its points do not know; "" when there is nothing.
std::string out_of_reach(solver::Slot s, bool in_body, bool on_pair) {
  if (s == slot::gap) return "the gap of a pair";
  if (s >= slot::first_probe) return "an integral";
  if (in_body || !slot::is_field(s)) return {};
  if (solver::is_memory(slot::field_of(s))) return "a memory";
  const bool gradient =
      slot::is_field_gradient(s) && !(on_pair && slot::may_be_mean(slot::derivative_of(s)));
  return gradient ? "a gradient of the unknown" : "";
}

/// A help.
std::string readable_in_rate(bool in_body, std::optional<solver::Group::Kind> kind,
                             const std::string& u) {
  if (in_body)
    return fmt::format(
        "it may read states, x, t, `{0}`, `eps({0})`, `sigma`, memories and the like", u);
  if (kind == solver::Group::Kind::cells)
    return fmt::format("a law acts on these cells, and the state is that of the law's points: it "
                       "may read states, x, t, `{0}`, `{0}'` and multipliers of laws there; on a "
                       "part without a law gradients and memories, too",
                       u);
  return fmt::format("it may read states, x, t, `{0}.nu`, `{0}'.tau` and the like, and multipliers "
                     "of laws on its part",
                     u);
}

} // namespace

Value States::state(int declaration) {
  const auto& written = std::get<ast::State>(*names_[declaration].statement);
  const auto part = parts_.index_of(written.part);
  if (!part) return Poison{};
  ModelState out;
  out.declaration = declaration;
  out.span = written.span;
  out.rate_span = written.rate.span;
  out.spec.origin = model_.origin(written.name.span);
  out.spec.name = written.name.text;
  out.spec.part = *part;
  model_.states.push_back(std::move(out));
  return scalar_field(Symbol::variable(slot::state(static_cast<int>(model_.states.size()) - 1)));
}

void States::read_rates() {
  for (int i = 0; i < names_.size(); ++i) {
    if (!std::holds_alternative<ast::State>(*names_[i].statement)) continue;
    const bool used = names_[i].used;
    evaluator_.value_of(i, names_[i].span);
    names_[i].used = used;
  }
  for (std::size_t i = 0; i < model_.states.size(); ++i) {
    ModelState state = model_.states[i]; // rates may add others
    if (state.declaration < 0) continue; // a clock
    if (!find_->time) {
      mistakes_.error("E0412", state.span,
                      fmt::format("the state `{}` changes with time, and a static problem has none",
                                  state.spec.name),
                      "add `for t in [0, T] by N steps from u = 0` to the find statement");
      continue;
    }
    state_rate(state);
    state_range(state);
    state_initial(state);
    model_.states[i] = std::move(state);
  }
}

void States::state_rate(ModelState& state) {
  const auto& written = std::get<ast::State>(*names_[state.declaration].statement);
  Scope scope;
  scope.what = "the rate of a state";
  scope.position = scope.time = scope.unknown = scope.report = scope.states = true;
  scope.part = state.spec.part;
  const auto kind = model_.parts[state.spec.part].kind;
  scope.normal = kind.value_or(solver::Group::Kind::facets) == solver::Group::Kind::facets;
  const bool read_by_others = names_[state.declaration].used;
  at_hand_.gap = state.spec.part;
  auto rate = evaluator_.scalar(written.rate, scope);
  names_[state.declaration].used = read_by_others;
  if (!rate || !pairs_.take_jumps(written.rate.span, rate->components, state.spec.part)) return;
  Symbol expression = rate->scalar();
  const bool in_body = lives_in_body(state.spec.part);
  for (const solver::Slot s : solver::slots_of(expression))
    if (const std::string what = out_of_reach(s, in_body, pairs_.is_pair(state.spec.part));
        !what.empty()) {
      mistakes_.error("E0428", written.rate.span,
                      fmt::format("the rate of `{}` reads {}", state.spec.name, what),
                      readable_in_rate(in_body, kind, unknowns_.name_of(0)));
      return;
    }
  if (!multipliers_.take_on_part(written.rate.span, state.spec.part, expression)) return;
  if (!reads_states_of(written.rate.span, expression, state.spec.part,
                       fmt::format("the rate of `{}`", state.spec.name)))
    return;
  state.spec.rate = expression;
}

void States::state_range(ModelState& state) {
  const auto& written = std::get<ast::State>(*names_[state.declaration].statement);
  if (!written.range) return;
  const auto ends = evaluator_.constant_list(*written.range, "the range of a state");
  if (!ends) return;
  if (ends->size() != 2 || (*ends)[0] > (*ends)[1]) {
    mistakes_.error("E0408", written.range->span, "the range of a state is `[least, greatest]`");
    return;
  }
  state.spec.low = (*ends)[0], state.spec.high = (*ends)[1];
}

void States::state_initial(ModelState& state) {
  const auto& written = std::get<ast::State>(*names_[state.declaration].statement);
  const ast::InitialValue& initial = written.initial;
  if (initial.unknown.text != state.spec.name) {
    mistakes_.error("E0301", initial.unknown.span,
                    fmt::format("the initial value is that of the state `{}`, not of `{}`",
                                state.spec.name, initial.unknown.text));
    return;
  }
  Scope scope;
  scope.what = "the initial value of a state";
  scope.position = true;
  auto value = evaluator_.scalar(initial.value, scope);
  if (!value) return;
  state.spec.initial = value->scalar();
  if (!state.spec.initial.is_constant()) return; // looked at on the mesh
  const double v = state.spec.initial.value();
  if (v < state.spec.low || v > state.spec.high)
    mistakes_.error("E0408", initial.value.span,
                    fmt::format("`{}` begins with {}, outside its range [{}, {}]", state.spec.name,
                                v, state.spec.low, state.spec.high));
}

Symbol States::without_states_of_bodies(Symbol expression, int part) const {
  if (pairs_.is_pair(part)) return expression;
  for (const solver::Slot s : solver::slots_of(Symbol(expression)))
    if (slot::is_state(s) &&
        lives_in_body(model_.states[static_cast<std::size_t>(s - slot::first_state)].spec.part))
      expression = substitute(expression, std::array{std::pair{s, Symbol(0.0)}});
  return expression;
}

bool States::reads_states_of(const Span& span, const Symbol& expression, int part,
                             const std::string& who) {
  for (const solver::Slot s : solver::slots_of(expression)) {
    if (!slot::is_state(s)) continue;
    const auto& state = model_.states[static_cast<std::size_t>(s - slot::first_state)].spec;
    if (state.part == part) continue;
    mistakes_.error(
        "E0429", span,
        fmt::format("{} on `{}` reads the state `{}` of `{}`", who, model_.parts[part].name,
                    state.name, model_.parts[state.part].name),
        fmt::format("a state is known on its own part only: `{}`", model_.parts[state.part].name));
    return false;
  }
  return true;
}

std::optional<std::vector<int>> States::take_states(Symbol& expression, const Span& span) {
  std::vector<int> out;
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  for (const solver::Slot s : solver::slots_of(expression)) {
    if (!slot::is_state(s)) continue;
    if (out.size() == slot::most_law_states) {
      mistakes_.error(
          "E0306", span,
          fmt::format("a superpotential reads {} states at most", slot::most_law_states));
      return std::nullopt;
    }
    rename.emplace_back(s, Symbol::variable(slot::law_state(static_cast<int>(out.size()))));
    out.push_back(s - slot::first_state);
  }
  if (!rename.empty()) expression = substitute(expression, rename);
  return out;
}

/// Do states of a part live inside its cells? Else at the points of its laws.
bool States::lives_in_body(int part) const {
  return model_.parts[part].kind == solver::Group::Kind::cells &&
         std::none_of(model_.terms.begin(), model_.terms.end(), [&](const ModelTerm& term) {
           return term.part == part && !term.integrand.laws.empty();
         });
}

bool States::states_of_form(const ModelTerm& term, const Span& span) {
  const Symbol integrand = term.integrand.scalar();
  if (!integrand.depends_on_any(slot::first_state, slot::first_probe)) return true;
  if (!reads_states_of(span, integrand, term.part, "the form")) return false;
  for (const solver::Slot s : solver::slots_of(integrand)) {
    if (!slot::is_field(s) || slot::field_of(s) != solver::field_of_u(2)) continue;
    if (!derivative(integrand, s).depends_on_any(slot::first_state, slot::first_probe)) continue;
    mistakes_.error("E0309", span, "a state stands in the inertia",
                    "a mass that changes is not the problem of the theory");
    return false;
  }
  return true;
}

/// The state of a body that is t at every time: its rate is 1.
Symbol States::clock_on(int part) {
  const auto [known, fresh] = clocks_.try_emplace(part, static_cast<int>(model_.states.size()));
  if (fresh) {
    ModelState clock;
    clock.span = model_.parts[static_cast<std::size_t>(part)].span;
    clock.rate_span = clock.span;
    clock.spec.origin = model_.origin(clock.span);
    clock.spec.name = "t on " + model_.parts[static_cast<std::size_t>(part)].name;
    clock.spec.part = part;
    clock.spec.rate = 1.0;
    clock.spec.initial = model_.time.grid.empty() ? 0.0 : model_.time.grid.front();
    model_.states.push_back(std::move(clock));
  }
  return Symbol::variable(slot::state(known->second));
}

bool States::take_time(ModelTerm& term, const Span& span) {
  if (term.integrand.rank != 0 || !find_->time) return true;
  const Symbol integrand = term.integrand.scalar();
  std::vector<std::pair<solver::Slot, Symbol>> at_rest;
  bool timed = term.factor.depends_on(slot::t), inertia = false;
  for (const solver::Slot s : solver::slots_of(integrand)) {
    if (!slot::is_field(s)) continue;
    at_rest.emplace_back(s, Symbol(0.0));
    if (!derivative(integrand, s).depends_on(slot::t)) continue;
    timed = true;
    inertia = inertia || slot::field_of(s) == solver::field_of_u(2);
  }
  if (at_rest.empty() || !timed) return true;
  if (!term.integrand.laws.empty() && term.factor.depends_on(slot::t)) return true; // law_factors
  const auto refuse = [&](const char* what, const char* help) {
    mistakes_.error("E0413", span, what, help);
    return false;
  };
  if (inertia)
    return refuse("a mass that changes in time is not the problem of the theory",
                  "a rate of the density is a term of its own, in u'");
  if (model_.parts[static_cast<std::size_t>(term.part)].kind != solver::Group::Kind::cells)
    return refuse("a form that changes in time stands on cells",
                  "on a boundary a superpotential may depend on t: `bed(r) = 0.5*(1 + t)*r^2`");
  if (!substitute(integrand, at_rest).is(0.0))
    return refuse("a form that changes in time stands alone in its integral",
                  "give what does not contain the unknown an integral of its own");
  const std::vector<std::pair<solver::Slot, Symbol>> clock{{slot::t, clock_on(term.part)}};
  term.integrand.components.front() = substitute(term.factor * integrand, clock);
  for (MaterialUse& use : term.integrand.materials)
    use.factor = substitute(term.factor * use.factor, clock);
  term.factor = 1.0;
  return true;
}

void States::check_states_of_laws() {
  std::set<int> with_laws;
  std::set<int> read_elsewhere; // which is told, and why their own parts have no law
  for (const ModelTerm& term : model_.terms) {
    if (term.integrand.scalar().depends_on_any(slot::first_state, slot::first_probe))
      check_changing_form(term);
    for (const LawUse& use : term.integrand.laws) {
      with_laws.insert(term.part);
      Symbol all = 0.0; // of everything that the law reads
      for (const int i : model_.laws[use.law].spec.states)
        all = all + Symbol::variable(slot::state(i));
      for (const LawRow& row : use.rows) all = all + row.offset;
      if (!reads_states_of(use.span, all, term.part, fmt::format("the law `{}`", use.name)))
        for (const solver::Slot s : solver::slots_of(all))
          if (slot::is_state(s)) read_elsewhere.insert(s - slot::first_state);
    }
  }
  for (int i = 0; i < std::ssize(model_.states); ++i)
    if (const ModelState& state = model_.states[static_cast<std::size_t>(i)];
        state.declaration >= 0 && with_laws.count(state.spec.part) == 0 &&
        read_elsewhere.count(i) == 0 && !lives_in_body(state.spec.part))
      mistakes_.error("E0430", names_[state.declaration].span,
                      fmt::format("no law acts on `{}`, where the state `{}` is to live",
                                  model_.parts[state.spec.part].name, state.spec.name),
                      "a state lives inside a body or at the points of a law: put one on its part");
}

/// Time is the same at all points, whichever they are.
void States::check_changing_form(const ModelTerm& term) {
  const auto slots = solver::slots_of(term.integrand.scalar());
  const bool time_alone = std::ranges::all_of(slots, [&](solver::Slot s) {
    return !slot::is_state(s) ||
           model_.states[static_cast<std::size_t>(s - slot::first_state)].declaration < 0;
  });
  const bool on_cells = model_.parts[term.part].kind == solver::Group::Kind::cells;
  if (lives_in_body(term.part) || (time_alone && on_cells)) return;
  mistakes_.error(
      "E0430", term.span,
      fmt::format("this form reads a state that lives at the points of the laws on `{}`",
                  model_.parts[term.part].name),
      "let the laws act on another part");
}

} // namespace hvi::lang
