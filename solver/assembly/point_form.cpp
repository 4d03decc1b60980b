// See point_form.hpp.
#include "solver/assembly/point_form.hpp"

#include "solver/assembly/pairing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace hvi::solver {
namespace {

std::vector<Expr> coefficients_of(const FormTerm& term) {
  std::vector<Expr> out;
  for (const auto& entry : term.entries) out.push_back(entry.coefficient);
  return out;
}

void shapes_at(const Space& space, const PointBlock& points, std::size_t p, ShapeTable& shapes) {
  const int cell = points.cell[p];
  const Point x = points.point(p);
  evaluate_shapes(space, cell_geometry(*space.mesh, cell),
                  barycentric_in_cell(*space.mesh, cell, x), true, shapes);
}

/// into(row, columns[j]) += values[j]: entries that are in its pattern, or rounding of a shape that
/// is 0 there. Those of a node mostly follow each other.
void add_to(SparseMatrix& into, int row, std::span<const int> columns, const auto& values) {
  const int* const begin = into.innerIndexPtr() + into.outerIndexPtr()[row];
  const int* const end = into.innerIndexPtr() + into.outerIndexPtr()[row + 1];
  const int* next = begin;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const int column = columns[j];
    if (column < 0 || column >= into.cols()) continue;
    const bool follows = next != end && *next == column;
    const int* const at = follows ? next : std::lower_bound(begin, end, column);
    if (at == end || *at != column) continue;
    into.valuePtr()[at - into.innerIndexPtr()] += values[static_cast<Eigen::Index>(j)];
    next = at + 1;
  }
}

/// into += the rows and columns of one cell.
void scatter(const Space& space, int cell, const DofSelection& dofs, const DenseMatrix& of_cell,
             SparseMatrix& into) {
  std::vector<int> entries;
  for (const auto node : space.nodes_of_cell(cell))
    for (int c = 0; c < space.components; ++c) {
      const int dof = space.dof(node, c);
      entries.push_back(dofs.entry_of.empty() ? dof : dofs.entry_of[static_cast<std::size_t>(dof)]);
    }
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (const int row = entries[i]; row >= 0 && row < into.rows())
      add_to(into, row, entries, of_cell.row(static_cast<Eigen::Index>(i)));
}

/// At points of a pair: the jump of a component, or its mean (slot::mean).
SparseMatrix rows_across(const Space& space, const PointBlock& points, const Derivative& derivative,
                         Origin origin) {
  const int row = derivative.row % linear_rows;
  if (row > 1)
    throw Failure(FailureKind::bad_value, origin, "on a pair there are jumps and means only");
  const bool lower = derivative.row >= linear_rows;
  const SparseMatrix straight = lower ? straightened(space, *points.jump) : SparseMatrix();
  const SparseMatrix& jump = lower ? straight : *points.jump;
  const auto first = static_cast<int>(row * jump.rows() / 2);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t p = 0; p < points.size(); ++p)
    for (SparseMatrix::InnerIterator it(jump, first + points.pair_point[p]); it; ++it)
      entries.emplace_back(static_cast<int>(p),
                           space.dof(static_cast<int>(it.col()), derivative.component), it.value());
  SparseMatrix out(static_cast<Eigen::Index>(points.size()), space.n_dofs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace

SparseMatrix derivative_rows(const Space& space, const PointBlock& points, int index,
                             Origin origin) {
  const Derivative derivative = decode(space, index, origin);
  if (points.jump) return rows_across(space, points, derivative, origin);
  std::vector<Eigen::Triplet<double>> entries;
  ShapeTable shapes;
  for (std::size_t p = 0; p < points.size(); ++p) {
    shapes_at(space, points, p, shapes);
    const auto nodes = space.nodes_of_cell(points.cell[p]);
    for (int i = 0; i < shapes.size; ++i)
      entries.emplace_back(static_cast<int>(p),
                           space.dof(nodes[static_cast<std::size_t>(i)], derivative.component),
                           shapes.at(derivative.row, i));
  }
  SparseMatrix out(static_cast<Eigen::Index>(points.size()), space.n_dofs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

PointForm::PointForm(const Space& space, PointBlock points, const FormTerm& term)
    : space_(&space), term_(&term), points_(std::move(points)),
      coefficients_(coefficients_of(term)), values_(points_.size() * term.entries.size()) {
  for (const auto& entry : term.entries)
    entries_.push_back(
        {decode(space, entry.test, term.origin), decode(space, entry.trial, term.origin)});
}

void PointForm::add_point(std::size_t p, DenseMatrix& of_cell) {
  ShapeTable shapes;
  shapes_at(*space_, points_, p, shapes);
  const int n = space_->components;
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    const double c = points_.weight[p] * values_[e * points_.size() + p];
    if (c == 0.0) continue;
    const auto& [test, trial] = entries_[e];
    for (int i = 0; i < shapes.size; ++i)
      for (int j = 0; j < shapes.size; ++j)
        of_cell(i * n + test.component, j * n + trial.component) +=
            c * shapes.at(test.row, i) * shapes.at(trial.row, j);
  }
}

void PointForm::evaluate(const Pointwise::Columns& more, const double* t) {
  coefficients_.evaluate(points_, 0.0, term_->origin, values_, more);
  for (std::size_t p = 0; p < points_.size(); ++p)
    for (std::size_t e = 0; e < entries_.size(); ++e)
      if (const double c = values_[e * points_.size() + p]; !std::isfinite(c))
        throw_not_finite(term_->origin, "a coefficient of the form", c, points_.point(p),
                         space_->mesh->dim, t);
}

void PointForm::assemble(const DofSelection& dofs, const Pointwise::Columns& more,
                         SparseMatrix& into, const double* t) {
  evaluate(more, t);
  into.coeffs().setZero();
  const auto size = static_cast<Eigen::Index>(space_->components) *
                    static_cast<Eigen::Index>(space_->nodes_of_cell(0).size());
  DenseMatrix of_cell(size, size);
  for (std::size_t p = 0; p < points_.size();) {
    const int cell = points_.cell[p];
    of_cell.setZero();
    for (; p < points_.size() && points_.cell[p] == cell; ++p) add_point(p, of_cell);
    scatter(*space_, cell, dofs, of_cell, into);
  }
}

} // namespace hvi::solver
