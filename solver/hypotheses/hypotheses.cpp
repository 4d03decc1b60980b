// The hypotheses of the existence theorem as numbers; see hypotheses.hpp.
//
// Paper: H(A), H(B), H(E), H(q), H(J), H(M), H(f), (H0), Theorem existencetheorem, Lemma lem3.1.
#include "solver/hypotheses/hypotheses.hpp"

#include "solver/hypotheses/numbers.hpp"
#include "solver/hypotheses/tensors.hpp"
#include "solver/mesh/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_load_times = 65;

Origin form_origin(const Plan& plan, int field) {
  for (const auto& form : plan.forms)
    if (form.field == field) return form.origin;
  return plan.time.origin;
}

class Judgement {
public:
  Judgement(const Plan& plan, const Discretisation& d) : plan_(plan), d_(d), numbers_(plan, d) {}

  HypothesisReport report(bool extrapolate) {
    longest_step();
    judge_a();
    judge_b();
    judge_memory();
    judge_laws();
    judge_loads();
    judge_smallness();
    judge_steps();
    if (extrapolate) refine_norms();
    verdicts();
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
  TheoryConstants& c() { return out_.constants; }

  void longest_step() {
    c().longest_step = 0.0;
    const auto& grid = plan_.time.grid;
    for (std::size_t n = 1; n < grid.size(); ++n)
      if (grid[n] - grid[n - 1] > c().longest_step)
        c().longest_step = grid[n] - grid[n - 1], longest_ = n;
  }

  std::string place(const Ellipticity& e) const {
    return e.varies ? fmt::format(", least at {}", describe_point(e.at, d_.mesh.dim))
                    : std::string();
  }

  void judge_a() {
    const auto tensor = ellipticity(plan_, d_, field_rate);
    c().m_1 = std::isfinite(tensor.least) ? tensor.least : nan;
    c().m_A = numbers_.coercivity(field_rate, c().m_1);
    if (!numbers_.acts_on(field_rate)) {
      row("H(A)", "A is coercive", std::nullopt,
          plan_.time.is_static ? Answer::open : Answer::fails, plan_.time.origin,
          plan_.time.is_static ? "static: no A is asked for" : "there is no term with the rate u'");
      return;
    }
    const Origin origin = form_origin(plan_, field_rate);
    const double defect = numbers_.asymmetry(field_rate);
    row("H(A)", "A is symmetric: its defect", defect, yes(defect <= 1e-12), origin);
    row("H(A)", "A is coercive: m_A", c().m_A, yes(c().m_A > 0.0), origin,
        std::isfinite(tensor.least)
            ? fmt::format("pointwise m_1 = {:.6g}{}", tensor.least, place(tensor))
            : std::string());
  }

  void judge_b() {
    const auto tensor = ellipticity(plan_, d_, field_u);
    c().m_2 = std::isfinite(tensor.least) ? tensor.least : nan;
    c().m_B = numbers_.coercivity(field_u, c().m_2);
    if (!numbers_.acts_on(field_u)) {
      row("H(B)", "B is coercive", std::nullopt, Answer::fails, plan_.time.origin,
          "there is no term with u itself");
      return;
    }
    const double defect = numbers_.asymmetry(field_u);
    std::string note;
    if (std::isfinite(tensor.least))
      note = fmt::format("pointwise m_2 = {:.6g}{}", tensor.least, place(tensor));
    if (defect > 1e-12)
      note += fmt::format("{}not symmetric ({:.2g}), which the theory does not ask for",
                          note.empty() ? "" : "; ", defect);
    row("H(B)", "B is coercive: m_B", c().m_B, yes(c().m_B > 0.0), form_origin(plan_, field_u),
        note);
  }

  void judge_memory() {
    c().c_E = c().c_q = c().lipschitz_q = c().memory_step = 0.0;
    const auto& grid = plan_.time.grid;
    for (std::size_t m = 0; m < plan_.histories.size(); ++m) {
      const auto& kernel = plan_.histories[m].kernel;
      const double e = numbers_.memory_norm(static_cast<int>(m));
      const auto norms = kernel_norms(kernel.expression, grid.front(), grid.back());
      const double k = c().longest_step;
      const double step = interval_integral(abs(kernel.expression), grid[longest_], 0.0, k, 0);
      c().c_E = std::max(c().c_E, e);
      c().c_q = std::max(c().c_q, norms.sup);
      c().lipschitz_q = std::max(c().lipschitz_q, norms.lipschitz);
      c().memory_step += e * step;
      product_ += e * norms.sup;
      row("H(E)", fmt::format("E of `{}` is bounded: ||E||", kernel.name), e, yes(std::isfinite(e)),
          plan_.histories[m].origin);
      const bool lipschitz = std::isfinite(norms.lipschitz);
      row("H(q)", fmt::format("`{}` is Lipschitz in t: its constant", kernel.name), norms.lipschitz,
          yes(lipschitz), plan_.histories[m].origin,
          fmt::format("sup |q| = {:.6g}, int |q| = {:.6g}{}{}", norms.sup, norms.l1,
                      norms.exact ? "" : " (sampled)",
                      lipschitz ? ""
                                : "; singular: the continuous theorem and the bounds tau_0 do not "
                                  "apply, each step's problem and its certificate do"));
    }
  }

  void judge_laws() {
    c().m_nu = c().m_tau = c().c_J = 0.0;
    Bracket m_nu, m_tau;
    for (const auto& law : numbers_.laws()) {
      const auto& term = plan_.law_terms[law.term];
      if (const std::string& other = plan_.laws[term.law].coupled; !other.empty()) {
        c().m_nu = c().m_tau = c().c_J = infinity;
        m_nu = c().c_J_known = Bracket::exactly(infinity);
        row("H(J)", fmt::format("`{}` is a law of its argument alone", term.name), std::nullopt,
            Answer::fails, term.origin,
            fmt::format("its bound is the multiplier of `{}` (Coulomb): beyond the theory", other));
        coupled_ = true;
        continue;
      }
      const double m = law.m.value(), growth = law.c.value();
      double& most = law.radial ? c().m_tau : c().m_nu;
      most = std::max(most, m);
      Bracket& known = law.radial ? m_tau : m_nu;
      known = larger(known, law.m);
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
    const auto& norms = numbers_.traces();
    c().norm_normal = norms.normal, c().norm_tangential = norms.tangential;
    c().norm_full = norms.full, c().norm_script = numbers_.script_norm();
    if (!plan_.law_terms.empty())
      row("H(M)", "M is bounded and compact: ||M||^2", c().norm_script,
          yes(std::isfinite(c().norm_script)), plan_.law_terms.front().origin,
          fmt::format("the arguments of all laws, on this mesh; traces: normal {:.6g}, tangential "
                      "{:.6g}, full {:.6g}",
                      norms.normal, norms.tangential, norms.full));
  }

  void judge_loads() {
    Vector f = Vector::Zero(d_.space.n_dofs());
    const LoadAssembler loads(d_.space, d_.parts, plan_.loads);
    const Origin origin = plan_.loads.empty() ? plan_.time.origin : plan_.loads.front().origin;
    try {
      const auto& grid = plan_.time.grid;
      const std::size_t stride = std::max<std::size_t>(1, grid.size() / most_load_times);
      for (std::size_t n = 0; n < grid.size(); n += stride) loads.add(grid[n], f);
      if (grid.empty()) loads.add(0.0, f);
      row("H(f)", "f is finite at the grid's times", std::nullopt, Answer::holds, origin);
    } catch (const Failure& failure) {
      row("H(f)", "f is finite at the grid's times", std::nullopt, Answer::fails, failure.origin,
          failure.what());
    }
  }

  /// The law that softens most: it decides (H0).
  Origin worst_law() const {
    Origin out = plan_.time.origin;
    double most = -1.0;
    for (const auto& law : numbers_.laws())
      if (law.m.value() > most) most = law.m.value(), out = plan_.law_terms[law.term].origin;
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
    m.split = numbers_.margin_split(m_b);
    m.against_b =
        numbers_.acts_on(field_u) ? numbers_.margin_against(numbers_.of_field(field_u)) : -infinity;
    const Origin origin = worst_law();
    row("(H0)", "m_B - (m_nu + m_tau) ||M||^2, full trace", m.paper, yes(m.paper > 0.0), origin);
    row("(H0)", "m_B - max(m_nu, m_tau) ||M||^2, the script's M", m.largest, yes(m.largest > 0.0),
        origin, "its parts are orthogonal: the larger constant suffices");
    row("(H0)", "m_B - lambda_max(sum m_i M_i^T W M_i)", m.split, yes(m.split > 0.0), origin,
        "the split condition: each law against its own trace");
    row("(H0)", "1 - lambda_max(sum m_i M_i^T W M_i, sym B)", m.against_b, yes(m.against_b > 0.0),
        origin, "the same against B itself");
  }

  SparseMatrix step_matrix() const {
    Vector by_field = Vector::Zero(numbers_.operators().n_fields());
    by_field[field_u] = 1.0;
    const auto& grid = plan_.time.grid;
    if (!plan_.time.is_static) {
      const double k = out_.constants.longest_step;
      by_field[field_rate] = (plan_.time.scheme == Scheme::bdf2 ? 1.5 : 1.0) / k;
      for (std::size_t m = 0; m < plan_.histories.size(); ++m)
        by_field[first_history_field + static_cast<int>(m)] =
            interval_integral(plan_.histories[m].kernel.expression, grid[longest_], 0.0, k, 0);
    }
    return combine(numbers_.operators(), numbers_.operators().weights.transpose() * by_field);
  }

  void judge_steps() {
    Margins& m = out_.margins;
    m.step = numbers_.margin_against(step_matrix());
    row("step", "1 - lambda_max(sum m_i M_i^T W M_i, sym K)", m.step, yes(m.step > 0.0),
        worst_law(), plan_.time.is_static ? "K = B" : "K of the longest step");
    out_.usable = nan;
    if (plan_.time.is_static) return;
    const double k = c().longest_step;
    const auto bound = [&](double numerator) {
      return product_ > 0.0 ? std::max(0.0, numerator) / product_ : infinity;
    };
    out_.tau_0 = {{"m_B / (c_E c_q)", bound(c().m_B)},
                  {"(m_B - m_J ||M||^2) / (c_E c_q)", bound(m.paper)},
                  {"half of it (Lemma 3.2)", bound(m.paper / 2.0)},
                  {"k_0 of the error estimate, with C_2 >= c_E c_q", bound(m.paper)}};
    for (const auto& [what, tau] : out_.tau_0)
      row("tau_0", what, tau, yes(k < tau), plan_.time.origin,
          fmt::format("the longest step is {:.6g}", k));
    out_.usable = c().m_A / k + std::max({m.paper, m.largest, m.split}) - c().memory_step;
    row("step", "m_A/k + margin - c_E int |q| over the step", out_.usable, yes(out_.usable > 0.0),
        plan_.time.origin, "with the sharpest margin: the usable bound");
  }

  /// Trace norms grow under refinement: twice the step from this mesh to the refined one is taken
  /// off the margins (as for order one, so rather too much).
  void refine_norms() {
    if (plan_.law_terms.empty() || d_.dofs.n_unknowns() > 200000 >> d_.mesh.dim) return;
    Discretisation fine;
    if (!discretise_on(plan_, refine(d_.mesh), fine).empty()) return;
    const Numbers finer(plan_, fine);
    const double m_b = finer.coercivity(field_u, c().m_2);
    const auto limit = [](double coarse, double here) { return 2.0 * here - coarse; };
    const double softening = std::max(c().m_nu, c().m_tau);
    const double norm = limit(c().norm_script, finer.script_norm());
    whole_limit_ = softening == 0.0           ? m_b
                   : std::isfinite(softening) ? m_b - softening * norm
                                              : -infinity;
    split_limit_ =
        std::isfinite(softening) ? limit(out_.margins.split, finer.margin_split(m_b)) : -infinity;
    row("H(M)", "||M||^2 on ever finer meshes (estimate)", norm, yes(std::isfinite(norm)),
        plan_.law_terms.front().origin,
        fmt::format(
            "from this mesh and its refinement; there (H0) has the margin {:.6g}, the split "
            "condition {:.6g}",
            *whole_limit_, *split_limit_));
  }

  bool all_hold(std::initializer_list<const char*> names) const {
    return std::all_of(out_.hypotheses.begin(), out_.hypotheses.end(), [&](const Hypothesis& h) {
      return h.answer != Answer::fails ||
             std::find(names.begin(), names.end(), h.name) == names.end();
    });
  }

  void verdicts() {
    const bool step_holds = out_.margins.step > 0.0 && all_hold({"H(f)"}) && !coupled_;
    out_.discrete = step_holds;
    const char* what = plan_.time.is_static ? "the problem" : "every step";
    out_.discrete_verdict =
        step_holds ? fmt::format("on this mesh {} has exactly one solution", what)
        : coupled_ ? std::string("uniqueness is not guaranteed: a law is coupled to another one")
        : std::isfinite(out_.margins.step)
            ? fmt::format("uniqueness is not guaranteed: {} may have several solutions", what)
            : std::string("uniqueness is not guaranteed: a law jumps down, or the forms are not "
                          "coercive");
    const bool rest = all_hold({"H(A)", "H(B)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"});
    const double whole = whole_limit_.value_or(out_.margins.largest);
    const double split = split_limit_.value_or(out_.margins.split);
    out_.continuous = rest && (whole > 0.0 || split > 0.0);
    if (!rest)
      out_.continuous_verdict = "the theorem does not apply: a hypothesis above fails";
    else if (whole > 0.0)
      out_.continuous_verdict = "the theorem applies (estimate: trace norms from meshes)";
    else if (split > 0.0)
      out_.continuous_verdict =
          "(H0) fails for M as a whole, but the split condition holds and the proof needs no more: "
          "one solution, to which the scheme converges (estimate: trace norms from meshes)";
    else
      out_.continuous_verdict = "the theorem does not apply: (H0) fails in every form";
  }

  const Plan& plan_;
  const Discretisation& d_;
  Numbers numbers_;
  HypothesisReport out_;
  std::size_t longest_ = 0;
  bool coupled_ = false;
  double product_ = 0.0;                            ///< sum c_E c_q over the kernels
  std::optional<double> whole_limit_, split_limit_; ///< of the margins, on ever finer meshes
};

} // namespace

HypothesisReport check_hypotheses(const Plan& plan, const Discretisation& discretisation,
                                  bool extrapolate) {
  return Judgement(plan, discretisation).report(extrapolate);
}

} // namespace hvi::solver
