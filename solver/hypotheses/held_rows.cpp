// Rows of what forms do not hold by themselves: rigid motions, and multipliers; see hypotheses.hpp.
#include "solver/common/joined.hpp"
#include "solver/hypotheses/judgement.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {

void Judgement::judge_multipliers() {
  for (int b = 0; b < n_unknowns(d_.space); ++b) {
    if (!d_.space.is_product()) return;
    const auto found = numbers_.inf_sup(b);
    if (!found) continue;
    const auto name = d_.space.blocks[static_cast<std::size_t>(b)].name;
    multipliers_.emplace_back(b, out_.hypotheses.size());
    facts_.multipliers = true;
    facts_.inf_sup = facts_.inf_sup && found->sees_all();
    row("H(B)",
        fmt::format("`{}`{} is a multiplier, seen by the others: inf-sup constant", name,
                    found->without_means ? " without its mean" : ""),
        found->constant, yes(found->sees_all()), form_origin(field_of_u(0)));
    if (!found->at_rest) continue;
    const bool seen = found->sees_all_at_rest();
    if (!seen) facts_.unseen_at_rest = name;
    row("H(B)",
        fmt::format("`{}` seen by functions that vanish where laws jump: inf-sup constant", name),
        *found->at_rest, yes(seen), problem_.law_terms.front().origin,
        seen ? std::string()
             : fmt::format("where their points rest, their forces and `{}` hold the body together, "
                           "in any shares",
                           name));
  }
}

void Judgement::judge_free_body() {
  const FreeBody* const body = numbers_.free_body();
  if (body == nullptr || problem_.law_terms.empty()) return;
  const auto unseen = unseen_motions(*body, numbers_.contact());
  facts_.semi_coercive = true;
  facts_.springs_hold = c().m_J == 0.0 && held_strongly(*body, numbers_.contact());
  const auto words = [](const std::vector<std::string>& motions) { return joined(motions, "; "); };
  const std::string springs = facts_.springs_hold
                                  ? ", by slopes that rise everywhere: coercive with the laws"
                                  : ": semi-coercive";
  row("rigid", "laws hold the motions that forms and values leave free", std::nullopt,
      yes(unseen.empty()), problem_.law_terms.front().origin,
      unseen.empty() ? words(free_motions(*body)) + springs : "no law sees that " + words(unseen));
  if (unseen.empty()) judge_balance(*body);
}

void Judgement::judge_balance(const FreeBody& body) {
  const Contact& contact = numbers_.contact();
  const auto& grid = problem_.time.grid;
  const auto moves = [](const auto& law) { return law->depends_on_t() && !law->coupled(); };
  if (facts_.springs_hold || std::ranges::any_of(contact.laws, moves)) return;
  if (std::ranges::none_of(body.parts, &FreeBody::Part::balances)) return; // a run will say
  const auto n = static_cast<int>(grid.size());
  LoadAssembler loads(d_.space, d_.parts, problem_.loads);
  const StateLayout& layout = numbers_.layout();
  loads.restrict_to({layout.dof_of.data(), static_cast<std::size_t>(layout.n_unknowns)},
                    layout.links);
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

void Judgement::refine_inf_sup(const Numbers& finer) {
  for (const auto& [unknown, row] : multipliers_) {
    Hypothesis& h = out_.hypotheses[row];
    const double there = finer.inf_sup(unknown, false).value_or(InfSup{}).constant;
    const bool keeps = there > 0.7 * *h.value;
    h.note = fmt::format("{:.6g} on the refined mesh{}", there,
                         keeps ? "" : ": it goes to 0, and this pair of elements is not stable");
    if (!keeps) h.answer = Answer::fails;
    facts_.inf_sup = facts_.inf_sup && keeps;
  }
}

} // namespace hvi::solver
