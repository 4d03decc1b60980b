// The Lagrange elements P1 and P2 on a simplex, in barycentric coordinates.
#pragma once

#include "solver/fem/quadrature.hpp"

#include <array>
#include <vector>

namespace hvi::solver {

inline constexpr int max_cell_nodes = 10; ///< P2 on a tetrahedron

/// Number of nodes: vertices, for order 2 also one per edge.
int lagrange_size(int dim, int order);
/// The edges of a simplex in the order of their nodes: (0,1) (0,2) ... (1,2) ...
const std::vector<std::array<int, 2>>& simplex_edges(int dim);

/// phi_i at a point: P1 lambda_i; P2 lambda_i (2 lambda_i - 1) and 4 lambda_a lambda_b.
void lagrange_values(int dim, int order, const Barycentric& point, double* values);
/// d phi_i / d lambda_k, size x (dim + 1), k fastest. The chain rule with the gradients of the
/// lambda_k gives physical gradients; the lambda_k count as independent here.
void lagrange_slopes(int dim, int order, const Barycentric& point, double* slopes);

} // namespace hvi::solver
