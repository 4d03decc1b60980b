// Pictures of a run's last state: the body's surface coloured by a field, drawn by gnuplot.
#pragma once

#include "solver/plan/plan.hpp"
#include "solver/time/run.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

/// Draws every `picture` of the plan into `folder` (PNG, or SVG by the file's name); returns the
/// files' names. Vectors and tensors are shown by their Euclidean norm. Throws
/// Failure(output) when gnuplot is not there or refuses, Failure(bad_value) for a field that needs
/// more than u.
std::vector<std::string> draw_pictures(const solver::Plan& plan,
                                       const solver::Discretisation& discretisation,
                                       const solver::RunResult& result, const std::string& folder);

} // namespace hvi::lang
