// Second derivatives in time.
#pragma once

#include "lang/check/model.hpp"

namespace hvi::lang {

/// Has a form u'' in it, and not times zero?
bool has_acceleration(const ModelTerm& term);
/// Has a form of the inequality, or may one have it that a mistake left out?
bool has_second_derivative(const Model& model);

} // namespace hvi::lang
