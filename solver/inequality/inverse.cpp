// Newton's method for laws of straight pieces, from a guess: the short way of steps in which few
// points change their piece (inverse.hpp). It takes the same steps as ActiveSetNewton, but a point
// costs nothing until it leaves its piece, and then one update of (S + H)^-1.
//
// A solve is a product with the inverse. S dc = r - H dc follows from it, and is computed only
// where the inverse may be too rough for that. Whatever it cannot do (a point at a break where the
// slope jumps, another component, a matrix about to lose its definiteness) the general way does,
// from the start.
#include "solver/inequality/inverse.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr int most_products = 6;
constexpr int longest_pause = 1024;
/// A measured error holds for other right-hand sides up to this factor.
constexpr double safety = 100.0;

} // namespace

KeptInverse::KeptInverse(const ContactPoints& points, const StiffnessPattern& pattern,
                         const ReducedOperator& s, const InequalityOptions& options)
    : points_(points),
      possible_(points.unknowns > 0 && points.unknowns <= largest && points.size() > 0 &&
                s.symmetric() && !options.force_fallback &&
                (options.branch == Branch::continuing || !points.laws.may_soften()) &&
                StraightPieces::possible(points)),
      inverse_(points, pattern, s), stiffness_dz_(points.rows) {}

/// Newton's steps from the guess. False: nothing is known.
bool KeptInverse::iterate(Position& at, InequalityReport& report) {
  const double target = at.balance.target();
  KeptProduct& product = at.balance.product;
  const StraightPieces& pieces = inverse_.pieces();
  double solved = 0.0; // the largest right-hand side that S c rests on a solve for
  at.update_arguments();
  if (inverse_.follow(at.z) < 0) return false;
  pieces.multipliers(at.z, at.xi);
  residual_ = at.balance.residual(at.xi);
  for (int k = 0; k < most_products; ++k) {
    inverse_.solve(residual_, dc_);
    ++report.iterations;
    dz_.noalias() = points_.g * dc_;
    pieces.times_stiffness(dz_, stiffness_dz_);
    h_dc_.noalias() = points_.force_of * stiffness_dz_;
    at.c += dc_;
    product.shift(residual_ - h_dc_);
    solved = std::max(solved, residual_.lpNorm<Eigen::Infinity>());
    at.update_arguments();
    const double error = inverse_.error; // of the inverse that was used
    const int moved = inverse_.follow(at.z);
    if (moved < 0) return false;
    pieces.multipliers(at.z, at.xi);
    const Errors& errors = at.balance.errors(at.c, at.xi);
    report.residual = errors.worst;
    if (!moved && errors.worst <= target) {
      if (safety * error * solved <= 0.1 * target * errors.size.minCoeff()) return true;
      // S c itself, and how far the one that solves had made of it is from that, beyond rounding
      // of the products.
      const double rounding = 0x1p-49 * errors.size.maxCoeff(), off = product.correct(at.c);
      inverse_.error = 0x1p-49 + (off > rounding && solved > 0.0 ? off / solved : 0.0);
      solved = 0.0;
      report.residual = at.balance.errors(at.c, at.xi).worst;
      if (report.residual <= target) return true;
    }
    residual_ = errors.left;
  }
  return false;
}

bool KeptInverse::may_serve(const InequalityState& from) {
  if (!possible_ || from.c_guess.size() != points_.unknowns ||
      from.xi_guess.size() != points_.rows || from.c.size() != points_.unknowns ||
      static_cast<int>(from.state.size()) != points_.size())
    return false;
  if (rest_ > 0) return --rest_, false;
  // To make it costs as much as so many steps.
  return inverse_.made() || 32 * ++waited_ > points_.unknowns;
}

bool KeptInverse::solve(Position& at, InequalityState& io, InequalityReport& report) {
  if (!may_serve(io)) return false;
  KeptProduct& product = at.balance.product;
  at.c = io.c_guess;
  if (io.s_c_guess.size() != points_.unknowns)
    product.correct(at.c);
  else
    product.take(at.c, io.s_c_guess);
  product.belongs_to(at.c);
  if (!inverse_.bring(io.state) || !iterate(at, report)) {
    product.forget();
    rest_ = pause_, pause_ = std::min(2 * pause_, longest_pause);
    report = {};
    return false;
  }
  product.belongs_to(at.c);
  pause_ = 4;
  report.converged = true; // xi are the slopes at z: no inclusion is left
  const bool asleep = at.xi.isZero(0.0) && io.xi_guess.isZero(0.0) && report.iterations == 1;
  if (asleep) report.iterations = 0;
  io.c = at.c, io.xi = at.xi, io.state = inverse_.pieces().states();
  return true;
}

void KeptInverse::save(StateWriter& out) const {
  const InverseHistory history = inverse_.made() ? inverse_.history() : InverseHistory{};
  out.put(static_cast<std::uint8_t>(inverse_.made()));
  out.put(history.first_states);
  out.put(static_cast<std::uint64_t>(history.updates.size()));
  for (const auto& [point, to_state] : history.updates) out.put(point), out.put(to_state);
  out.put(inverse_.error);
  out.put(std::array<int, 3>{waited_, rest_, pause_});
}

void KeptInverse::restore(StateReader& in) {
  const bool was_made = in.get<std::uint8_t>() != 0;
  InverseHistory history;
  history.first_states = in.get_vector<int>();
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
    const int point = in.get<int>();
    history.updates.emplace_back(point, in.get<int>());
  }
  const double error = in.get<double>();
  const auto counts = in.get_counts<3>(1 << 25);
  inverse_.forget();
  if (was_made) {
    if (!possible_ || static_cast<int>(history.first_states.size()) != points_.size())
      in.fail("has another number of contact points");
    if (!inverse_.remake(history)) in.fail("has other laws");
  }
  inverse_.error = error;
  waited_ = counts[0], rest_ = counts[1], pause_ = counts[2];
}

} // namespace hvi::solver
