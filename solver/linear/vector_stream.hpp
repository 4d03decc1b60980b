// Vectors in the bytes of a checkpoint.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/linear/sparse.hpp"

namespace hvi::solver {

void put_vector(StateWriter& w, const Vector& v);
void get_vector(StateReader& r, Vector& v);
/// Finite numbers, as many as there must be.
void get_vector(StateReader& r, Vector& v, Eigen::Index size);

} // namespace hvi::solver
