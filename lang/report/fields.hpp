// The fields of a run as a report holds them: points, cells cut into simplices, and a block of
// numbers for every field and time.
#pragma once

#include "lang/report/blocks.hpp"
#include "solver/output/field_frame.hpp"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <vector>

namespace hvi::lang {

/// {"dim", "points", "cells", "arrays": [{"name", "components"}], "frames": [{"t", "step", "data",
/// "laws"}]}; names of blocks where numbers stand. Fields of cells become means at nodes. Not more
/// frames than keep the file small enough to load in seconds.
nlohmann::ordered_json fields_json(std::span<const solver::FieldFrame> frames, Blocks& blocks);

/// Triangles or tetrahedra (lines in 1D), the tetrahedra turned so that their volumes are positive;
/// quadratic cells are cut into four or eight.
std::vector<std::uint32_t> simplices_of(const solver::VtuGrid& grid);

} // namespace hvi::lang
