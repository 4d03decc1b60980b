// See at_rest.hpp.
#include "solver/formulation/at_rest.hpp"

#include "solver/common/joined.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// May the law's graph at a point have a jump?
bool may_jump(const Law& law, const Point& x, double start) {
  if (law.depends_on_t() || law.coupled() || law.reads() || law.reads_states()) return true;
  return has_jumps(law.graph(x, start), law.spec().radial);
}

/// Adds rows first .. first + count of g as rows from `at` on; returns the row after them.
int add_point(const SparseMatrix& g, const Vector& units, int first, int count, int at,
              Triplets& entries) {
  const auto begin = entries.size();
  double largest = 0.0;
  for (int r = 0; r < count; ++r) {
    double squared = 0.0;
    for (SparseMatrix::InnerIterator it(g, first + r); it; ++it) {
      const double value = it.value() * units[it.col()];
      if (value != 0.0) entries.emplace_back(at + r, static_cast<int>(it.col()), value);
      squared += value * value;
    }
    largest = std::max(largest, std::sqrt(squared));
  }
  if (largest == 0.0) return at;
  for (auto k = begin; k < entries.size(); ++k)
    entries[k] = {entries[k].row(), entries[k].col(), entries[k].value() / largest};
  return at + count;
}

/// Which of the contact unknowns are of unknowns without a form of their own?
std::vector<char> of_multipliers(const Problem& problem, const Contact& contact) {
  const std::vector<char> multipliers = multipliers_of(problem);
  std::vector<char> out;
  for (const std::uint8_t b : contact.problem.of_unknown) out.push_back(multipliers[b]);
  return out;
}

/// What is left of the columns of a beside those of R^T: a - R^T (R R^T + small)^-1 R a. The rows
/// of several laws may say the same.
DenseMatrix beside(const SparseMatrix& r, const DenseMatrix& a) {
  constexpr double small = 1e-10;
  if (r.rows() == 0) return a;
  SparseMatrix one(r.rows(), r.rows());
  one.setIdentity();
  const SparseMatrix products = SparseMatrix(r * SparseMatrix(r.transpose())) + small * one;
  const auto factor = analyse(products, {}, true);
  factor->factor(products);
  DenseMatrix out = a;
  Vector x;
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    solve(*factor, r * a.col(j), x);
    out.col(j) -= r.transpose() * x;
  }
  return out;
}

} // namespace

SparseMatrix rows_at_rest(const Problem& problem, const Contact& contact, const SparseMatrix& g,
                          const Vector& units) {
  const double start = problem.time.is_static ? 0.0 : problem.time.grid.front();
  Triplets entries;
  int rows = 0;
  for (const ContactTerm& term : contact.terms) {
    const auto of_term = static_cast<std::size_t>(term.points.law_term);
    const Law& law = *contact.laws[static_cast<std::size_t>(problem.law_terms[of_term].law)];
    for (int p = 0; p < term.n_points(); ++p)
      if (may_jump(law, term.points.x[static_cast<std::size_t>(p)], start))
        rows = add_point(g, units, term.first_row + p * term.points.rows, term.points.rows, rows,
                         entries);
  }
  SparseMatrix out(rows, g.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

bool determines_multipliers(const Problem& problem, const Contact& contact, const DenseMatrix& s) {
  constexpr double rounding = 1e-11, least_size = 1e-300; // of squares; of rows and columns
  const std::vector<char> multiplier = of_multipliers(problem, contact);
  std::vector<int> u, p;
  for (int i = 0; i < s.rows(); ++i) (multiplier[static_cast<std::size_t>(i)] ? p : u).push_back(i);
  Vector units = Vector::Zero(s.rows());
  for (const int i : u) units[i] = 1.0 / std::sqrt(std::abs(s(i, i)));
  const SparseMatrix held = rows_at_rest(problem, contact, contact.problem.g, units);
  if (p.empty() || held.rows() == 0) return true;
  DenseMatrix of_u = DenseMatrix::Zero(s.rows(), static_cast<Eigen::Index>(p.size()));
  of_u(u, Eigen::all) = units(u).asDiagonal() * s(u, p);
  const DenseMatrix of_rows = s(p, u) * units(u).asDiagonal();
  const Vector columns = of_u.colwise().norm().cwiseMax(least_size).cwiseInverse(),
               rows = of_rows.rowwise().norm().cwiseMax(least_size).cwiseInverse();
  DenseMatrix left(of_u.rows() + of_u.cols(), of_u.cols());
  left << beside(held, of_u) * columns.asDiagonal(),
      DenseMatrix(rows.asDiagonal() * s(p, p) * columns.asDiagonal());
  DenseMatrix products = left.transpose() * left;
  products.diagonal().array() -= rounding;
  return DenseCholesky(products).positive();
}

std::string names_of_multipliers(const Problem& problem) {
  const std::vector<char> multipliers = multipliers_of(problem);
  const auto unknowns = unknowns_of(problem.space);
  std::vector<std::string> names;
  for (std::size_t b = 0; b < multipliers.size(); ++b)
    if (multipliers[b] != 0) names.push_back("`" + unknowns[b].name + "`");
  return joined(names);
}

} // namespace hvi::solver
