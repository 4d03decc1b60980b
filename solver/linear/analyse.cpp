// The entrance to the direct solvers: checks the input, then chooses Cholesky or LU.
#include "solver/linear/cholesky.hpp"
#include "solver/linear/lu.hpp"

#include <fmt/format.h>

namespace hvi::solver {
namespace {

void check_matrix(const SparseMatrix& k) {
  if (k.rows() != k.cols() || k.rows() == 0 || !k.isCompressed())
    throw Failure(FailureKind::bad_value, {},
                  fmt::format("a matrix to factor is square and compressed, not {} x {}", k.rows(),
                              k.cols()));
}

void check_contact(const SparseMatrix& k, std::span<const int> contact) {
  std::vector<char> seen(static_cast<std::size_t>(k.rows()), 0);
  for (const int c : contact) {
    if (c < 0 || c >= k.rows() || seen[c] != 0)
      throw Failure(FailureKind::bad_value, {},
                    fmt::format("contact unknown {} is out of range or listed twice", c));
    seen[c] = 1;
  }
}

} // namespace

std::unique_ptr<Factorisation> analyse(const SparseMatrix& k, std::span<const int> contact,
                                       bool symmetric, OrderStore* known, FactorEntries entries) {
  check_matrix(k);
  check_contact(k, contact);
  return symmetric ? analyse_cholesky(k, contact, entries, known) : analyse_lu(k, contact);
}

} // namespace hvi::solver
