// Which theorem applies, and what it claims; see verdicts.hpp.
#include "solver/hypotheses/verdicts.hpp"

#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// A margin is one beyond what eigenvalues are found to.
constexpr double least_margin = 1e-9;

// Whom theorems and proofs are due to; docs/theory.md has the titles.
constexpr const char* paper = "S. Migorski, S. Zeng 2019";
constexpr const char* of_static = "W. Han, M. Sofonea 2019";
constexpr const char* of_histories = "J. Ogorzaly 2016; S. Migorski, Y. Bai, S. Zeng 2023";
constexpr const char* of_rates = "M. Sofonea, A. Matei 2011; S. Migorski, Y. Bai, S. Zeng 2023";
constexpr const char* of_memories = "M. Sofonea, F. Patrulescu 2014";
constexpr const char* of_motion = "A. Kulig 2013";

class Verdicts {
public:
  Verdicts(const VerdictFacts& facts, HypothesisReport& report) : facts_(facts), out_(report) {}

  void give() {
    discrete();
    if (facts_.semi_coercive && !facts_.moves)
      semi_coercive();
    else if (!std::isfinite(facts_.lipschitz_memory))
      refuse("the slope of a law on a memory jumps: of the continuous problem nothing is claimed, "
             "of the steps see `step`");
    else if (facts_.is_static)
      at_one_time();
    else if (facts_.multipliers)
      refuse(
          "an unknown has no form of its own, and the problem changes in time: of the continuous "
          "problem nothing is claimed, of the steps see `step`");
    else if (facts_.skew_rates)
      refuse(
          "A is not symmetric (H(A)): of the continuous problem nothing is claimed, of the steps "
          "see `step`");
    else if (facts_.moves)
      in_motion();
    else if (facts_.has_rate_laws)
      on_rates();
    else if (out_.rate_form == RateForm::none)
      at_each_time();
    else if (out_.rate_form == RateForm::in_v)
      in_v();
    else if (out_.rate_form == RateForm::in_h)
      in_h();
    else
      refuse("A is not coercive (H(A)), neither in V nor in H: the theory asks for it");
    if (facts_.has_memory_laws && out_.continuous) with_memory_laws();
    if (out_.continuous && !due_.empty()) out_.continuous_verdict += fmt::format(" ({})", due_);
    theorem_rows();
  }

private:
  bool h0_as_a_whole() const { return facts_.whole.value_or(out_.margins.largest) > 0.0; }
  bool h0_split() const { return facts_.split.value_or(out_.margins.split) > 0.0; }
  bool h0_against_b() const { return facts_.against_b.value_or(out_.margins.against_b) > 0.0; }
  const char* estimate() const {
    return facts_.has_laws || facts_.has_rate_laws ? " (estimate: trace norms from meshes)" : "";
  }

  void discrete() {
    const char* what = facts_.is_static ? "the problem" : "every step";
    const bool positive = facts_.steps_margin > least_margin;
    const bool springs = facts_.semi_coercive && facts_.springs_hold;
    out_.discrete = (positive || springs) && facts_.proved && !facts_.coupled && !facts_.reads &&
                    !facts_.loads_read && !facts_.states && facts_.inf_sup &&
                    facts_.unseen_at_rest.empty() && failing({"H(f)"}).empty();
    if (out_.discrete)
      out_.discrete_verdict = fmt::format("on this mesh {} has exactly one solution", what);
    else if (!facts_.inf_sup)
      out_.discrete_verdict = "uniqueness is not guaranteed: the inf-sup condition fails";
    else if (facts_.coupled)
      out_.discrete_verdict =
          "neither existence for large bounds nor uniqueness is guaranteed: the "
          "bound of a law is the multiplier of another one";
    else if (facts_.semi_coercive && !facts_.springs_hold)
      out_.discrete_verdict =
          "uniqueness is not guaranteed: laws alone hold the body (semi-coercive)";
    else if (facts_.reads)
      out_.discrete_verdict = "uniqueness is not guaranteed: a law reads the solution";
    else if (facts_.loads_read)
      out_.discrete_verdict = "uniqueness is not guaranteed: a load reads the solution";
    else if (facts_.states)
      out_.discrete_verdict =
          !positive ? std::string("uniqueness is not guaranteed: a step may have several "
                                  "solutions, and laws, forms or loads change with states")
          : facts_.only_time
              ? std::string("with the forms of the initial time a step has exactly one solution; "
                            "they change in time, and of later steps nothing is said here: a run "
                            "says where it is not guaranteed")
              : std::string("with the initial states held, a step has exactly one solution; laws, "
                            "forms or loads change with states, and of other states, or of both "
                            "together, nothing is said here: a run says where it is not "
                            "guaranteed");
    else if (positive && !facts_.proved)
      out_.discrete_verdict =
          fmt::format("uniqueness is not guaranteed: m_J is sampled, not proved (with it {} would "
                      "have one solution)",
                      what);
    else if (positive && !facts_.unseen_at_rest.empty())
      out_.discrete_verdict = fmt::format(
          "uniqueness is not guaranteed of `{}`, which has no form of its own: where points of a "
          "law "
          "with jumps rest, it and the law's forces may share what holds the body in any way",
          facts_.unseen_at_rest);
    else if (positive)
      out_.discrete_verdict = "uniqueness is not guaranteed: the load is not finite";
    else if (std::isinf(facts_.steps_margin))
      out_.discrete_verdict = "uniqueness is not guaranteed: a law jumps down or falls arbitrarily "
                              "steeply, or the forms are not coercive";
    else
      out_.discrete_verdict =
          facts_.is_static
              ? "uniqueness is not guaranteed: the problem may have several solutions"
              : fmt::format("uniqueness is not guaranteed: step {} may have several solutions",
                            out_.worst_step);
  }

  /// Of these hypotheses, those that fail, each once.
  std::vector<std::string> failing(std::initializer_list<const char*> asked) const {
    std::vector<std::string> out;
    for (const auto& h : out_.hypotheses)
      if (h.answer == Answer::fails &&
          std::find(asked.begin(), asked.end(), h.name) != asked.end() &&
          std::find(out.begin(), out.end(), h.name) == out.end())
        out.push_back(h.name);
    return out;
  }

  void refuse(std::string why) {
    out_.continuous = false;
    out_.continuous_verdict = "the theorem does not apply: " + std::move(why);
  }
  /// Says no where one of these fails, or the constants of the laws are not proved.
  bool refused(std::initializer_list<const char*> needed) {
    if (facts_.loads_read) {
      refuse("it knows no loads that read the solution");
      return true;
    }
    if (facts_.only_time) {
      refuse("it knows no forms that change in time; what is said of a step holds for those of the "
             "initial time");
      return true;
    }
    if (facts_.states) {
      refuse("it knows no states (for a bonding field there is one: O. Chau, J. R. Fernandez, M. "
             "Shillor, M. Sofonea 2003); what is said of a step on this mesh stands");
      return true;
    }
    const auto missing = failing(needed);
    if (!missing.empty())
      refuse(fmt::format("{} above {}", joined(missing), missing.size() == 1 ? "fails" : "fail"));
    else if (!facts_.proved)
      refuse("m_J of the laws is sampled, not proved");
    return !missing.empty() || !facts_.proved;
  }
  void accept(std::string text) {
    out_.continuous = true;
    out_.continuous_verdict = std::move(text);
  }

  void semi_coercive() {
    theorem_ = "B and the laws together are monotone and coercive";
    order_failed_ = "its proof needs a coercive B; `study` measures the orders";
    if (facts_.is_static && facts_.springs_hold && failing({"H(J)", "H(f)"}).empty() &&
        out_.discrete)
      return accept("laws whose slopes rise everywhere hold the motions that B leaves free: B and "
                    "the laws together are coercive, one solution");
    if (facts_.springs_hold)
      return refuse("the forms alone are not coercive; with the laws that hold the body every step "
                    "is, and its certificate stands");
    refuse("the forms alone are not coercive (semi-coercive: laws hold the body). For convex laws "
           "there is a solution where the load presses into them, <f, v> < J_inf(M v) for all free "
           "motions v (C. Baiocchi, F. Gastaldi, F. Tomarelli 1986), which each step is asked; "
           "strains are then unique, motions need not be");
  }

  void at_one_time() {
    theorem_ = "static: B coercive and (H0)", due_ = of_static;
    if (refused({"H(B)", "H(J)", "H(M)", "H(f)"})) return;
    if (h0_as_a_whole())
      accept(fmt::format("the static theorem applies: B is coercive and (H0) holds, one solution{}",
                         estimate()));
    else if (h0_split() || h0_against_b())
      accept(fmt::format("(H0) fails for M as a whole, but {} holds and the static theorem needs "
                         "no more: one solution{}",
                         sharper(), estimate()));
    else
      refuse("(H0) fails in every form");
  }

  /// Without a term with u'.
  void at_each_time() {
    theorem_ = facts_.has_memory ? "static at each t, Banach's fixed point for the memory: B "
                                   "coercive and (H0)"
                                 : "static at each t: B coercive and (H0)";
    due_ = facts_.has_memory ? of_histories : of_static;
    regularity_failed_ = "there is no term with u': u is as regular in time as f, in C([0, T]; V) "
                         "where f is continuous";
    order_failed_ = "its proof needs A coercive in V; `study` measures the orders";
    if (refused({"H(B)", "H(E)", "H(J)", "H(M)", "H(f)"})) return;
    const std::string what = facts_.has_memory
                                 ? "static at each t, with the memory a history-dependent operator"
                                 : "static at each t";
    if (!facts_.integrable)
      refuse("a kernel is not integrable");
    else if (h0_as_a_whole())
      accept(fmt::format("there is no term with u': the problem is {}. The static theorem applies: "
                         "B is coercive and (H0) m_B > m_J ||M||^2 holds, one solution{}",
                         what, estimate()));
    else if (h0_split() || h0_against_b())
      accept(fmt::format("there is no term with u': the problem is {}. (H0) fails for M as a "
                         "whole, but {} holds and the static theorem needs no more: one solution{}",
                         what, sharper(), estimate()));
    else
      refuse(fmt::format("there is no term with u', so the problem is {}, and (H0) m_B > m_J "
                         "||M||^2 fails in every form",
                         what));
  }

  std::string sharper() const { return h0_split() ? "the split condition" : "its form against B"; }

  void in_v() {
    theorem_ = "Theorem 3.2", due_ = paper;
    order_ = fmt::format("for smooth solutions: the last theorem of {}", paper);
    if (refused({"H(A)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"})) return;
    const bool b = failing({"H(B)"}).empty();
    if (b && h0_as_a_whole())
      accept(fmt::format("the theorem applies{}", estimate()));
    else if (b && (h0_split() || h0_against_b()))
      accept(fmt::format("(H0) fails for M as a whole, but {} holds and the proof needs no more: "
                         "one solution, to which the scheme converges{}",
                         sharper(), estimate()));
    else {
      theorem_ = "Theorem 3.2, whose proof needs neither (H0) nor a coercive B";
      accept(fmt::format(
          "{} fails, and is not needed: A is coercive in V, so the evolution has one solution for "
          "every m_J, to which the scheme converges for steps k < {:.6g}{}",
          b ? "(H0)" : "H(B)", facts_.step_bound, estimate()));
    }
  }

  /// They are a part of the history, which the paper's estimate knows as a linear one.
  void with_memory_laws() {
    theorem_ += ", the laws on memories being a part of the history";
    due_ += due_.empty() ? of_memories : fmt::format("; {}", of_memories);
    if (order_failed_.empty())
      order_failed_ = "the paper's estimate is for laws on u; `study` measures the orders";
  }

  void on_rates() {
    theorem_ = "the problem for u' with its history: A coercive in V, m_A > m_J ||M||^2 of the "
               "laws on u', Banach's fixed point";
    due_ = of_rates;
    order_failed_ = "the paper's estimate is for laws on u; `study` measures the orders";
    if (out_.rate_form != RateForm::in_v)
      return refuse("a law acts on u', and no form A coercive in V does: of the continuous problem "
                    "nothing is claimed, of the steps see `step`");
    if (refused({"H(A)", "H(E)", "H(J)", "H(M)", "H(f)"})) return;
    if (!(facts_.rate_against_a.value_or(out_.margins.rate_against_a) > 0.0))
      return refuse("the laws on u' soften faster than A: m_A > m_J ||M||^2 fails for them");
    if (!std::isfinite(facts_.lipschitz))
      return refuse("the slope of a law on u jumps, beside a law on u': of the continuous problem "
                    "nothing is claimed, of the steps see `step`");
    accept(fmt::format("laws act on u', and the rest of the problem is the history of u': A is "
                       "coercive in V with m_A > m_J ||M||^2 of these laws, one solution{}",
                       estimate()));
  }

  void in_motion() {
    theorem_ = "the problem for u' with its history: a mass coercive in H = L2, A coercive in V";
    due_ = of_motion;
    order_failed_ = "the paper's estimate is for problems without inertia; `study` measures the "
                    "orders";
    if (out_.rate_form != RateForm::in_v)
      return refuse("there is inertia, and no form A coercive in V acts on u': of the continuous "
                    "problem nothing is claimed, of the steps see `step`");
    if (refused({"H(rho)", "H(A)", "H(E)", "H(J)", "H(M)", "H(f)"})) return;
    if (!facts_.integrable) return refuse("a kernel is not integrable");
    if (!std::isfinite(facts_.lipschitz))
      return refuse("the slope of a law on u jumps, and there is inertia: of the continuous "
                    "problem nothing is claimed, of the steps see `step`");
    accept(fmt::format("with inertia the problem is one for u' and its history: the mass is "
                       "coercive in H and A in V, one solution with u' in L2(0, T; V) and u'' in "
                       "L2(0, T; V*); (H0) is not needed, as M is compact{}",
                       estimate()));
  }

  void in_h() {
    theorem_ = "parabolic: A coercive in H = L2, B in V, by the proof of Theorem 3.2 in H";
    due_ = paper;
    regularity_failed_ = "u in L2(0, T; V), u' in L2(0, T; V*) only: A is coercive in H, not in V";
    order_failed_ = "its proof needs A coercive in V; `study` measures the orders";
    if (refused({"H(B)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"})) return;
    accept(
        fmt::format("A is coercive in H only: the parabolic theorem applies, one solution with "
                    "u in L2(0, T; V) and u' in L2(0, T; V*); Theorem 3.2 does not, and its u in "
                    "H1(0, T; V) and O(h + k) fall away{}",
                    h0_as_a_whole() || h0_split() || h0_against_b()
                        ? ""
                        : "; (H0) fails, and is not needed as M is compact, but steps must be "
                          "small (row `step`)"));
  }

  void row(std::string what, bool holds, std::string note) {
    Hypothesis h;
    h.name = "theorem", h.what = std::move(what), h.note = std::move(note);
    h.answer = holds ? Answer::holds : Answer::fails;
    out_.hypotheses.push_back(std::move(h));
  }

  void theorem_rows() {
    row("one solution", out_.continuous,
        !out_.continuous ? std::string()
        : due_.empty()   ? theorem_
                         : fmt::format("{} ({})", theorem_, due_));
    if (facts_.is_static || !out_.continuous) return;
    row("u in H1(0, T; V)", regularity_failed_.empty(), regularity_failed_);
    row("error O(h + k) in V", order_failed_.empty(),
        order_failed_.empty() ? order_ : order_failed_);
  }

  const VerdictFacts& facts_;
  HypothesisReport& out_;
  std::string theorem_, due_, regularity_failed_, order_, order_failed_; ///< due_: to whom
};

} // namespace

void give_verdicts(const VerdictFacts& facts, HypothesisReport& report) {
  Verdicts(facts, report).give();
}

} // namespace hvi::solver
