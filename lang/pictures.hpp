// Pictures of a run: the body coloured by a field, forces of laws as arrows, curves in 1D, and of
// the tables' columns.
#pragma once

#include "lang/script.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/shown.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// A picture, or why there is none.
struct Drawn {
  solver::Origin origin;
  std::string file;                       ///< in the output folder
  std::optional<solver::Failure> failure; ///< what draws it is not there or refuses
  bool asked_by_name = false;             ///< the script names the file
};

/// Draws every `picture`, every `plot` and every graph of the plan into `folder` (PNG, or SVG by
/// the file's name). Vectors and tensors are shown by their Euclidean norm; titles are the script's
/// words.
std::vector<Drawn> draw_pictures(const Script& script, const solver::RunResult& result,
                                 const solver::Shown& shown, const std::string& folder);

} // namespace hvi::lang
