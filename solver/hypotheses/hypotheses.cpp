// The hypotheses of the existence theorem as numbers; see hypotheses.hpp.
//
// Paper: H(A), H(B), H(E), H(q), H(J), H(M), H(f), (H0), Theorem existencetheorem, Lemma lem3.1.
#include "solver/hypotheses/hypotheses.hpp"

#include "solver/common/numbers.hpp"
#include "solver/history/norm_proofs.hpp"
#include "solver/hypotheses/load_time.hpp"
#include "solver/hypotheses/numbers.hpp"
#include "solver/hypotheses/states.hpp"
#include "solver/hypotheses/tensors.hpp"
#include "solver/hypotheses/verdicts.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/time/body_states.hpp"
#include "solver/time/step_weights.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr int most_load_times = 65;
/// Below it an unknown without a form of its own has parts that the others do not see.
constexpr double smallest_inf_sup = 1e-6;

Origin form_origin(const Problem& problem, int field) {
  for (const auto& form : problem.forms)
    if (form.field == field) return form.origin;
  return problem.time.origin;
}

/// A number of a kernel with how it was found.
std::string with_word(double value, const Bracket& known) {
  if (!std::isfinite(value)) return "inf";
  if (known.how() != Provenance::between)
    return fmt::format("{:.6g} ({})", value, word(known.how()));
  return fmt::format("{:.6g} ({} {:.6g} and {:.6g})", value, word(known.how()), known.low,
                     known.high);
}

/// The k at which  m_A/k + room - product k = 0: below it a step has one solution, as A is
/// coercive.
double step_bound(double m_a, double room, double product) {
  if (!(m_a > 0.0) || !std::isfinite(room) || !std::isfinite(product)) return 0.0;
  const double root = std::sqrt(room * room + 4.0 * m_a * product);
  if (room <= 0.0) return root - room > 0.0 ? 2.0 * m_a / (root - room) : infinity;
  return product > 0.0 ? (room + root) / (2.0 * product) : infinity;
}

class Judgement {
public:
  Judgement(const Plan& plan, const Discretisation& d)
      : plan_(plan), problem_(plan.problem), d_(d), numbers_(plan, d) {
    facts_.is_static = problem_.time.is_static;
    facts_.moves = in_motion(problem_);
    for (const auto& term : problem_.law_terms)
      (term.field == field_of_u(0) ? facts_.has_laws
       : is_memory(term.field)     ? facts_.has_memory_laws
                                   : facts_.has_rate_laws) = true;
  }

  HypothesisReport report(bool extrapolate) {
    longest_step();
    steps_ = step_weights(problem_);
    judge_inertia();
    judge_a();
    judge_b();
    judge_multipliers();
    judge_memory();
    judge_laws();
    judge_free_body();
    judge_states();
    judge_loads();
    judge_smallness();
    judge_steps();
    if (extrapolate) refine_norms();
    judge_rate();
    give_verdicts(facts_, out_);
    return std::move(out_);
  }

private:
  Hypothesis& row(std::string name, std::string what, std::optional<double> value, Answer answer,
                  Origin origin = {}, std::string note = {}) {
    out_.hypotheses.push_back(
        {std::move(name), std::move(what), value, answer, origin, std::move(note)});
    return out_.hypotheses.back();
  }
  static Answer yes(bool holds) { return holds ? Answer::holds : Answer::fails; }
  static Answer positive(double v) { return std::isnan(v) ? Answer::open : yes(v > 0.0); }
  TheoryConstants& c() { return out_.constants; }

  void longest_step() {
    c().longest_step = 0.0;
    const auto& grid = problem_.time.grid;
    for (std::size_t n = 1; n < grid.size(); ++n)
      c().longest_step = std::max(c().longest_step, grid[n] - grid[n - 1]);
  }

  std::string place(const Ellipticity& e) const {
    return e.varies ? fmt::format(", least at {}", describe_point(e.at, d_.mesh.dim))
                    : std::string();
  }

  void judge_inertia() {
    if (!facts_.moves) return;
    const Origin origin = form_origin(problem_, field_of_u(2));
    const double defect = numbers_.asymmetry(field_of_u(2));
    row("H(rho)", "the mass is symmetric: its defect", defect, yes(defect <= 1e-12), origin);
    const double in_h = numbers_.coercivity_in_h(field_of_u(2));
    row("H(rho)", "the mass is coercive in H = L2: m_rho", in_h, positive(in_h), origin);
  }

  void judge_a() {
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
    const Origin origin = form_origin(problem_, field_of_u(1));
    const double defect = numbers_.asymmetry(field_of_u(1));
    row("H(A)", "A is symmetric: its defect", defect, yes(defect <= 1e-12), origin);
    facts_.skew_rates = numbers_.has_several_unknowns() && defect > 1e-12;
    rate_row_ = out_.hypotheses.size();
    row("H(A)", "A is coercive in V: m_A", c().m_A, positive(c().m_A), origin,
        std::isfinite(tensor.least)
            ? fmt::format("pointwise m_1 = {:.6g}{}", tensor.least, place(tensor))
            : std::string());
  }

  /// Coercive in V or in H? A tensor that is elliptic everywhere is the former's proof; else the
  /// least eigenvalue goes to 0 under refinement where it is the latter only.
  void judge_rate() {
    if (!numbers_.acts_on(field_of_u(1))) return;
    auto& answer = out_.hypotheses[rate_row_];
    const double finer = m_a_finer_.value_or(not_a_number);
    const bool keeps = c().m_1 > 0.0 || finer > 0.7 * c().m_A;
    if (c().m_A > 0.0 && keeps) {
      out_.rate_form = RateForm::in_v;
      return;
    }
    const double in_h = numbers_.coercivity_in_h(field_of_u(1));
    const double in_h_finer = m_h_finer_.value_or(in_h);
    const bool in_l2 = numbers_.free_body() == nullptr && in_h > 0.0 && in_h_finer > 0.7 * in_h;
    out_.rate_form = in_l2 ? RateForm::in_h : RateForm::weak;
    answer.answer = Answer::fails;
    if (c().m_A > 0.0)
      answer.note += fmt::format(
          "{}on this mesh only{}: A holds no gradient everywhere", answer.note.empty() ? "" : "; ",
          std::isnan(finer) ? std::string() : fmt::format(", {:.6g} on the refined", finer));
    row("H(A)", "A is coercive in H = L2: m_H", in_h, yes(in_l2), answer.origin,
        in_l2 ? "the evolution is parabolic: see `theorem`" : "");
  }

  void judge_b() {
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
    row("H(B)", "B is coercive: m_B", c().m_B, positive(c().m_B),
        form_origin(problem_, field_of_u(0)), note);
  }

  /// Unknowns without a form of their own: a pressure.
  void judge_multipliers() {
    for (int b = 0; b < n_unknowns(d_.space); ++b) {
      if (!d_.space.is_product()) return;
      const auto beta = numbers_.inf_sup(b);
      if (!beta) continue;
      const auto name = d_.space.blocks[static_cast<std::size_t>(b)].name;
      multipliers_.emplace_back(b, out_.hypotheses.size());
      facts_.multipliers = true;
      facts_.inf_sup = facts_.inf_sup && *beta > smallest_inf_sup;
      row("H(B)", fmt::format("`{}` is a multiplier, seen by the others: inf-sup constant", name),
          *beta, yes(*beta > smallest_inf_sup), form_origin(problem_, field_of_u(0)));
    }
  }

  void judge_memory() {
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
                      with_word(norms.l1, known.l1),
                      lipschitz ? ""
                                : "; singular: the continuous theorem and the bounds tau_0 do not "
                                  "apply, each step's problem and its certificate do"));
      if (lipschitz) h.known = known.lipschitz;
      judge_modulus(static_cast<int>(m));
    }
  }

  /// The modulus B + E int q after a jump of the strain, against B: told where it leaves (0, 1].
  /// E and B are compared by their traces, exactly where one is a multiple of the other.
  void judge_modulus(int m) {
    if (!numbers_.acts_on(field_of_u(0))) return;
    const auto& grid = problem_.time.grid;
    const auto& kernel = problem_.histories[static_cast<std::size_t>(m)].kernel;
    const double horizon = grid.back() - grid.front();
    if (!kernel_traits(kernel, horizon).convolution) return;
    const double b = numbers_.of_field(field_of_u(0)).diagonal().sum(),
                 e = numbers_.of_field(field_of_memory(m)).diagonal().sum();
    const double ratio = b != 0.0 ? e / b : 0.0;
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
      row("memory",
          fmt::format("`{}` leaves a positive modulus: 1 + int q at the end", kernel.name), late,
          Answer::fails, origin,
          fmt::format("held for longer than {:.6g} a strain meets a negative modulus; the kernel "
                      "is meant for shorter times",
                      high));
    }
  }

  void judge_laws() {
    c().m_nu = c().m_tau = c().c_J = 0.0;
    Bracket m_nu, m_tau, m_rate;
    for (const auto& law : numbers_.laws()) {
      const auto& term = problem_.law_terms[law.term];
      const auto& spec = problem_.laws[static_cast<std::size_t>(term.law)];
      if (!spec.coupled.empty() || !spec.readings.empty()) {
        c().m_nu = c().m_tau = c().c_J = infinity;
        m_nu = c().c_J_known = Bracket::exactly(infinity);
        row("H(J)", fmt::format("`{}` is a law of its argument alone", term.name), std::nullopt,
            Answer::fails, term.origin,
            spec.coupled.empty()
                ? "it reads a memory of the unknown: beyond the theorems here"
                : fmt::format("its bound is the multiplier of `{}` (Coulomb): beyond the theory",
                              spec.coupled));
        (spec.coupled.empty() ? facts_.reads : facts_.coupled) = true;
        continue;
      }
      if (!problem_.laws[term.law].states.empty())
        row("H(J)", fmt::format("`{}` keeps its graph", term.name), std::nullopt, Answer::open,
            term.origin,
            "it changes with its states: its numbers are those at their initial values");
      const double m = law.m.value(), growth = law.c.value();
      if (term.field == field_of_u(0)) {
        double& most = law.radial ? c().m_tau : c().m_nu;
        most = std::max(most, m);
        Bracket& known = law.radial ? m_tau : m_nu;
        known = larger(known, law.m);
        facts_.lipschitz = std::max(facts_.lipschitz, law.lipschitz);
      } else if (is_memory(term.field)) {
        facts_.lipschitz_memory = std::max(facts_.lipschitz_memory, law.lipschitz);
      } else {
        m_rate = larger(m_rate, law.m);
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
              : fmt::format("the slope jumps down at {:.6g}{}", law.at,
                            law.regular ? "; -j is regular" : "; neither j nor -j is regular"))
          .known = law.m;
    }
    c().m_J = c().m_nu + c().m_tau;
    c().m_J_known = m_nu + m_tau;
    facts_.proved = c().m_J_known.bounded_by_proof() && m_rate.bounded_by_proof();
    const auto& norms = numbers_.traces();
    c().norm_normal = norms.normal, c().norm_tangential = norms.tangential;
    c().norm_full = norms.full, c().norm_script = numbers_.script_norm(field_of_u(0));
    if (facts_.has_laws) {
      const char* which = facts_.has_rate_laws ? "all laws on the unknown" : "all laws";
      row("H(M)", "M is bounded and compact: ||M||^2", c().norm_script,
          yes(std::isfinite(c().norm_script)), law_origin(field_of_u(0)),
          fmt::format(
              "the arguments of {}, on this mesh; traces: normal {:.6g}, tangential {:.6g}, "
              "full {:.6g}",
              which, norms.normal, norms.tangential, norms.full));
    }
    if (!facts_.has_rate_laws) return;
    const double norm = numbers_.script_norm(field_of_u(1));
    row("H(M)", "M of the laws on the rate is bounded and compact: ||M||^2", norm,
        yes(std::isfinite(norm)), law_origin(field_of_u(1)), "on this mesh");
  }

  /// What the forms leave free has to be held by laws, and these need the load's help.
  void judge_free_body() {
    const FreeBody* const body = numbers_.free_body();
    if (body == nullptr || problem_.law_terms.empty()) return;
    const auto unseen = unseen_motions(*body, numbers_.contact());
    facts_.semi_coercive = true;
    facts_.springs_hold = c().m_J == 0.0 && held_strongly(*body, numbers_.contact());
    const auto words = [](const std::vector<std::string>& motions) {
      return fmt::format("{}", fmt::join(motions, "; "));
    };
    const std::string springs = facts_.springs_hold
                                    ? ", by slopes that rise everywhere: coercive with the laws"
                                    : ": semi-coercive";
    row("rigid", "laws hold the motions that forms and values leave free", std::nullopt,
        yes(unseen.empty()), problem_.law_terms.front().origin,
        unseen.empty() ? words(free_motions(*body)) + springs
                       : "no law sees that " + words(unseen));
    if (unseen.empty()) judge_balance(*body);
  }

  /// At some times of the grid, for laws that are the same at all times.
  void judge_balance(const FreeBody& body) {
    const Contact& contact = numbers_.contact();
    const auto& grid = problem_.time.grid;
    const auto moves = [](const auto& law) { return law->depends_on_t() && !law->coupled(); };
    if (facts_.springs_hold || std::ranges::any_of(contact.laws, moves)) return;
    const auto n = static_cast<int>(grid.size());
    LoadAssembler loads(d_.space, d_.parts, problem_.loads);
    const StateLayout& layout = numbers_.layout();
    loads.restrict_to({layout.dof_of.data(), static_cast<std::size_t>(layout.n_unknowns)});
    const int stride = std::max(1, n / most_load_times);
    std::string refused;
    const Origin origin =
        problem_.loads.empty() ? problem_.time.origin : problem_.loads.front().origin;
    for (int i = problem_.time.is_static ? 0 : 1; i < std::max(1, n) && refused.empty();
         i += stride) {
      Vector f = Vector::Zero(layout.n_unknowns);
      const double t = grid.empty() ? 0.0 : grid[static_cast<std::size_t>(i)];
      try {
        loads.add(t, f);
        refuse_unbalanced(body, contact, problem_, f, t);
      } catch (const Failure& failure) {
        refused = failure.what();
      }
    }
    row("rigid", "the laws can balance the load", std::nullopt, yes(refused.empty()), origin,
        refused);
  }

  /// Lipschitz constants of the rates, by the state itself and by what they read.
  void judge_states() {
    facts_.states = !problem_.states.empty();
    for (const auto& form : problem_.forms)
      if (reads_states(form))
        row("H(state)", "a form keeps its coefficients", std::nullopt, Answer::open, form.origin,
            "they change with states: what is said of it holds at their initial values");
    for (const auto& state : problem_.states) {
      const RateConstants found = rate_constants(problem_, d_.mesh, state);
      const auto one = [&](const std::string& by, const RateConstant& l) {
        const double everywhere = l.everywhere.value();
        auto& made =
            row("H(state)", fmt::format("the rate of `{}` is Lipschitz in {}", state.name, by),
                everywhere, std::isfinite(everywhere) ? Answer::holds : Answer::open, state.origin,
                std::isfinite(everywhere)
                    ? ""
                    : fmt::format("on bounded sets only: {} for inputs up to 1 in size",
                                  with_word(l.near.value(), l.near)));
        if (std::isfinite(everywhere)) made.known = l.everywhere;
      };
      one(found.other_states ? "the states" : "the state", found.by_states);
      if (found.reads_inputs) one("its inputs", found.by_inputs);
    }
  }

  Origin law_on_memory() const {
    return std::ranges::find_if(problem_.law_terms,
                                [](const LawTerm& term) { return is_memory(term.field); })
        ->origin;
  }

  Origin law_origin(int field) const {
    return std::ranges::find(problem_.law_terms, field, &LawTerm::field)->origin;
  }

  void judge_loads() {
    if (judge_load_times()) return;
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

  /// Whether a load was found that is not bounded in time: then it must be square integrable.
  bool judge_load_times() {
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

  /// The law that softens most: it decides (H0).
  Origin worst_law() const {
    Origin out = problem_.time.origin;
    double most = -1.0;
    for (const auto& law : numbers_.laws()) {
      const auto& term = problem_.law_terms[law.term];
      if (term.field == field_of_u(0) && law.m.value() > most)
        most = law.m.value(), out = term.origin;
    }
    return out;
  }

  void judge_smallness() {
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

  /// Laws on memories, which are a part of the history, and laws on u', against A in place of B.
  void judge_other_laws() {
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

  /// The step whose matrix leaves the least room, of all that differ.
  void judge_steps() {
    StepRatio ratio(numbers_);
    const int most = std::clamp(1'200'000 / std::max(1, d_.dofs.n_unknowns()), 24, 600);
    const auto worst = worst_step(steps_, std::ref(ratio), most);
    const auto n = static_cast<std::size_t>(worst.step);
    // The iteration finds eigenvalues from below: what it promises is confirmed by a factor.
    const double bound =
        worst.bound < 1.0 && worst.within_budget && !ratio.below_one(weights_of(worst.step))
            ? infinity
            : worst.bound;
    out_.margins.step = 1.0 - (worst.within_budget ? std::max(worst.ratio, 0.0) : worst.bound);
    out_.worst_step = worst.step;
    facts_.steps_margin = 1.0 - bound;
    std::string note = problem_.time.is_static ? "K = B" : "all steps have one matrix";
    if (steps_.steps.size() > 1)
      note = fmt::format("K of step {} (t = {:.6g}), the worst of {} different ones{}", n,
                         problem_.time.grid[n], steps_.steps.size(),
                         worst.within_budget ? "" : "; a bound for all of them");
    row("step", "1 - lambda_max(sum m_i M_i^T W M_i, sym K)", out_.margins.step,
        positive(out_.margins.step), worst_law(), note);
    out_.usable = not_a_number;
    if (!problem_.time.is_static && !facts_.moves) bound_steps();
  }

  const Vector& weights_of(int step) const {
    const auto at = std::find(steps_.steps.begin(), steps_.steps.end(), step);
    return steps_.c[static_cast<std::size_t>(at - steps_.steps.begin())];
  }

  /// The paper's bounds on the step, the one that A alone gives, and the usable one.
  void bound_steps() {
    const Margins& m = out_.margins;
    const double k = c().longest_step, room = std::max({m.paper, m.largest, m.split});
    const double script = c().m_J == 0.0 ? c().m_B : c().m_B - c().m_J * c().norm_script;
    const auto bound = [&](double numerator) {
      return numerator <= 0.0 ? 0.0 : product_ > 0.0 ? numerator / product_ : infinity;
    };
    out_.tau_0 = {{"m_B / (c_E c_q)", bound(c().m_B)},
                  {"(m_B - m_J ||M||^2) / (c_E c_q)", bound(script)},
                  {"half of it (Lemma 3.2)", bound(script / 2.0)},
                  {"k_0 of the error estimate, with C_2 >= c_E c_q", bound(script)}};
    const double with_a = step_bound(m.rate_split, room, product_);
    if (numbers_.acts_on(field_of_u(1)))
      out_.tau_0.emplace_back("m_A/k > m_J ||M||^2 - m_B + c_E c_q k: without (H0)", with_a);
    for (const auto& [what, tau] : out_.tau_0)
      row("tau_0", what, tau, yes(k < tau), problem_.time.origin,
          fmt::format("the longest step is {:.6g}", k));
    facts_.step_bound = with_a;
    out_.usable = infinity;
    c().memory_step = 0.0;
    const auto absolute = absolute_weights(problem_, steps_);
    for (std::size_t n = 0; n < absolute.size(); ++n) {
      double memory = 0.0;
      for (std::size_t i = 0; i < memory_norms_.size(); ++i)
        memory += memory_norms_[i] * absolute[n][field_of_memory(static_cast<int>(i))];
      c().memory_step = std::max(c().memory_step, memory);
      out_.usable =
          std::min(out_.usable, m.rate_split * steps_.c[n][field_of_u(1)] + room - memory);
    }
    row("step", "m_A/k + margin - c_E int |q| over the step", out_.usable, positive(out_.usable),
        problem_.time.origin, "with the sharpest margin: the usable bound, of the worst step");
  }

  /// Trace norms grow under refinement: twice the step from this mesh to the refined one is taken
  /// off the margins (as for order one, so rather too much).
  void refine_norms() {
    const bool asks = !problem_.law_terms.empty() || !multipliers_.empty() ||
                      (numbers_.acts_on(field_of_u(1)) && !(c().m_1 > 0.0));
    if (!asks || d_.dofs.n_unknowns() > 200000 >> d_.mesh.dim) return;
    Discretisation fine;
    if (!discretise_on(plan_, refine(d_.mesh), fine).empty()) return;
    const Numbers finer(plan_, fine);
    if (numbers_.acts_on(field_of_u(1)) && !(c().m_1 > 0.0)) {
      m_a_finer_ = finer.coercivity(field_of_u(1), not_a_number);
      m_h_finer_ = finer.coercivity_in_h(field_of_u(1));
    }
    refine_inf_sup(finer);
    if (!problem_.law_terms.empty()) refine_margins(finer);
  }

  /// A pair of elements is stable where the constant keeps off 0 on ever finer meshes.
  void refine_inf_sup(const Numbers& finer) {
    for (const auto& [unknown, row] : multipliers_) {
      Hypothesis& h = out_.hypotheses[row];
      const double there = finer.inf_sup(unknown).value_or(0.0);
      const bool keeps = there > 0.7 * *h.value;
      h.note = fmt::format("{:.6g} on the refined mesh{}", there,
                           keeps ? "" : ": it goes to 0, and this pair of elements is not stable");
      if (!keeps) h.answer = Answer::fails;
      facts_.inf_sup = facts_.inf_sup && keeps;
    }
  }

  void refine_margins(const Numbers& finer) {
    const double m_b = finer.coercivity(field_of_u(0), c().m_2);
    const auto limit = [](double coarse, double here) {
      return std::isfinite(coarse) && std::isfinite(here) ? 2.0 * here - coarse : -infinity;
    };
    const double softening = std::max(c().m_nu, c().m_tau);
    const double norm = limit(c().norm_script, finer.script_norm(field_of_u(0)));
    facts_.whole = softening == 0.0           ? m_b
                   : std::isfinite(softening) ? m_b - softening * norm
                                              : -infinity;
    facts_.split = limit(out_.margins.split, finer.margin_split(field_of_u(0), m_b));
    facts_.against_b =
        m_b > 0.0 ? limit(out_.margins.against_b, finer.margin_against(field_of_u(0))) : -infinity;
    if (facts_.has_rate_laws)
      facts_.rate_against_a =
          limit(out_.margins.rate_against_a, finer.margin_against(field_of_u(1)));
    if (facts_.has_laws)
      row("H(M)", "||M||^2 on ever finer meshes (estimate)", norm, yes(std::isfinite(norm)),
          law_origin(field_of_u(0)),
          fmt::format(
              "from this mesh and its refinement; there (H0) has the margin {:.6g}, the split "
              "condition {:.6g}, against B {:.6g}",
              *facts_.whole, *facts_.split, *facts_.against_b));
  }

  const Plan& plan_;
  const Problem& problem_;
  const Discretisation& d_;
  Numbers numbers_;
  HypothesisReport out_;
  VerdictFacts facts_;
  StepWeights steps_;
  std::size_t rate_row_ = 0;                             ///< of "A is coercive in V"
  double product_ = 0.0;                                 ///< sum c_E c_q over the kernels
  std::vector<double> memory_norms_;                     ///< ||E_m||
  std::vector<std::pair<int, std::size_t>> multipliers_; ///< unknowns, and their rows
  std::optional<double> m_a_finer_, m_h_finer_;          ///< on the refined mesh
};

} // namespace

HypothesisReport check_hypotheses(const Plan& plan, const Discretisation& discretisation,
                                  bool extrapolate) {
  return Judgement(plan, discretisation).report(extrapolate);
}

} // namespace hvi::solver
