// What is fixed about the points (points.hpp).
#include "solver/inequality/points.hpp"

#include <algorithm>
#include <cstdint>

namespace hvi::solver {

Small direction_of(const Small& v, const Small& otherwise) {
  for (const Small* u : {&v, &otherwise}) {
    const double length = norm(*u);
    if (length > 0.0) return *u / length;
  }
  return along_first(static_cast<int>(v.size()), 1.0);
}

DenseRows dense_rows(const SparseMatrix& g, int first, int rows) {
  DenseRows out;
  auto& unknowns = out.unknowns;
  for (int row = first; row < first + rows; ++row)
    for (SparseMatrix::InnerIterator it(g, row); it; ++it)
      unknowns.push_back(static_cast<int>(it.col()));
  std::ranges::sort(unknowns);
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  out.g.setZero(rows, std::ssize(unknowns));
  for (int k = 0; k < rows; ++k)
    for (SparseMatrix::InnerIterator it(g, first + k); it; ++it) {
      const auto place = std::ranges::lower_bound(unknowns, static_cast<int>(it.col()));
      out.g(k, place - unknowns.begin()) = it.value();
    }
  return out;
}

PreparedLaws::PreparedLaws(const ReducedProblem& problem) : problem_(problem) {
  prepared_of_.assign(problem.graphs.size(), -1);
  for (const ContactPoint& p : problem.points) {
    if (prepared_of_[p.graph] >= 0) continue;
    prepared_of_[p.graph] = static_cast<int>(prepared_.size());
    graph_of_.push_back(p.graph);
    prepared_.emplace_back(*problem.laws[p.law], problem.graphs[p.graph]);
  }
  look_for_softening();
}

void PreparedLaws::refresh() {
  bool any = false;
  for (std::size_t k = 0; k < prepared_.size(); ++k) {
    const LawGraph& graph = problem_.graphs[graph_of_[k]];
    const Law& law = prepared_[k].law();
    if (!law.depends_on_t() && &prepared_[k].graph() == &graph) continue;
    prepared_[k] = PreparedLaw(law, graph);
    any = true;
  }
  if (!any) return;
  ++revision_;
  look_for_softening();
}

void PreparedLaws::replace(int law, const LawGraph& graph) {
  prepared_[law] = PreparedLaw(prepared_[law].law(), graph);
}

void PreparedLaws::look_for_softening() {
  may_soften_ = false;
  for (const PreparedLaw& law : prepared_) {
    may_soften_ = may_soften_ || law.components() > 1;
    for (int i = 0; i < law.graph().pieces(); ++i) may_soften_ = may_soften_ || law.softens(i);
  }
}

namespace {

/// Rows of a point of which none is made of the others but for rounding; the longest ones first.
std::vector<int> independent_rows(DenseMatrix rows) {
  constexpr double rounding = 1e-10;
  std::vector<int> out;
  double first = 0.0;
  while (std::ssize(out) < rows.rows()) {
    Eigen::Index longest = 0;
    const double square = rows.rowwise().squaredNorm().maxCoeff(&longest);
    if (out.empty()) first = square;
    if (!(square > rounding * rounding * first)) break;
    out.push_back(static_cast<int>(longest));
    const Vector row = rows.row(longest);
    for (Eigen::Index k = 0; k < rows.rows(); ++k)
      rows.row(k) -= rows.row(k).dot(row) / square * row.transpose();
    rows.row(longest).setZero();
  }
  return out;
}

/// Stiffness of the body felt at a point, sum s_i G_i^2 / (sum G_i^2)^2 averaged over its rows, s_i
/// that at each unknown (ReducedOperator::own_stiffness); 0: there is none. Of the gradient in a
/// cell with one free node, which is that node's value times a direction, the longest row counts:
/// where the direction is along an axis the others are rounding.
double stiffness_felt(const SparseMatrix& g, const ContactPoint& in, const Vector& stiffness) {
  const DenseRows seen = dense_rows(g, in.first_row, in.rows);
  const std::vector<int> counted = independent_rows(seen.g);
  double sum = 0.0;
  for (const int k : counted) {
    double square = 0.0, weighted = 0.0;
    for (Eigen::Index i = 0; i < seen.g.cols(); ++i) {
      const double of_unknown = seen.g(k, i) * seen.g(k, i);
      square += of_unknown;
      weighted += stiffness[seen.unknowns[static_cast<std::size_t>(i)]] * of_unknown;
    }
    sum += weighted / (square * square);
  }
  return counted.empty() ? 0.0 : sum / static_cast<double>(counted.size());
}

/// That stiffness k sets both scales: gamma = w / k, penalty = kappa k / w. Where a row touches one
/// unknown only, the penalty stands on the diagonal and cannot spoil the factor; else it costs
/// digits. `users`: how many rows touch each unknown; `typical`: a stiffness for points that feel
/// none.
PointData point_data(const SparseMatrix& g, const ContactPoint& in, double weight,
                     const Vector& stiffness, const std::vector<int>& users, double typical) {
  double k = stiffness_felt(g, in, stiffness);
  bool single = true, exclusive = true, given = true;
  for (int row = in.first_row; row < in.first_row + in.rows; ++row) {
    int entries = 0;
    for (SparseMatrix::InnerIterator it(g, row); it; ++it) {
      entries += it.value() != 0.0;
      exclusive = exclusive && users[it.col()] == 1 && it.value() != 0.0;
    }
    single = single && entries <= 1;
    given = given && entries == 0;
    exclusive = exclusive && entries == 1;
  }
  if (!(k > 0.0)) k = typical > 0.0 ? typical : 1.0;
  PointData q;
  q.first = in.first_row, q.rows = in.rows, q.weight = weight;
  q.gamma = q.local = weight / k;
  q.single = single, q.exclusive = exclusive, q.given = given;
  q.penalty = (single ? 1e13 : 1e7) * k / weight;
  return q;
}

void scale_rows(SparseMatrix& g, const ContactPoint& point, const Small& factor) {
  for (int k = 0; k < point.rows; ++k)
    if (factor[k] != 1.0)
      for (SparseMatrix::InnerIterator it(g, point.first_row + k); it; ++it)
        it.valueRef() *= factor[k];
}

} // namespace

ContactPoints::ContactPoints(const ReducedProblem& problem_, const ReducedOperator& s,
                             std::span<const double> factors)
    : problem(problem_), g(problem_.g), unknowns(s.size()),
      rows(static_cast<int>(problem_.g.rows())), diagonal(s.diagonal()),
      row_units(s.own_stiffness(), problem_.of_unknown), laws(problem_), force_of(unknowns, rows),
      by_iterations(s.iterative() != nullptr) {
  if (g.cols() != unknowns && rows > 0)
    throw Failure(FailureKind::bad_value, {}, "the contact matrix does not fit the operator");
  const Vector stiffness = s.own_stiffness();
  const double typical = unknowns > 0 ? stiffness.maxCoeff() : 1.0;
  std::vector<int> users(unknowns, 0);
  for (int row = 0; row < rows; ++row)
    for (SparseMatrix::InnerIterator it(g, row); it; ++it) users[it.col()] += it.value() != 0.0;
  std::vector<Eigen::Triplet<double>> weights;
  for (const ContactPoint& in : problem.points) {
    constexpr int most_rows = slot::most_arguments;
    if (!(in.weight > 0.0) || in.rows < 1 || in.rows > most_rows || in.first_row + in.rows > rows)
      throw Failure(FailureKind::bad_value, {},
                    "a contact point needs a positive weight and 1 to " +
                        std::to_string(most_rows) + " rows");
    Small factor = Small::Ones(in.rows);
    for (int k = 0; k < in.rows && !factors.empty(); ++k)
      factor[k] = factors[static_cast<std::size_t>(most_rows * in.application + k)];
    scale_rows(g, in, factor);
    const double weight = in.weight / factor[0];
    data.push_back(point_data(g, in, weight, stiffness, users, typical));
    PointData& q = data.back();
    q.law = laws.of_graph(in.graph);
    q.first_entry = entries;
    entries += q.entries();
    q.share.resize(in.rows);
    for (int k = 0; k < in.rows; ++k) {
      const double share = q.share[k] = factor[0] / factor[k];
      for (SparseMatrix::InnerIterator i(g, in.first_row + k); i; ++i)
        weights.emplace_back(static_cast<int>(i.col()), in.first_row + k,
                             weight * share * i.value());
    }
  }
  force_of.setFromTriplets(weights.begin(), weights.end());
}

namespace {

/// Which unknowns move in the probes. Where the laws of one of several unknowns have more rows than
/// there are unknowns, as those of all of a strain inside a body, multipliers are far from unique
/// and gamma decides about success: then the others, a pressure, stay. They would be noise in the
/// answer, as large as their units are apart. Where all unknowns are here (iterations), only those
/// that laws see move: the others would be noise, too.
std::vector<char> probed_unknowns(const ContactPoints& points) {
  const auto n = static_cast<std::size_t>(points.unknowns);
  std::vector<char> seen(n, 0);
  std::optional<std::uint8_t> with_laws;
  const auto& of_unknown = points.problem.of_unknown;
  bool several = false;
  for (int row = 0; row < points.rows; ++row)
    for (SparseMatrix::InnerIterator it(points.g, row); it; ++it) {
      seen[it.col()] = 1;
      if (of_unknown.empty()) continue;
      const std::uint8_t own = of_unknown[static_cast<std::size_t>(it.col())];
      several = several || with_laws.value_or(own) != own;
      with_laws = own;
    }
  if (points.by_iterations) return seen;
  std::vector<char> moves(n, 1);
  if (!with_laws || several || points.rows <= points.unknowns) return moves;
  for (std::size_t i = 0; i < n; ++i) moves[i] = of_unknown[i] == *with_laws ? 1 : 0;
  return moves;
}

} // namespace

/// How far the body gives way at the point when nothing else is held. With a smaller gamma, points
/// that slip overshoot the range where they would stick. The diagonal of S^-1 by eight probes with
/// entries +-1 (Hutchinson, Bekas): the size is all that matters.
void ContactPoints::estimate_compliance(ReducedOperator& s, const SparseMatrix& zero) {
  if (size() == 0) return;
  const int probes = by_iterations ? 2 : 8;
  const std::vector<char> moves = probed_unknowns(*this);
  DenseMatrix probe(unknowns, probes);
  std::uint32_t random = 12345;
  for (double& v : probe.reshaped()) {
    random = random * 1664525u + 1013904223u;
    v = random >> 31 ? 1.0 : -1.0;
  }
  for (int i = 0; i < unknowns; ++i)
    if (moves[static_cast<std::size_t>(i)] == 0) probe.row(i).setZero();
  DenseMatrix answer = probe;
  if (!s.estimate_alone(zero, answer)) return;
  const Vector flexibility = probe.cwiseProduct(answer).rowwise().sum() / probes;
  if (!flexibility.allFinite()) return;
  for (PointData& q : data) {
    double compliance = 0.0;
    for (int row = q.first; row < q.first + q.rows; ++row)
      for (SparseMatrix::InnerIterator it(g, row); it; ++it)
        compliance += it.value() * it.value() * flexibility[it.col()] / q.rows;
    q.gamma = std::clamp(q.weight * compliance, q.local, 1e6 * q.local);
  }
}

} // namespace hvi::solver
