// Graphs of laws and kernels as points of a line: what pictures and reports draw.
#pragma once

#include "lang/draw/sheet.hpp"
#include "solver/kernel/kernel_spec.hpp"
#include "solver/law/law.hpp"

#include <vector>

namespace hvi::lang {

/// The subdifferential of a law at the origin of space, around its breaks: jumps are vertical, a
/// slope without bound is a vertical line, cut a little beyond the others, where the graph ends. A
/// radial law begins at zero. A law that reads another one's multiplier is drawn for the multiplier
/// 1. Empty: it cannot be drawn.
std::vector<draw::Spot> law_curve(const solver::LawSpec& law, double t);

/// q(t, t - lag) against lag in (0, t - t0].
std::vector<draw::Spot> kernel_curve(const solver::KernelSpec& kernel, double t0, double t);

} // namespace hvi::lang
