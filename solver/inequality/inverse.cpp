// Newton's method for laws of straight pieces, from a guess: the short way of steps in which few
// points change their piece (engine.hpp). It goes through the same places as newton(), but what a
// point does costs nothing until it leaves its piece, and then one update of (S + H)^-1:
//
//   (M + delta g g^T)^-1 = M^-1 - delta / (1 + delta g.v) v v^T,    v = M^-1 g.
//
// A solve is a product with the inverse. S dc = r - H dc follows from it, and is computed only
// where the inverse may be too rough for that. Whatever it cannot do (a point at a break where the
// slope jumps, another component, a matrix about to lose its definiteness) the general way does,
// from the start.
#include "solver/inequality/engine.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr int most_iterations = 6;
constexpr int longest_pause = 1024;
/// An update that takes more of the matrix than this loses too many digits.
constexpr double least_left = 1e-3;
/// A measured error holds for other right-hand sides up to this factor.
constexpr double safety = 100.0;
/// Beyond it the inverse is made again.
constexpr double too_rough = 1e-8;

void add_product(const DenseMatrix& a, const Vector& x, Vector& y, double beta) {
  const int n = static_cast<int>(a.rows());
  cblas_dsymv(CblasColMajor, CblasLower, n, 1.0, a.data(), n, x.data(), 1, beta, y.data(), 1);
}

} // namespace

/// May the inverse serve, now or later? Laws that move with time have other pieces in every step.
void InequalityEngine::prepare_inverse() {
  const bool alternatives =
      std::any_of(prepared.begin(), prepared.end(), [](const PreparedLaw& law) {
        bool any = law.components() > 1;
        for (int k = 0; k < law.components(); ++k) any = any || law.component(k).m > 0.0;
        return any;
      });
  const auto straight = [](const PreparedLaw& law) {
    const auto& smooth = law.graph().smooth;
    return !law.radial() && !law.law().depends_on_t() &&
           std::all_of(smooth.begin(), smooth.end(),
                       [](const auto& piece) { return piece.degree == 0 || piece.degree == 1; });
  };
  kept.possible =
      n > 0 && n <= KeptInverse::largest && n_points > 0 && op.symmetric() &&
      !options.force_fallback && (options.branch == Branch::continuing || !alternatives) &&
      std::all_of(prepared.begin(), prepared.end(), straight) &&
      std::all_of(points.begin(), points.end(), [](const PointData& p) { return p.rows == 1; });
  if (!kept.possible) return;
  kept.pieces.resize(n_points);
  kept.updates.reserve(6 * static_cast<std::size_t>(4 + n / 4));
  for (Vector* v : {&kept.column, &kept.h_dc, &kept.product}) v->resize(n);
  kept.stiffness_dz.resize(n_rows);
}

/// False where the law is so much stiffer than the body that z does not say what xi is.
bool InequalityEngine::take_piece(int p, int at_state) {
  const PreparedLaw& law = prepared[points[p].law];
  const LawGraph& g = law.graph();
  const int i = at_state / 2;
  const auto& smooth = g.smooth[i];
  StraightPiece& piece = kept.pieces[p];
  piece = {piece_low(g, i, false),
           piece_high(g, i),
           smooth.centre,
           smooth.a[0],
           smooth.degree == 1 ? smooth.a[1] : 0.0,
           law.component_of_piece(i)};
  return std::abs(piece.s) < unbounded_slope && std::abs(piece.k) * points[p].local <= far_stiffer;
}

/// (S + H)^-1 for the points in these states, all of them inside a piece.
bool InequalityEngine::make_inverse(const std::vector<int>& states) {
  kept.made = false;
  kept.states = kept.first_states = states;
  kept.updates.clear();
  kept.error = std::numeric_limits<double>::infinity();
  std::fill(h.valuePtr(), h.valuePtr() + h.nonZeros(), 0.0);
  for (int p = 0; p < n_points; ++p) {
    if (!take_piece(p, states[p])) return false;
    for (int k = first_contribution[p]; k < first_contribution[p + 1]; ++k)
      h.valuePtr()[contributions[k].value] += contributions[k].coefficient * kept.pieces[p].k;
  }
  return kept.made = op.inverse(h, kept.inverse);
}

/// Puts a point on another piece.
bool InequalityEngine::update_inverse(int p, int to_state) {
  const double before = kept.pieces[p].k;
  if (!take_piece(p, to_state)) return false;
  kept.states[p] = to_state;
  kept.updates.emplace_back(p, to_state);
  const double change = points[p].weight * (kept.pieces[p].k - before);
  if (change == 0.0) return true;
  kept.error = std::numeric_limits<double>::infinity();
  Vector& v = kept.column;
  v.setZero();
  double along = 0.0; // g . v
  for (SparseMatrix::InnerIterator it(problem.g, points[p].first); it; ++it) {
    const auto j = it.col();
    v.head(j) += it.value() * kept.inverse.row(j).head(j).transpose();
    v.tail(n - j) += it.value() * kept.inverse.col(j).tail(n - j);
  }
  for (SparseMatrix::InnerIterator it(problem.g, points[p].first); it; ++it)
    along += it.value() * v[it.col()];
  const double left = 1.0 + change * along, alpha = -change / left;
  if (!(left > least_left)) return false;
  cblas_dsyr(CblasColMajor, CblasLower, n, alpha, v.data(), 1, kept.inverse.data(), n);
  return true;
}

/// Brings the inverse to the states of a warm start; makes it when it is worth that.
bool InequalityEngine::bring_inverse(const std::vector<int>& states) {
  const bool same = kept.made && states == kept.states;
  std::size_t moved = 0;
  for (int p = 0; p < n_points && !same; ++p) {
    if (states[p] < 0 || states[p] % 2 == 1) return false;
    moved += kept.made && states[p] != kept.states[p];
  }
  const auto most = static_cast<std::size_t>(4 + n / 4);
  if (!kept.made || moved > most || kept.updates.size() > 4 * most ||
      (std::isfinite(kept.error) && kept.error > too_rough))
    return make_inverse(states);
  for (int p = 0; p < n_points && moved > 0; ++p)
    if (states[p] != kept.states[p] && !update_inverse(p, states[p])) return false;
  return true;
}

/// Points that left their piece go to the one they are on now. Their number; -1: to a place where
/// this method does not reach.
int InequalityEngine::follow_pieces() {
  int moved = 0;
  for (int p = 0; p < n_points; ++p) {
    const StraightPiece& piece = kept.pieces[p];
    const double at_z = z[points[p].first];
    if (at_z >= piece.low && at_z <= piece.high) continue;
    const PreparedLaw& law = prepared[points[p].law];
    const LawGraph& g = law.graph();
    const int from = kept.states[p] / 2, to = piece_of(g, at_z);
    if (!std::isfinite(at_z) || law.component_of_piece(to) != piece.component) return -1;
    for (int b = std::min(from, to); b < std::max(from, to); ++b)
      if (g.left[b] != g.right[b]) return -1; // it may have to stay at the jump
    if (++moved > 4 + n / 4 || !update_inverse(p, 2 * to)) return -1;
  }
  return moved;
}

/// xi = the slopes at z.
void InequalityEngine::multipliers_on_pieces() {
  for (int p = 0; p < n_points; ++p) {
    const StraightPiece& piece = kept.pieces[p];
    xi[points[p].first] = piece.s + piece.k * (z[points[p].first] - piece.centre);
  }
}

/// sc = S c itself, and how far the one that solves had made of it is from that, beyond rounding of
/// the products.
void InequalityEngine::measure_inverse(double solved) {
  op.apply(c, kept.product);
  const double off = (kept.product - sc).lpNorm<Eigen::Infinity>();
  const double rounding = 0x1p-49 * row_size.maxCoeff();
  kept.error = 0x1p-49 + (off > rounding && solved > 0.0 ? off / solved : 0.0);
  sc.swap(kept.product);
}

/// Newton's steps from the guess. False: nothing is known.
bool InequalityEngine::iterate_with_inverse() {
  double solved = 0.0; // the largest right-hand side that sc rests on a solve for
  update_z();
  if (follow_pieces() < 0) return false;
  multipliers_on_pieces();
  gather(xi);
  residual = *rhs - sc - force;
  for (int k = 0; k < most_iterations; ++k) {
    add_product(kept.inverse, residual, dc, 0.0);
    ++report.iterations;
    dz.noalias() = problem.g * dc;
    for (int p = 0; p < n_points; ++p)
      kept.stiffness_dz[points[p].first] = kept.pieces[p].k * dz[points[p].first];
    kept.h_dc.noalias() = force_of * kept.stiffness_dz;
    c += dc;
    sc += residual - kept.h_dc;
    solved = std::max(solved, residual.lpNorm<Eigen::Infinity>());
    update_z();
    const double error = kept.error; // of the inverse that was used
    const int moved = follow_pieces();
    if (moved < 0) return false;
    multipliers_on_pieces();
    report.residual = residual_ratio(xi);
    if (moved > 0 || !(report.residual <= target())) continue;
    if (safety * error * solved <= 0.1 * target() * row_size.minCoeff()) return true;
    measure_inverse(solved);
    solved = 0.0;
    report.residual = residual_ratio(xi);
    if (report.residual <= target()) return true;
  }
  return false;
}

/// The solution from a guess in the short way. False: the general way has to be gone; `io` is as it
/// was.
bool InequalityEngine::solve_with_inverse(InequalityState& io) {
  if (!kept.possible || io.c_guess.size() != n || io.xi_guess.size() != n_rows ||
      io.c.size() != n || static_cast<int>(io.state.size()) != n_points)
    return false;
  if (kept.rest > 0) return --kept.rest, false;
  if (!kept.made && 32 * ++kept.waited <= n) return false; // it costs as much as so many steps
  c = io.c_guess;
  if (io.s_c_guess.size() == n)
    sc = io.s_c_guess;
  else
    op.apply(c, sc);
  have_magnitude = false;
  const bool served = bring_inverse(io.state) && iterate_with_inverse();
  c_of_product = c; // what sc belongs to
  have_magnitude = false;
  if (!served) {
    c_of_product.setConstant(std::numeric_limits<double>::quiet_NaN());
    kept.rest = kept.pause, kept.pause = std::min(2 * kept.pause, longest_pause);
    report = {};
    return false;
  }
  kept.pause = 4;
  report.converged = true; // xi are the slopes at z: no inclusion is left
  const bool asleep = xi.isZero(0.0) && io.xi_guess.isZero(0.0) && report.iterations == 1;
  if (asleep) report.iterations = 0;
  io.c = c, io.xi = xi, io.state = kept.states;
  return true;
}

} // namespace hvi::solver
