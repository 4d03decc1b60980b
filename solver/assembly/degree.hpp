// Which degree a quadrature rule needs.
#pragma once

#include "solver/fem/space.hpp"

#include <optional>

namespace hvi::solver {

/// Degree of an expression along a straight-sided entity, as a polynomial of position: coordinates
/// have degree 1, values of fields `order`, their gradients order - 1, time, normals and
/// multipliers 0. Nothing for an expression that is not a polynomial of these.
std::optional<int> polynomial_degree(const Expr& expression, int order);

/// Polynomial degree of the shape functions behind a derivative index.
int shape_degree(int derivative_index, int order);

/// The degree of the rule `exact` for  coefficient x shapes of degree `shapes`: exact where both
/// together are a polynomial of degree 30 at most, of this degree for others of higher degree;
/// where the coefficient is no polynomial 2 (order + 1).
int exact_degree(const Expr& coefficient, int shapes, int order);

} // namespace hvi::solver
