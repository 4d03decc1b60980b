// What a mesh that was read from a file does to a script's problem.
#pragma once

#include "lang/script.hpp"
#include "solver/time/run.hpp"

namespace hvi::lang {

/// W0603 to W0605 (check/mesh_findings.hpp) at the mesh statement, with what holds each piece;
/// E0425 where a piece is held by nothing, so that no matrix needs to be factored to see it; of
/// parts W0607 to W0611.
void report_misfits(Script& script, const solver::Discretisation& discretisation);

} // namespace hvi::lang
