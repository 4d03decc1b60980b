// Matrices with factors; see step_matrices.hpp. Used by the Stepper and the StepSolver.
#include "solver/step/step_matrices.hpp"

#include "solver/common/stream.hpp"
#include "solver/formulation/rigid.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

/// No run keeps more factors at a time: a file that says so is wrong.
constexpr std::uint64_t most_saved = 1000;

/// Not factored yet. `like`: whose analysis is taken over; `motions`: that it may leave free; both
/// may be null.
std::unique_ptr<StepMatrix> new_matrix(const SolverOptions& options, const Formulation& formulation,
                                       const StepMatrix* like,
                                       std::span<const RigidMotions> motions,
                                       std::function<void()> before_iteration) {
  InequalityOptions of_laws;
  of_laws.tolerance = options.tolerance;
  of_laws.branch = options.branch;
  of_laws.before_iteration = before_iteration;
  auto out =
      std::make_unique<StepMatrix>(formulation.operators(), formulation.contact(), of_laws, like);
  out->set_entries(options.factor);
  out->call_between_iterations(std::move(before_iteration));
  if (!motions.empty()) out->may_be_free(motions, formulation.layout());
  return out;
}

} // namespace

StepMatrices::StepMatrices(const Plan& plan, const Discretisation& discretisation,
                           const Formulation& formulation, const TimeScheme& scheme)
    : plan_(plan), discretisation_(discretisation), formulation_(formulation), scheme_(scheme),
      most_(formulation.operators().iterative
                ? 1 // its multigrid serves other lengths of steps, too
                : static_cast<std::size_t>(useful_factors(scheme))) {
  if (formulation.contact().none() || formulation.reduced()) return;
  motions_ = motions_of_unknowns(discretisation);
}

FoundMatrix StepMatrices::find(int n, const Vector& factors) {
  const double rate = scheme_.factor(n, 1), length = scheme_.grid().length(n);
  const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const KeptMatrix& kept) {
    return kept.rate == rate && kept.length == length;
  });
  if (found != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, found);
    StepMatrix& matrix = *kept_.front().matrix;
    const bool same = matrix.law_factors() == law_factors(formulation_.contact(), factors);
    if (!same) factor(n, factors, matrix);
    return {matrix, !same};
  }
  if (kept_.size() < most_)
    kept_.insert(kept_.begin(), KeptMatrix{rate, length,
                                           new_matrix(plan_.options, formulation_, latest(),
                                                      motions_, [this] { before_iteration(); })});
  else
    kept_.splice(kept_.begin(), kept_, std::prev(kept_.end()));
  auto& kept = kept_.front();
  kept.rate = rate, kept.length = length;
  factor(n, factors, *kept.matrix);
  return {*kept.matrix, true};
}

void StepMatrices::factor(int n, const Vector& factors, StepMatrix& matrix) const {
  for (const auto& term : plan_.problem.law_terms)
    for (std::size_t row = 0; row < term.rows.size(); ++row) {
      const double factor = factor_of_row(term, row, [&](int field) { return factors[field]; });
      if (factor > 0.0) continue;
      throw Failure(FailureKind::bad_kernel, term.origin,
                    fmt::format("the law `{}` sees a {} in which the present counts {:.3g} in step "
                                "{}, not more than 0",
                                term.name, term.seen.empty() ? "memory" : "sum", factor, n),
                    "a law acts on memories whose kernel is positive at lag 0, and on sums that "
                    "grow with the unknown");
    }
  matrix.set_law_factors(law_factors(formulation_.contact(), factors));
  const Vector gamma =
      formulation_.operators().weights.transpose() *
      factors.cwiseProduct(present_shares(scheme_, static_cast<int>(factors.size())));
  factor_or_explain(matrix, gamma, {formulation_, scheme_.grid(), n}, plan_.problem,
                    discretisation_);
}

std::vector<const SparseMatrix*> StepMatrices::all() const {
  std::vector<const SparseMatrix*> out;
  for (const auto& kept : kept_) out.push_back(&kept.matrix->k());
  return out;
}

void charge(const FactorStatistics& factor, WorkCounters& work, Timing& timing) {
  work.analyses += factor.analyses;
  work.factorisations += factor.factorisations;
  work.triangular_solves += factor.triangular_solves;
  work.bytes += factor.bytes;
  work.singles = work.singles || factor.entries == FactorEntries::singles;
  work.iterative.add(factor.iterative);
  timing.ordering += factor.seconds_analyse;
  timing.factor += factor.seconds_factor;
  timing.factor_bytes_read += factor.bytes_read;
}

void StepMatrices::account(WorkCounters& work, Timing& timing) const {
  for (const auto& kept : kept_) {
    work.bytes += kept.matrix->bytes();
    charge(kept.matrix->statistics(), work, timing);
  }
}

void StepMatrices::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(static_cast<std::uint64_t>(kept_.size()));
  for (const auto& kept : kept_) {
    w.put(kept.rate);
    w.put(kept.length);
    kept.matrix->save(out);
  }
}

void StepMatrices::restore(std::istream& in) {
  StateReader r(in, {});
  kept_.clear();
  const auto count = r.get_between<std::uint64_t>(0, most_saved);
  for (std::uint64_t i = 0; i < count; ++i) {
    const double rate = r.get<double>(), length = r.get<double>();
    auto matrix =
        new_matrix(plan_.options, formulation_, latest(), motions_, [this] { before_iteration(); });
    matrix->restore(in);
    kept_.push_back({rate, length, std::move(matrix)});
  }
}

} // namespace hvi::solver
