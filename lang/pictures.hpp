// Pictures of a run, drawn by gnuplot: the body's surface coloured by a field, curves of the
// tables' columns.
#pragma once

#include "solver/plan/plan.hpp"
#include "solver/time/run.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// The name of a picture's file in the output folder.
std::string picture_file(const solver::Problem& problem, const solver::PictureSpec& picture);

std::string plot_file(const solver::Plan& plan, std::size_t i);

/// A picture, or why there is none.
struct Drawn {
  solver::Origin origin;
  std::string file;                       ///< in the output folder
  std::optional<solver::Failure> failure; ///< gnuplot is not there or refuses
  bool asked_by_name = false;             ///< the script names the file
};

/// Draws every `picture` and every `plot` of the plan into `folder` (PNG, or SVG by the file's
/// name). Vectors and tensors are shown by their Euclidean norm.
std::vector<Drawn> draw_pictures(const solver::Plan& plan,
                                 const solver::Discretisation& discretisation,
                                 const solver::RunResult& result, const std::string& folder);

} // namespace hvi::lang
