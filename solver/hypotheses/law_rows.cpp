// Rows of laws and their states, and the smallness condition (H0) on them; see hypotheses.hpp.
#include "solver/common/numbers.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/hypotheses/judgement.hpp"
#include "solver/hypotheses/states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace hvi::solver {

/// A law that no theorem here covers: all of its constants are infinite.
bool Judgement::is_beyond(const LawTerm& term) {
  const auto& spec = problem_.laws[static_cast<std::size_t>(term.law)];
  const auto& seen = term.seen;
  const bool reads = !spec.coupled.empty() || !spec.readings.empty();
  const bool apart =
      std::ranges::any_of(seen, [&](const auto& row) { return row != seen.front(); });
  if (!reads && !apart && (seen.empty() || is_rate(term.field))) return false;
  c().m_nu = c().m_tau = c().c_J = infinity;
  c().c_J_known = Bracket::exactly(infinity);
  (spec.coupled.empty() ? facts_.reads : facts_.coupled) = true;
  if (reads)
    row("H(J)", fmt::format("`{}` is a law of its argument alone", term.name), std::nullopt,
        Answer::fails, term.origin,
        spec.coupled.empty()
            ? "it reads the solution: beyond the theorems here"
            : fmt::format("its bound is the multiplier of `{}` (Coulomb): beyond the theory",
                          spec.coupled));
  else
    row("H(J)", fmt::format("`{}` sees one field", term.name), std::nullopt, Answer::fails,
        term.origin,
        apart ? "u in one component and u' in another: its force is no subgradient of one "
                "operator; beyond the theorems here"
              : "a sum of u and a memory: beyond the theorems here");
  return true;
}

/// Its rows and what it adds to the constants of all laws.
void Judgement::judge_law(const TermConstants& law, const LawTerm& term, Descents& descents) {
  if (!problem_.laws[static_cast<std::size_t>(term.law)].states.empty())
    row("H(J)", fmt::format("`{}` keeps its graph", term.name), std::nullopt, Answer::open,
        term.origin, "it changes with its states: its numbers are those at their initial values");
  const double m = law.m.value(), growth = law.c.value();
  if (term.field == field_of_u(0)) {
    double& most = law.radial ? c().m_tau : c().m_nu;
    most = std::max(most, m);
    Bracket& known = law.radial ? descents.tangential : descents.normal;
    known = larger(known, law.m);
    facts_.lipschitz = std::max(facts_.lipschitz, law.lipschitz);
  } else if (is_memory(term.field)) {
    facts_.lipschitz_memory = std::max(facts_.lipschitz_memory, law.lipschitz);
  } else {
    descents.on_rate = larger(descents.on_rate, law.m);
  }
  c().c_J = std::max(c().c_J, growth);
  c().c_J_known = larger(c().c_J_known, law.c);
  row("H(J)", fmt::format("`{}` grows linearly: c_J", term.name), growth,
      yes(std::isfinite(growth)), term.origin)
      .known = law.c;
  row("H(J)", fmt::format("`{}` is relaxed monotone: m_J", term.name), m, yes(std::isfinite(m)),
      term.origin,
      std::isfinite(m)
          ? fmt::format("steepest descent of the slope{}; regular, as j + m r^2/2 is convex",
                        m > 0.0 ? fmt::format(" at {:.6g}", law.at) : "")
      : law.jumps_down
          ? fmt::format("the slope jumps down at {:.6g}{}", law.at,
                        law.regular ? "; -j is regular" : "; neither j nor -j is regular")
      : std::isfinite(law.at)
          ? fmt::format("the slope falls infinitely steeply at {:.6g}, as a root does{}", law.at,
                        law.regular ? "; j is regular" : "")
          : "the slope falls ever more steeply far from 0")
      .known = law.m;
}

/// Laws on the unknown, or on its rate, that see gradients: M takes V into L^2 and is bounded, but
/// not compact. Empty: there are none.
std::string Judgement::not_compact(bool on_rates) const {
  for (const LawTerm& term : problem_.law_terms)
    if (is_rate(term.field) == on_rates && term.sees_gradient())
      return fmt::format("; `{}` sees a gradient: M is not compact", term.name);
  return {};
}

/// What the laws' arguments do to norms.
void Judgement::judge_traces() {
  const TraceNorms norms = numbers_.traces();
  c().norm_normal = norms.normal, c().norm_tangential = norms.tangential;
  c().norm_full = norms.full, c().norm_script = numbers_.script_norm(field_of_u(0));
  if (facts_.has_laws) {
    const std::string rough = not_compact(false);
    const char* which = facts_.has_rate_laws ? "all laws on the unknown" : "all laws";
    row("H(M)", "M is bounded and compact: ||M||^2", c().norm_script,
        yes(std::isfinite(c().norm_script) && rough.empty()), law_origin(field_of_u(0)),
        fmt::format("the arguments of {}, on this mesh; traces: normal {:.6g}, tangential {:.6g}, "
                    "full {:.6g}{}",
                    which, norms.normal, norms.tangential, norms.full, rough));
  }
  if (!facts_.has_rate_laws) return;
  const double norm = numbers_.script_norm(field_of_u(1));
  row("H(M)", "M of the laws on the rate is bounded and compact: ||M||^2", norm,
      yes(std::isfinite(norm) && not_compact(true).empty()), law_origin(field_of_u(1)),
      "on this mesh" + not_compact(true));
}

void Judgement::judge_laws() {
  c().m_nu = c().m_tau = c().c_J = 0.0;
  Descents descents;
  for (const auto& law : numbers_.laws()) {
    const auto& term = problem_.law_terms[law.term];
    if (is_beyond(term))
      descents.normal = Bracket::exactly(infinity);
    else
      judge_law(law, term, descents);
    judge_readings(law, term);
  }
  c().m_J = c().m_nu + c().m_tau;
  c().m_J_known = descents.normal + descents.tangential;
  facts_.proved = c().m_J_known.bounded_by_proof() && descents.on_rate.bounded_by_proof();
  judge_traces();
}

void Judgement::judge_states() {
  const auto with_rates = [](const StateTerm& state) { return !state.algebraic; };
  facts_.states = std::ranges::any_of(problem_.states, with_rates);
  facts_.only_time = facts_.states && std::ranges::all_of(problem_.states, [](const auto& state) {
                       return state.algebraic || is_uniform(state);
                     });
  for (const auto& form : problem_.forms)
    if (reads_states(form))
      row("H(state)", "a form keeps its coefficients", std::nullopt, Answer::open, form.origin,
          facts_.only_time
              ? "they change in time: what is said of it holds at the initial time"
              : "they change with states: what is said of it holds at their initial values");
  for (const auto& load : problem_.state_loads) judge_load(load);
  for (const auto& state : problem_.states) {
    // Time: nothing of the solution is in it. The others are a load's, which has its own rows.
    if (is_uniform(state) || state.algebraic) continue;
    const RateConstants found = rate_constants(problem_, d_.mesh, state);
    const auto rate = fmt::format("the rate of `{}` is Lipschitz in ", state.name);
    judge_variation("H(state)", rate + (found.other_states ? "the states" : "the state"),
                    found.by_states, state.origin);
    if (found.reads_inputs)
      judge_variation("H(state)", rate + "its inputs", found.by_inputs, state.origin);
  }
}

/// By the name of what a load makes of the solution (its part before values of a test function, and
/// that before gradients): how much it changes with what it reads. Empty: it reads states alone.
std::map<std::string, Variation> Judgement::variations_of(const LoadTerm& load) const {
  std::set<Slot> read;
  for (const LoadTerm::Entry& entry : load.entries)
    std::ranges::copy_if(entry.value.slots(), std::inserter(read, read.end()), slot::is_state);
  std::map<std::string, Variation> out;
  for (const Slot s : read) {
    const auto& state = problem_.states[static_cast<std::size_t>(s - slot::first_state)];
    if (!state.algebraic) continue;
    const Variation entry = rate_constants(problem_, d_.mesh, state).by_inputs;
    const auto [known, fresh] = out.try_emplace(state.name, entry);
    if (!fresh) known->second = larger(known->second, entry);
  }
  return out;
}

void Judgement::judge_load(const LoadTerm& load) {
  const auto variations = variations_of(load);
  const bool reads = !variations.empty();
  facts_.loads_read = facts_.loads_read || reads;
  row(reads ? "H(f)" : "H(state)", "a load does not depend on the solution", std::nullopt,
      Answer::open, load.origin,
      reads              ? "it reads it: what is said of f leaves it out"
      : facts_.only_time ? "it reads states that change in time alone"
                         : "it reads states: what is said of f leaves it out");
  for (const auto& [name, found] : variations)
    judge_variation("H(f)", fmt::format("the {} is Lipschitz in what it reads", name), found,
                    load.origin);
}

void Judgement::judge_variation(const char* name, const std::string& what, const Variation& found,
                                const Origin& origin) {
  const double everywhere = found.everywhere.value();
  const bool finite = std::isfinite(everywhere);
  std::string note;
  if (found.jumps != Jumps::none)
    note = found.jumps == Jumps::found ? "it jumps" : "where it does not jump, which is not known";
  else if (!finite)
    note = fmt::format("on bounded sets only: {} for inputs up to 1 in size",
                       with_word(found.near.value(), found.near));
  const Answer answer = note.empty() ? Answer::holds : Answer::open;
  auto& made = row(name, what, everywhere, answer, origin, std::move(note));
  if (finite) made.known = found.everywhere;
}

void Judgement::judge_readings(const TermConstants& law, const LawTerm& term) {
  const SlopeConstants found = slope_constants(problem_, d_.mesh, term, law.lipschitz);
  const auto& coupled = problem_.laws[static_cast<std::size_t>(term.law)].coupled;
  if (found.reads_states)
    judge_variation("H(state)",
                    fmt::format("`{}` is Lipschitz in the states that it reads", term.name),
                    found.by_states, term.origin);
  if (found.reads)
    judge_variation("H(J)",
                    fmt::format("`{}` is Lipschitz in {}", term.name,
                                coupled.empty() ? "what it reads"
                                                : fmt::format("the multiplier of `{}`", coupled)),
                    found.by_readings, term.origin);
}

Origin Judgement::law_on_memory() const {
  return std::ranges::find_if(problem_.law_terms,
                              [](const LawTerm& term) { return is_memory(term.field); })
      ->origin;
}

Origin Judgement::law_origin(int field) const {
  return std::ranges::find(problem_.law_terms, field, &LawTerm::field)->origin;
}

Origin Judgement::worst_law() const {
  Origin out = problem_.time.origin;
  double most = -1.0;
  for (const auto& law : numbers_.laws()) {
    const auto& term = problem_.law_terms[law.term];
    if (term.field == field_of_u(0) && law.m.value() > most)
      most = law.m.value(), out = term.origin;
  }
  return out;
}

void Judgement::judge_smallness() {
  Margins& m = out_.margins;
  const double m_b = c().m_B;
  const auto less = [&](double softening, double norm) {
    return softening == 0.0 ? m_b : std::isfinite(softening) ? m_b - softening * norm : -infinity;
  };
  m.paper = less(c().m_J, std::max(c().norm_full, c().norm_script));
  m.largest = less(std::max(c().m_nu, c().m_tau), c().norm_script);
  m.split = numbers_.margin_split(field_of_u(0), m_b);
  m.against_b = m_b > 0.0 ? numbers_.margin_against(field_of_u(0)) : -infinity;
  const Origin origin = worst_law();
  row("(H0)", "m_B - (m_nu + m_tau) ||M||^2, full trace", m.paper, positive(m.paper), origin);
  row("(H0)", "m_B - max(m_nu, m_tau) ||M||^2, the script's M", m.largest, positive(m.largest),
      origin, "its parts are orthogonal: the larger constant suffices");
  row("(H0)", "m_B - lambda_max(sum m_i M_i^T W M_i)", m.split, positive(m.split), origin,
      "the split condition: each law against its own trace");
  row("(H0)", "1 - lambda_max(sum m_i M_i^T W M_i, sym B)", m.against_b, positive(m.against_b),
      origin, "the same against B itself");
  judge_other_laws();
}

void Judgement::judge_other_laws() {
  Margins& m = out_.margins;
  m.rate_split = c().m_A, m.rate_against_a = 1.0;
  if (facts_.has_memory_laws)
    row("memory", "the slopes of the laws on memories are Lipschitz: their constant",
        facts_.lipschitz_memory, yes(std::isfinite(facts_.lipschitz_memory)), law_on_memory(),
        "then they are a part of the history, as R is");
  if (!facts_.has_rate_laws) return;
  m.rate_split = numbers_.margin_split(field_of_u(1), c().m_A);
  m.rate_against_a = c().m_A > 0.0 ? numbers_.margin_against(field_of_u(1)) : -infinity;
  const Origin origin = law_origin(field_of_u(1));
  row("rates", "m_A - lambda_max(sum m_i M_i^T W M_i), laws on u'", m.rate_split,
      positive(m.rate_split), origin, "what (H0) asks of laws on the rate: m_A > m_J ||M||^2");
  row("rates", "1 - lambda_max(sum m_i M_i^T W M_i, sym A), laws on u'", m.rate_against_a,
      positive(m.rate_against_a), origin, "the same against A itself");
  if (facts_.has_laws)
    row("rates", "the slopes of the laws on u are Lipschitz: their constant", facts_.lipschitz,
        yes(std::isfinite(facts_.lipschitz)), law_origin(field_of_u(0)),
        "beside a law on the rate they are a part of the history");
}

} // namespace hvi::solver
