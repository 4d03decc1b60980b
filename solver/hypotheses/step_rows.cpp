// Rows of the steps: what their matrices leave, and bounds on their length; see hypotheses.hpp.
#include "solver/common/numbers.hpp"
#include "solver/hypotheses/judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hvi::solver {
namespace {

/// The k at which  m_A/k + room - product k = 0: below it a step has one solution, as A is
/// coercive.
double step_bound(double m_a, double room, double product) {
  if (!(m_a > 0.0) || !std::isfinite(room) || !std::isfinite(product)) return 0.0;
  const double root = std::sqrt(room * room + 4.0 * m_a * product);
  if (room <= 0.0) return root - room > 0.0 ? 2.0 * m_a / (root - room) : infinity;
  return product > 0.0 ? (room + root) / (2.0 * product) : infinity;
}

} // namespace

void Judgement::judge_steps() {
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
  std::string note = problem_.time.is_static ? "K = B"
                     : facts_.states         ? "with the forms of the initial time and states"
                                             : "all steps have one matrix";
  if (steps_.steps.size() > 1)
    note = fmt::format("K of step {} (t = {:.6g}), the worst of {} different ones{}{}", n,
                       problem_.time.grid[n], steps_.steps.size(),
                       worst.within_budget ? "" : "; a bound for all of them",
                       facts_.states ? ", with the forms of the initial time and states" : "");
  row("step", "1 - lambda_max(sum m_i M_i^T W M_i, sym K)", out_.margins.step,
      positive(out_.margins.step), worst_law(), note);
  out_.usable = not_a_number;
  if (!problem_.time.is_static && !facts_.moves) bound_steps();
}

const Vector& Judgement::weights_of(int step) const {
  const auto at = std::find(steps_.steps.begin(), steps_.steps.end(), step);
  return steps_.c[static_cast<std::size_t>(at - steps_.steps.begin())];
}

void Judgement::bound_steps() {
  const Margins& m = out_.margins;
  const double k = c().longest_step, room = std::max({m.paper, m.largest, m.split});
  const double script = c().m_J == 0.0 ? c().m_B : c().m_B - c().m_J * c().norm_script;
  const auto bound = [&](double numerator) {
    if (std::isnan(product_)) return not_a_number;
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
    out_.usable = std::min(out_.usable, m.rate_split * steps_.c[n][field_of_u(1)] + room - memory);
  }
  row("step", "m_A/k + margin - c_E int |q| over the step", out_.usable, positive(out_.usable),
      problem_.time.origin, "with the sharpest margin: the usable bound, of the worst step");
}

} // namespace hvi::solver
