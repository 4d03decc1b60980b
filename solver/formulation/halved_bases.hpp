// Base matrices of which half is kept, where memory counts more than the time of rare readers.
#pragma once

#include "solver/discrete/operators.hpp"

namespace hvi::solver {

/// The upper halves in blocks; empty where one of the matrices is not square and symmetric.
std::vector<SymmetricBlocks> halved(const Operators& operators, int threads);

/// Keeps the halves only, if there are any and no state changes a form: then Operators::bases are
/// empty.
void keep_halves(Operators& operators, int threads);

/// T_b by rows: as it is kept, or made of its half in `room`. Not where rows are dealt out.
const SparseMatrix& base_by_rows(const Operators& operators, int b, SparseMatrix& room);

/// y += factor |T_b| |x|
void add_magnitude_of_base(const Operators& operators, int b, double factor, const Vector& x,
                           Vector& y);
/// y = T_b x
void product_of_base(const Operators& operators, int b, const Vector& x, Vector& y);
/// y += factor T_b x
void add_product_of_base(const Operators& operators, int b, double factor, const Vector& x,
                         Vector& y);

} // namespace hvi::solver
