// Slopes that are friction bounds: those that know the argument of their law by its norm.
#pragma once

#include "lang/syntax/ast.hpp"

namespace hvi::lang {

/// Is the law given by a slope in which its argument xi stands, and only as `norm(xi)`? Such a
/// slope is one along |xi|, of a number as of a vector.
bool is_bound(const ast::Superpotential& law);

} // namespace hvi::lang
