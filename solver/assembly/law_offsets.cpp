// What the argument of a law has beside the unknown, at its points.
#include "solver/assembly/assembly.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {

PointBlock as_block(const LawPoints& points) {
  PointBlock block;
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    for (int j = 0; j < 3; ++j) {
      block.x[j].push_back(points.x[p][j]);
      block.normal[j].push_back(points.normal[p][j]);
    }
  }
  block.weight = points.weight;
  block.cell = points.cell;
  block.entity = points.facet;
  block.kind = points.kind;
  block.indicators = points.indicators;
  block.gap = points.gap;
  return block;
}

namespace {

/// The offset of point p in the rows of G.
Vector reduced_offset(const LawPoints& points, const LawTerm& term, std::size_t p,
                      const Vector& offset) {
  if (points.frames.empty()) {
    return offset;
  }
  const DenseMatrix& frame = points.frames[p];
  Vector reduced = frame.transpose() * offset;
  if ((offset - frame * reduced).norm() > 1e-9 * offset.norm()) {
    throw Failure(
        FailureKind::bad_value, term.origin,
        fmt::format("the argument of the law `{}` at {} is moved by a vector that u "
                    "cannot reach",
                    term.name, describe_point(points.x[p], points.dim)),
        "project the offset as u is projected, for example on the tangent plane; what moves "
        "a strain is symmetric");
  }
  return reduced;
}

} // namespace

void law_offsets(const LawPoints& points, const LawTerm& term, double t, Vector& out,
                 const std::function<const double*(Slot)>& more) {
  const std::size_t n = points.x.size(), n_args = term.rows.size();
  out.setZero(static_cast<Eigen::Index>(n) * points.rows);
  std::vector<Expr> offsets;
  for (const auto& row : term.rows) {
    offsets.push_back(row.offset);
  }
  if (std::all_of(offsets.begin(), offsets.end(), [](const Expr& e) { return e.is(0.0); })) {
    return;
  }
  std::vector<double> values(n * n_args);
  Pointwise(offsets).evaluate(as_block(points), t, term.origin, values, more);
  Vector offset(static_cast<Eigen::Index>(n_args));
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t c = 0; c < n_args; ++c) {
      offset[Eigen::Index(c)] = values[c * n + p];
    }
    if (!offset.allFinite()) {
      throw_not_finite(term.origin, "the argument of the law", offset.sum(), points.x[p],
                       points.dim, &t);
    }
    out.segment(static_cast<Eigen::Index>(p) * points.rows, points.rows) =
        reduced_offset(points, term, p, offset);
  }
}

} // namespace hvi::solver
