// The constants that a .geo file lets others set.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Other values of constants that a .geo file defines.
using GeoConstants = std::vector<std::pair<std::string, double>>;

/// The names in its `DefineConstant[ r = 0.2, n = {3, Name "cells"} ]`, in the order of the file.
std::vector<std::string> geo_constants(std::string_view text);

} // namespace hvi::solver
