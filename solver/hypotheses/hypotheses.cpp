// The hypotheses of the existence theorem as numbers: forms, memories and loads; see
// hypotheses.hpp. Rows of laws are in law_rows.cpp, of rigid motions and multipliers in
// held_rows.cpp, of steps in step_rows.cpp, those that ask a refined mesh in refined_rows.cpp.
//
// Paper: H(A), H(B), H(E), H(q), H(J), H(M), H(f), (H0), Theorem existencetheorem, Lemma lem3.1.
#include "solver/common/numbers.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/contact_states.hpp"
#include "solver/discrete/proportional.hpp"
#include "solver/fem/periodic.hpp"
#include "solver/history/norm_proofs.hpp"
#include "solver/hypotheses/judgement.hpp"
#include "solver/hypotheses/load_space.hpp"
#include "solver/hypotheses/load_time.hpp"
#include "solver/plan/couplings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

std::string with_word(double value, const Bracket& known) {
  if (!std::isfinite(value)) return "inf";
  if (known.how() != Provenance::between)
    return fmt::format("{:.6g} ({})", value, word(known.how()));
  return fmt::format("{:.6g} ({} {:.6g} and {:.6g})", value, word(known.how()), known.low,
                     known.high);
}

HypothesisReport Judgement::report(bool extrapolate) {
  longest_step();
  steps_ = step_weights(problem_);
  judge_space();
  judge_inertia();
  judge_a();
  judge_b();
  judge_multipliers();
  judge_memory();
  judge_laws();
  judge_free_body();
  judge_states();
  judge_loads();
  judge_given();
  judge_smallness();
  judge_steps();
  if (extrapolate) refine_norms();
  judge_rate();
  give_verdicts(facts_, out_);
  return std::move(out_);
}

Origin Judgement::form_origin(int field) const {
  for (const auto& form : problem_.forms)
    if (form.field == field) return form.origin;
  return problem_.time.origin;
}

Hypothesis& Judgement::row(std::string name, std::string what, std::optional<double> value,
                           Answer answer, Origin origin, std::string note) {
  out_.hypotheses.push_back(
      {std::move(name), std::move(what), value, answer, origin, std::move(note)});
  return out_.hypotheses.back();
}

void Judgement::longest_step() {
  c().longest_step = 0.0;
  const auto& grid = problem_.time.grid;
  for (std::size_t n = 1; n < grid.size(); ++n)
    c().longest_step = std::max(c().longest_step, grid[n] - grid[n - 1]);
}

std::string Judgement::place(const Ellipticity& e) const {
  return e.varies ? fmt::format(", least at {}", describe_point(e.at, d_.mesh.dim)) : std::string();
}

/// Values that repeat make V smaller, and closed as before: nothing else changes.
void Judgement::judge_space() {
  for (const PeriodicNote& note : periodic_notes(d_.space, problem_, d_.parts))
    row("V", note.condition, std::nullopt, Answer::holds, note.origin, note.found);
}

void Judgement::judge_inertia() {
  if (!facts_.moves) return;
  const Origin origin = form_origin(field_of_u(2));
  const double defect = numbers_.asymmetry(field_of_u(2));
  row("H(rho)", "the mass is symmetric: its defect", defect, yes(defect <= 1e-12), origin);
  const double in_h = numbers_.coercivity_in_h(field_of_u(2));
  std::string with_mass;
  const auto unknowns = unknowns_of(problem_.space);
  for (std::size_t b = 0; b < unknowns.size() && unknowns.size() > 1; ++b)
    if (has_inertia(problem_, static_cast<int>(b)))
      with_mass += (with_mass.empty() ? "of " : " and ") + unknowns[b].name;
  row("H(rho)", "the mass is coercive in H = L2: m_rho", in_h, positive(in_h), origin, with_mass);
}

void Judgement::judge_a() {
  const auto tensor = ellipticity(problem_, d_, field_of_u(1));
  c().m_1 = std::isfinite(tensor.least) ? tensor.least : not_a_number;
  c().m_A = numbers_.coercivity(field_of_u(1), c().m_1);
  if (!numbers_.acts_on(field_of_u(1))) {
    row("H(A)", "A is coercive", std::nullopt, Answer::open, problem_.time.origin,
        problem_.time.is_static ? "static: no A is asked for"
        : facts_.moves          ? "there is no term with u': nothing damps the motion"
                                : "there is no term with u': static at each t, no A is asked for");
    return;
  }
  const Origin origin = form_origin(field_of_u(1));
  const double defect = numbers_.asymmetry(field_of_u(1));
  row("H(A)", "A is symmetric: its defect", defect, yes(defect <= 1e-12), origin);
  facts_.skew_rates = numbers_.has_several_unknowns() && defect > 1e-12;
  rate_row_ = out_.hypotheses.size();
  row("H(A)", "A is coercive in V: m_A", c().m_A, positive(c().m_A), origin,
      std::isfinite(tensor.least)
          ? fmt::format("pointwise m_1 = {:.6g}{}", tensor.least, place(tensor))
          : std::string());
}

/// Is the form coercive on this mesh only? Each unknown on its own: what one of them has in its
/// units hides what another one loses. In words, where the refined mesh tells.
std::optional<std::string> Judgement::falls_with_the_mesh() const {
  if (a_finer_.empty()) return "";
  const auto here = numbers_.own_coercivities(field_of_u(1));
  for (std::size_t b = 0; b < here.size(); ++b)
    if (here[b] != infinity && !(a_finer_[b] > 0.7 * here[b]))
      return here.size() == 1
                 ? fmt::format(", {:.6g} on the refined", a_finer_[b])
                 : fmt::format(", of `{}` {:.6g} and {:.6g} on the refined",
                               unknowns_of(problem_.space)[b].name, here[b], a_finer_[b]);
  return std::nullopt;
}

void Judgement::judge_rate() {
  if (!numbers_.acts_on(field_of_u(1))) return;
  auto& answer = out_.hypotheses[rate_row_];
  const auto falls = c().m_1 > 0.0 ? std::nullopt : falls_with_the_mesh();
  if (c().m_A > 0.0 && !falls) {
    out_.rate_form = RateForm::in_v;
    return;
  }
  if (facts_.moves && c().m_1 > 0.0) { // rigid motions are free, and have mass
    out_.rate_form = RateForm::in_v;
    answer.answer = Answer::holds;
    answer.note += "; with m_1 times the mass of H it is (Korn), which is enough beside inertia";
    return;
  }
  const double in_h = numbers_.coercivity_in_h(field_of_u(1));
  const double in_h_finer = m_h_finer_.value_or(in_h);
  const bool in_l2 = numbers_.free_body() == nullptr && in_h > 0.0 && in_h_finer > 0.7 * in_h;
  out_.rate_form = in_l2 ? RateForm::in_h : RateForm::weak;
  answer.answer = Answer::fails;
  if (c().m_A > 0.0)
    answer.note += fmt::format("{}on this mesh only{}: A holds no gradient everywhere",
                               answer.note.empty() ? "" : "; ", falls.value_or(""));
  row("H(A)", "A is coercive in H = L2: m_H", in_h, yes(in_l2), answer.origin,
      in_l2 ? "the evolution is parabolic: see `theorem`" : "");
}

void Judgement::judge_b() {
  const auto tensor = ellipticity(problem_, d_, field_of_u(0));
  c().m_2 = std::isfinite(tensor.least) ? tensor.least : not_a_number;
  c().m_B = numbers_.coercivity(field_of_u(0), c().m_2);
  if (!numbers_.acts_on(field_of_u(0))) {
    row("H(B)", "B is coercive", std::nullopt, Answer::fails, problem_.time.origin,
        "there is no term with u itself");
    return;
  }
  const double defect = numbers_.asymmetry(field_of_u(0));
  std::string note;
  if (std::isfinite(tensor.least))
    note = fmt::format("pointwise m_2 = {:.6g}{}", tensor.least, place(tensor));
  if (defect > 1e-12)
    note += fmt::format("{}not symmetric ({:.2g}), which the theory does not ask for",
                        note.empty() ? "" : "; ", defect);
  row("H(B)", "B is coercive: m_B", c().m_B, positive(c().m_B), form_origin(field_of_u(0)), note);
}

void Judgement::judge_memory() {
  c().c_E = c().c_q = c().lipschitz_q = c().memory_step = 0.0;
  const auto& grid = problem_.time.grid;
  for (std::size_t m = 0; m < problem_.histories.size(); ++m) {
    const auto& kernel = problem_.histories[m].kernel;
    const double e = numbers_.memory_norm(static_cast<int>(m));
    const auto norms = kernel_norms(kernel.expression, grid.front(), grid.back());
    const auto known = prove_norms(kernel.expression, norms, grid.front(), grid.back());
    const double sup = known.sup.value(), slope = known.lipschitz.value();
    c().c_E = std::max(c().c_E, e);
    c().c_q = std::max(c().c_q, sup);
    c().lipschitz_q = std::max(c().lipschitz_q, slope);
    memory_norms_.push_back(e);
    product_ += e * sup;
    facts_.has_memory = facts_.has_memory || e > 0.0;
    facts_.integrable = facts_.integrable && std::isfinite(norms.l1);
    row("H(E)", fmt::format("E of `{}` is bounded: ||E||", kernel.name), e, yes(std::isfinite(e)),
        problem_.histories[m].origin);
    const bool lipschitz = std::isfinite(slope);
    auto& h = row(
        "H(q)", fmt::format("`{}` is Lipschitz in t: its constant", kernel.name), slope,
        yes(lipschitz), problem_.histories[m].origin,
        fmt::format("sup |q| = {}, int |q| = {}{}", with_word(sup, known.sup),
                    with_word(known.l1.value(), known.l1),
                    lipschitz ? ""
                              : "; singular: the continuous theorem and the bounds tau_0 do not "
                                "apply, each step's problem and its certificate do"));
    if (lipschitz) h.known = known.lipschitz;
    judge_modulus(static_cast<int>(m));
  }
}

double Judgement::memory_against_elasticity(int m) const {
  const FormTerm *elastic = nullptr, *memory = nullptr;
  int forms = 0;
  for (const FormTerm& form : problem_.forms) {
    if (form.field == field_of_u(0)) elastic = &form, ++forms;
    if (form.field == field_of_memory(m)) memory = &form, ++forms;
  }
  if (elastic && memory && forms == 2)
    if (const auto ratio = symbolic_ratio(*memory, *elastic)) return *ratio;
  const double b = numbers_.of_field(field_of_u(0)).diagonal().sum(),
               e = numbers_.of_field(field_of_memory(m)).diagonal().sum();
  return b != 0.0 ? e / b : 0.0;
}

void Judgement::judge_modulus(int m) {
  if (!numbers_.acts_on(field_of_u(0))) return;
  const auto& grid = problem_.time.grid;
  const auto& kernel = problem_.histories[static_cast<std::size_t>(m)].kernel;
  const double horizon = grid.back() - grid.front();
  if (!kernel_traits(kernel, horizon).convolution) return;
  const double ratio = memory_against_elasticity(m);
  const auto relaxed = [&](double lag) {
    return 1.0 + ratio * interval_integral(kernel.expression, grid.front() + lag, 0.0, lag, 0);
  };
  const double soon = 1e-9 * horizon, at_once = relaxed(soon) - 1.0, late = relaxed(horizon);
  const Origin origin = problem_.histories[static_cast<std::size_t>(m)].origin;
  if (at_once > 0.0)
    row("memory", fmt::format("`{}` relaxes: 1 + int q at the end", kernel.name), late,
        Answer::open, origin,
        "positive at lag 0 against its tensor: this memory stiffens the body. Beside the "
        "instantaneous B a relaxation has the sign -, as in `kernel C(lag) = -0.3*exp(-lag) * "
        "B`; "
        "the usual weights of a Prony series belong to the relaxation function, not to its "
        "derivative");
  if (late < 0.0) {
    double low = 0.0, high = horizon;
    for (int i = 0; i < 40; ++i)
      (relaxed(0.5 * (low + high)) < 0.0 ? high : low) = 0.5 * (low + high);
    row("memory", fmt::format("`{}` leaves a positive modulus: 1 + int q at the end", kernel.name),
        late, Answer::fails, origin,
        fmt::format("held for longer than {:.6g} a strain meets a negative modulus; the kernel "
                    "is meant for shorter times",
                    high));
  }
}

void Judgement::judge_loads() {
  if (judge_load_places() || judge_load_times()) return;
  Vector f = Vector::Zero(d_.space.n_dofs());
  const LoadAssembler loads(d_.space, d_.parts, problem_.loads);
  const Origin origin =
      problem_.loads.empty() ? problem_.time.origin : problem_.loads.front().origin;
  try {
    const auto& grid = problem_.time.grid;
    const std::size_t stride = std::max<std::size_t>(1, grid.size() / most_load_times);
    for (std::size_t n = 0; n < grid.size(); n += stride) loads.add(grid[n], f);
    if (grid.empty()) loads.add(0.0, f);
    row("H(f)", "f is finite at the grid's times", std::nullopt, Answer::holds, origin);
  } catch (const Failure& failure) {
    row("H(f)", "f is finite at the grid's times", std::nullopt, Answer::fails, failure.origin,
        failure.what());
  }
}

namespace {

bool reads_state(const Expr& offset) {
  return std::ranges::any_of(offset.slots(), [](Slot s) { return slot::is_state(s); });
}

} // namespace

/// Imposed values, offsets of laws, forms and rates of states that change in time: those of the
/// first step are known by now. What states bring into them is known in a run only.
void Judgement::judge_given() {
  const auto moves = [](const Expr& e) { return e.depends_on(slot::t); };
  const bool values = std::ranges::any_of(problem_.space.dirichlet, [&](const DirichletSpec& d) {
    return std::ranges::any_of(d.value, moves);
  });
  std::vector<const ContactTerm*> offsets;
  for (const ContactTerm& term : numbers_.contact().terms) {
    const auto& rows = problem_.law_terms[static_cast<std::size_t>(term.points.law_term)].rows;
    if (std::ranges::any_of(rows, [&](const auto& r) { return moves(r.offset); }) &&
        std::ranges::none_of(rows, [](const auto& r) { return reads_state(r.offset); }))
      offsets.push_back(&term);
  }
  const auto& grid = problem_.time.grid;
  const std::size_t stride = std::max<std::size_t>(1, grid.size() / most_load_times);
  Vector u = Vector::Zero(d_.space.n_dofs()), moved;
  TimedForms forms(problem_, d_, numbers_.contact());
  try {
    for (std::size_t n = 0; n < grid.size(); n += stride) {
      if (values) impose(d_.space, problem_.space, d_.dofs, grid[n], u);
      for (const ContactTerm* term : offsets)
        law_offsets(term->points,
                    problem_.law_terms[static_cast<std::size_t>(term->points.law_term)], grid[n],
                    moved);
      if (n == 0) continue; // the equations of a step are those of its end
      if (!forms.none()) forms.check(grid[n]);
      check_given_rates(problem_, numbers_.contact(), grid[n]);
    }
  } catch (const Failure& failure) {
    row("given", "what is given in time is finite at the grid's times", std::nullopt, Answer::fails,
        failure.origin, failure.what());
  }
}

bool Judgement::judge_load_places() {
  for (const LoadTerm& load : problem_.loads) {
    const auto pole = space_pole(problem_, d_, load);
    if (!pole) continue;
    row("H(f)", "f is a functional on V", std::nullopt, Answer::fails, load.origin,
        describe_pole(*pole, d_.mesh.dim));
    return true;
  }
  return false;
}

bool Judgement::judge_load_times() {
  const auto& grid = problem_.time.grid;
  if (grid.size() < 2) return false;
  const LoadTerm* where = nullptr;
  TimeSingularity worst;
  for (const LoadTerm& load : problem_.loads)
    for (const auto& entry : load.entries)
      if (const auto s = time_singularity(entry.value, grid.front(), grid.back());
          s && (!where || s->exponent > worst.exponent))
        worst = *s, where = &load;
  if (!where) return false;
  const bool holds = worst.square_integrable();
  row("H(f)", "f is square integrable in time", std::nullopt, yes(holds), where->origin,
      fmt::format("it grows like |t - {:.6g}|^-{:.4g}{}", worst.at, worst.exponent,
                  holds ? ", an exponent below 1/2; `using load = average` takes its means"
                        : ", and 1/2 or more is too much"));
  return true;
}

HypothesisReport check_hypotheses(const Plan& plan, const Discretisation& discretisation,
                                  bool extrapolate) {
  return Judgement(plan, discretisation).report(extrapolate);
}

} // namespace hvi::solver
