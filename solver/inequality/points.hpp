// What is fixed about the points of a reduced problem (inequality.hpp): their rows, weights and
// scales, and their laws, prepared. Every part of the solver reads it.
#pragma once

#include "solver/common/length.hpp"
#include "solver/inequality/inequality.hpp"
#include "solver/inequality/prepared_law.hpp"
#include "solver/kernel/slot.hpp"
#include "solver/linear/own_stiffness.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// A vector on the rows of a point.
using Small = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, slot::most_arguments, 1>;
/// A matrix on the rows of each point, row by row, one point after the other (PointData::block).
using PointMatrices = std::vector<double>;

inline double norm(const Small& v) { return length_of(v.data(), static_cast<int>(v.size())); }
/// The first axis times `size`: of a scalar law the number itself.
inline Small along_first(int rows, double size) {
  Small out = Small::Zero(rows);
  out[0] = size;
  return out;
}
/// v / |v|, or the second choice, or the first axis, when v is 0.
Small direction_of(const Small& v, const Small& otherwise);
/// The argument that a law's graph is asked at: z of a scalar law, |z| of a radial one.
inline double size_of(const PreparedLaw& law, const Small& z) {
  return law.radial() ? norm(z) : z[0];
}

/// Rows of G on the unknowns that they touch, which are in order.
struct DenseRows {
  std::vector<int> unknowns;
  DenseMatrix g;
};
DenseRows dense_rows(const SparseMatrix& g, int first, int rows);

struct PointData {
  /// A law's slope against the body's stiffness from which rounding of z shows in xi.
  static constexpr double far_stiffer = 1e4;

  int law = 0; ///< index into PreparedLaws
  int first = 0, rows = 1;
  std::size_t first_entry = 0; ///< of its matrix among PointMatrices
  double weight = 0.0;
  Small share;            ///< of forces: those of row k count weight * share[k]
  double local = 0.0;     ///< compliance of the body there with everything else held, per weight
  double gamma = 0.0;     ///< resolvent parameter, about the compliance of the body at the point
  bool single = false;    ///< each row touches at most one unknown
  bool exclusive = false; ///< and nothing else touches those unknowns
  bool given = false;     ///< no row touches an unknown: z is imposed
  double penalty = 0.0;   ///< stiffness (per weight) that holds a resting point at its break

  Small of(const Vector& v) const { ///< its rows of v
    Small out(rows);
    for (int k = 0; k < rows; ++k) out[k] = v[first + k];
    return out;
  }
  void put(Vector& v, const Small& value) const {
    for (int k = 0; k < rows; ++k) v[first + k] = value[k];
  }
  std::size_t entries() const { return static_cast<std::size_t>(rows * rows); }
  /// Its matrix: entry (i, j) is block[rows * i + j].
  std::span<double> block(PointMatrices& all) const {
    return {all.data() + first_entry, entries()};
  }
  std::span<const double> block(const PointMatrices& all) const {
    return {all.data() + first_entry, entries()};
  }
  void put_multiple(PointMatrices& all, double of_one) const { ///< of the identity
    const auto m = block(all);
    for (int k = 0; k < rows * rows; ++k) m[k] = k % (rows + 1) == 0 ? of_one : 0.0;
  }
};

/// The graphs that points use, prepared.
class PreparedLaws {
public:
  explicit PreparedLaws(const ReducedProblem& problem);
  /// Prepares those again that move with time, and those that are not the problem's.
  void refresh();
  /// Another graph for a law, until the next `refresh`; it is kept by reference.
  void replace(int law, const LawGraph& graph);
  int revision() const { return revision_; } ///< another one after a `refresh` that had work to do
  bool may_soften() const { return may_soften_; } ///< some slope falls or jumps down

  const std::vector<PreparedLaw>& all() const { return prepared_; }
  const PreparedLaw& operator[](int law) const { return prepared_[law]; }
  int of_graph(int graph) const { return prepared_of_[graph]; }

private:
  void look_for_softening();

  const ReducedProblem& problem_;
  std::vector<PreparedLaw> prepared_;       ///< one per graph in use
  std::vector<int> prepared_of_, graph_of_; ///< graph to prepared (-1: unused) and back
  int revision_ = 0;
  bool may_soften_ = false;
};

struct ContactPoints {
  /// `factors`: as in InequalitySolver.
  ContactPoints(const ReducedProblem& problem, const ReducedOperator& s,
                std::span<const double> factors = {});
  /// gamma = w G S^-1 G^T of each point. `zero`: an H that is 0, on its pattern.
  void estimate_compliance(ReducedOperator& s, const SparseMatrix& zero);

  int size() const { return static_cast<int>(data.size()); }
  const PointData& operator[](int p) const { return data[p]; }
  const PreparedLaw& law(int p) const { return laws[data[p].law]; }
  /// Zeros of all points.
  PointMatrices no_matrices() const { return PointMatrices(entries); }

  const ReducedProblem& problem;
  SparseMatrix g;             ///< each row times its factor
  int unknowns = 0, rows = 0; ///< of G: columns and rows
  std::size_t entries = 0;    ///< of PointMatrices
  Vector diagonal;            ///< of S
  RowUnits row_units;
  PreparedLaws laws;
  std::vector<PointData> data;
  SparseMatrix force_of; ///< G^T W: unknowns by rows
  bool by_iterations;    ///< S has no factor
};

} // namespace hvi::solver
