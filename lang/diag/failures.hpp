// The one table from a failure of the engine to the code of its diagnostic and the exit code.
#pragma once

#include "solver/common/failure.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang {

/// Exit codes, fixed (docs/language.md, "The command").
enum Exit {
  exit_ok = 0,
  exit_script = 1,
  exit_usage = 2,
  exit_solve = 3,
  exit_hypothesis = 4,
  exit_expectation = 5,
  exit_bug = 70,
  exit_interrupted = 130
};

/// How something that failed is reported, and how the program ends.
struct Ending {
  const char* code; ///< of the diagnostic: it has its text and its severity from the catalogue
  Exit exit;
};

/// What no Failure stands for.
inline constexpr Ending no_resources{"E0611", exit_solve}; ///< no thread, file or process to be had
inline constexpr Ending our_mistake{"E0901", exit_bug};

struct FailureEnding {
  solver::FailureKind kind;
  Ending ending;
};

/// In the order of the kinds. A failure is the script's where it would fail on every machine.
inline constexpr std::array failure_endings = [] {
  using K = solver::FailureKind;
  return std::to_array<FailureEnding>({
      {K::missing_file, {"E0601", exit_script}},
      {K::broken_file, {"E0603", exit_script}},
      {K::unasked_geometry, {"E0603", exit_script}},
      {K::unknown_group, {"E0602", exit_script}},
      {K::empty_region, {"E0418", exit_script}},
      {K::overlapping_regions, {"E0419", exit_script}},
      {K::bad_mesh, {"E0603", exit_script}},
      {K::no_revolution, {"E0442", exit_script}},
      {K::bad_value, {"E0423", exit_script}},
      {K::not_coercive, {"E0425", exit_script}},
      {K::not_elliptic, {"E0504", exit_script}},
      {K::bad_law, {"E0501", exit_script}},
      {K::bad_kernel, {"E0502", exit_script}},
      {K::not_certified, {"E0701", exit_solve}},
      {K::mostly_rounding, {"E0706", exit_solve}},
      {K::limit, {"E0607", exit_script}},
      {K::too_large, {"E0607", exit_solve}},
      {K::out_of_reach, {"E0705", exit_solve}},
      {K::bad_checkpoint, {"E0704", exit_script}},
      {K::output, {"E0702", exit_solve}},
      {K::special_output, {"E0702", exit_solve}},
      {K::output_folder, {"E0702", exit_solve}},
      {K::busy_folder, {"E0608", exit_solve}},
      {K::interrupted, {"E0703", exit_interrupted}},
      {K::suspended, {"E0703", exit_interrupted}},
  });
}();
static_assert(failure_endings.size() ==
              static_cast<std::size_t>(solver::FailureKind::suspended) + 1);
static_assert(std::ranges::is_sorted(failure_endings, {}, &FailureEnding::kind) &&
              std::ranges::adjacent_find(failure_endings, {}, &FailureEnding::kind) ==
                  failure_endings.end());

constexpr Ending ending_of(solver::FailureKind kind) {
  return failure_endings[static_cast<std::size_t>(kind)].ending;
}

} // namespace hvi::lang
