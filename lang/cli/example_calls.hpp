// Examples of the catalogue that are command lines.
#pragma once

#include "lang/diag/catalogue.hpp"

#include <span>

namespace hvi::lang {

[[nodiscard]] std::span<const ExampleCall> example_calls();

} // namespace hvi::lang
