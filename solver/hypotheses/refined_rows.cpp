// Rows that compare with the refined mesh; see hypotheses.hpp.
#include "solver/common/numbers.hpp"
#include "solver/hypotheses/judgement.hpp"
#include "solver/mesh/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

void Judgement::refine_norms() {
  const bool asks = !problem_.law_terms.empty() || !multipliers_.empty() ||
                    (numbers_.acts_on(field_of_u(1)) && !(c().m_1 > 0.0));
  if (!asks || d_.dofs.n_unknowns() > 200000 >> d_.mesh.dim) return;
  Discretisation fine;
  if (!discretise_on(plan_, refine(d_.mesh), fine).empty()) return;
  const Numbers finer(plan_, fine);
  if (numbers_.acts_on(field_of_u(1)) && !(c().m_1 > 0.0)) {
    a_finer_ = finer.own_coercivities(field_of_u(1));
    m_h_finer_ = finer.coercivity_in_h(field_of_u(1));
  }
  refine_inf_sup(finer);
  if (!problem_.law_terms.empty()) refine_margins(finer);
}

void Judgement::refine_margins(const Numbers& finer) {
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
    facts_.rate_against_a = limit(out_.margins.rate_against_a, finer.margin_against(field_of_u(1)));
  if (facts_.has_laws)
    row("H(M)", "||M||^2 on ever finer meshes (estimate)", norm, yes(std::isfinite(norm)),
        law_origin(field_of_u(0)),
        fmt::format(
            "from this mesh and its refinement; there (H0) has the margin {:.6g}, the split "
            "condition {:.6g}, against B {:.6g}",
            *facts_.whole, *facts_.split, *facts_.against_b));
}

} // namespace hvi::solver
