// The conditions that a finished run must meet to be a result; see trust.hpp.
#include "solver/results/trust.hpp"

#include "solver/discrete/rounding.hpp"

#include <fmt/format.h>

namespace hvi::solver {
namespace {

/// A work identity that is off by more shows that the steps do not add up.
constexpr double largest_imbalance = 1e-6;

/// Do steps leave more of their equations than the tolerance that nobody has to ask for?
bool is_solved_roughly(const Certificate& certificate) {
  return certificate.equilibrium > SolverOptions().tolerance;
}

std::string help_for(const Certificate& certificate) {
  return is_solved_roughly(certificate)
             ? fmt::format("steps are solved better with a smaller `tolerance`; without one it is "
                           "{:.0e}",
                           SolverOptions().tolerance)
             : better_conditioned;
}

/// What may have changed a result.
std::string cause_of_errors(const Certificate& certificate) {
  return is_solved_roughly(certificate)
             ? fmt::format("what steps leave of their equations, {:.1e} with the tolerance {:.0e}, "
                           "and rounding",
                           certificate.equilibrium, certificate.tolerance)
             : "rounding";
}

} // namespace

void refuse_rounding(const RunResult& result, const Problem& problem) {
  const auto& error = result.forward_error;
  const std::string condition =
      error.condition > 0.0
          ? fmt::format(" (the step's matrix has the condition number {:.1e}; steps {} refined in "
                        "extended precision)",
                        error.condition, error.refined ? "were" : "were not")
          : std::string();
  if (const double worst = error.worst(); worst > ForwardError::largest) {
    std::string what = "the solution";
    for (const auto& column : error.columns)
      if (!(column.relative < worst)) what = "`" + column.name + "`";
    throw Failure(FailureKind::mostly_rounding, problem.space.origin,
                  fmt::format("{} may have changed {} by {:.1e} of its size; a run is certified up "
                              "to {:.0e}{}",
                              cause_of_errors(result.certificate), what, worst,
                              ForwardError::largest, condition),
                  help_for(result.certificate));
  }
  if (result.monitors && !(result.monitors->balance_error <= largest_imbalance))
    throw Failure(FailureKind::mostly_rounding, problem.space.origin,
                  fmt::format("the work of the loads and the energies differ by {:.1e} of "
                              "their size; a run is certified up to {:.0e}{}",
                              result.monitors->balance_error, largest_imbalance, condition),
                  help_for(result.certificate));
}

} // namespace hvi::solver
