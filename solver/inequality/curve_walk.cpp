// The walk along the equilibrium curve (curve_walk.hpp).
#include "solver/inequality/curve_walk.hpp"

#include "solver/common/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// The start leaves corners of the graph by this part of the step, a little different for each
/// point: no two of them reach an end at the same load then. b_1 knows nothing of it.
constexpr double off_corner = 1e-10;
/// z that differs by this part of the problem's size from a break is on it.
constexpr double on_break = 1e-12;

/// Between 1/2 and 1, of points as different as can be (multiples of the golden ratio).
double spread(int p) { return 0.5 + 0.5 * std::fmod(0.6180339887498949 * (p + 1), 1.0); }

/// What a step meets: the end of a point's place, or the load.
struct CurveEvent {
  double length; ///< to it, or by how much a step went beyond it
  int point;     ///< `by_load`, `none`, or the point
  int side;      ///< of its place: 1 the upper end, -1 the lower
};
constexpr int by_load = -1, none = -2;

/// Places point p at its argument, exactly on a break that is as close as `noise`.
void put_on_graph(const CurveGraph& g, CurveState& at, int p, double noise) {
  int piece = 0;
  while (piece + 1 < g.pieces() && at.z[p] > g.high(piece) + noise) ++piece;
  at.place[p] = 2 * piece;
  if (piece + 1 == g.pieces() || at.z[p] < g.high(piece) - noise) return;
  const double below = g.below(piece), above = g.above(piece); // at a break
  at.z[p] = g.at(piece);
  if (below < above) {
    at.place[p] = 2 * piece + 1;
    at.xi[p] = std::clamp(at.xi[p], below, above);
  } else if (below > above && at.xi[p] < 0.5 * (below + above)) {
    at.place[p] = 2 * (piece + 1);
  }
}

void move_off_corner(const CurveProblem& problem, CurveState& at, int p, double room) {
  const double low = problem.end(at, p, -1), high = problem.end(at, p, 1),
               now = problem.unknown(at, p);
  const double by = std::min(room * spread(p), 0.25 * (high - low));
  const double to = now - low < by ? low + by : (high - now < by ? high - by : now);
  if (at.upright(p))
    at.xi[p] = to / problem.a(p, p);
  else
    at.z[p] = to;
}

/// The first that is met along the tangent.
CurveEvent next_event(const CurveProblem& problem, const CurvePosition& now, double target) {
  const Vector& way = now.tangent.way;
  CurveEvent out{infinity, none, 0};
  const double load = (target - now.state.load) / now.tangent.load;
  if (load > 0.0) out = {load, by_load, 0};
  for (int p = 0; p < problem.size(); ++p) {
    if (way[p] == 0.0) continue;
    const int side = way[p] > 0.0 ? 1 : -1;
    const double length =
        std::max(0.0, (problem.end(now.state, p, side) - problem.unknown(now.state, p)) / way[p]);
    if (length < out.length) out = {length, p, side};
  }
  if (load > 0.0 && load <= out.length + on_break) return {load, by_load, 0};
  return out;
}

/// What a step went beyond, the farthest.
CurveEvent overrun(const CurveEquations& equations, const CurvePosition& now, double target,
                   bool seeks_load) {
  const CurveProblem& problem = equations.problem();
  CurveEvent out{0.0, none, 0};
  double beyond = 0.0; // a point that is there as well goes on from the load
  if (seeks_load && (now.state.load - target) * now.tangent.load >= 0.0) {
    out = {std::abs(now.state.load - target), by_load, 0};
    beyond = std::max(out.length, on_break);
  }
  for (int p = 0; p < problem.size(); ++p)
    for (const int side : {1, -1}) {
      const double over = side * (problem.unknown(now.state, p) - problem.end(now.state, p, side)) /
                          equations.size();
      if (over > beyond) out = {over, p, side}, beyond = over;
    }
  return out;
}

/// The part of a step from `before` to `after` at which it met the event, by linear interpolation.
double part_until(const CurveEvent& e, const CurveProblem& problem, const CurveState& before,
                  const CurveState& after, double target) {
  if (e.point == by_load) return (target - before.load) / (after.load - before.load);
  const double from = problem.unknown(before, e.point), now = problem.unknown(after, e.point);
  return (problem.end(after, e.point, e.side) - from) / (now - from);
}

/// Puts a point exactly on the end it has reached and on the next place; the way goes on there.
CurveStep cross(const CurveEquations& equations, CurvePosition& now, const CurveEvent& e) {
  const int p = e.point;
  const CurveProblem& problem = equations.problem();
  const CurveGraph& g = *problem.points[p].graph;
  CurveState& at = now.state;
  int side = e.side;
  if (at.upright(p)) {
    const int b = at.place[p] / 2;
    if (problem.falls(at, p)) side = -side; // xi falls on the way up
    at.place[p] = 2 * (side > 0 ? b + 1 : b);
    at.z[p] = g.at(b);
  } else {
    const int piece = at.place[p] / 2, b = side > 0 ? piece : piece - 1;
    at.z[p] = g.at(b);
    if (g.below(b) == g.above(b)) {
      at.place[p] = 2 * (side > 0 ? b + 1 : b);
    } else {
      at.place[p] = 2 * b + 1;
      at.xi[p] = side > 0 ? g.below(b) : g.above(b);
    }
  }
  problem.take_slopes(at);
  auto tangent = equations.tangent(at);
  if (!tangent) return CurveStep::failed;
  const double way = tangent->way[p];
  if ((problem.falls(at, p) ? -way : way) * side < 0.0) tangent->reverse();
  now.tangent = std::move(*tangent);
  return CurveStep::crossed;
}

/// Newton's method at the load itself.
CurveStep to_load(const CurveEquations& equations, CurvePosition& now, double target) {
  now.state.load = target;
  const CurveTangent held{Vector::Zero(equations.problem().size()), 1.0};
  if (!equations.correct(now.state, held)) return CurveStep::failed;
  auto tangent = equations.tangent(now.state, now.tangent);
  if (!tangent) return CurveStep::failed;
  now.tangent = std::move(*tangent);
  return CurveStep::at_load;
}

/// How far curved pieces let one step go: no point moves by more than `stride` of the size.
double longest_curved(const CurveEquations& equations, const CurvePosition& now, double stride) {
  double fastest = 0.0;
  for (int p = 0; p < equations.problem().size(); ++p)
    if (equations.problem().curved(now.state, p))
      fastest = std::max(fastest, std::abs(now.tangent.way[p]));
  return fastest > 0.0 ? stride * equations.size() / fastest : infinity;
}

void return_to(const CurvePosition& before, const CurveProblem& problem, CurvePosition& now) {
  now = before;
  problem.take_slopes(now.state);
}

} // namespace

CurveWalk walk_from(const CurveProblem& problem, const Vector& z, const Vector& xi,
                    const Vector& b1) {
  const int n = problem.size();
  CurveState at{z, xi, Vector::Zero(n), std::vector<int>(static_cast<std::size_t>(n), 0), 0.0};
  double size = std::max(z.lpNorm<Eigen::Infinity>(), b1.lpNorm<Eigen::Infinity>());
  if (!(size > 0.0)) size = 1.0;
  for (int p = 0; p < n; ++p) put_on_graph(*problem.points[p].graph, at, p, on_break * size);
  problem.take_slopes(at);
  size = std::max(size, (at.z + problem.a * at.xi).lpNorm<Eigen::Infinity>());
  const double room = off_corner * (b1 - at.z - problem.a * at.xi).lpNorm<Eigen::Infinity>();
  for (int p = 0; p < n; ++p) move_off_corner(problem, at, p, room);
  problem.take_slopes(at);
  return {CurveEquations(problem, at.z + problem.a * at.xi, b1, size), std::move(at)};
}

bool CurveWalk::begin() {
  auto tangent = equations_.tangent(now_.state);
  if (tangent) now_.tangent = std::move(*tangent);
  return tangent.has_value();
}

bool CurveWalk::go(double length) {
  const CurveTangent& along = now_.tangent;
  for (int p = 0; p < equations_.problem().size(); ++p)
    equations_.problem().move(now_.state, p, length * along.way[p]);
  now_.state.load += length * along.load;
  ++steps_;
  return equations_.correct(now_.state, along);
}

CurveStep CurveWalk::step(double target) {
  const CurveEvent e = next_event(equations_.problem(), now_, target);
  const double longest = longest_curved(equations_, now_, stride_);
  const bool curved = longest < infinity;
  if (curved && e.point >= 0 &&
      e.length * std::abs(now_.tangent.way[e.point]) <= on_break * 0.1 * equations_.size()) {
    ++steps_; // points that are at their ends together may take turns for ever
    return cross(equations_, now_, e); // it is there already
  }
  if (curved) return step_on_curved(std::min(1.05 * e.length, longest), target);
  if (e.point == none || !go(e.length)) return CurveStep::failed;
  if (e.point != by_load) return cross(equations_, now_, e);
  now_.state.load = target;
  return CurveStep::at_load;
}

/// One step with corrections; shorter until it ends at what it met, or met nothing.
CurveStep CurveWalk::step_on_curved(double length, double target) {
  const CurvePosition before = now_;
  const bool seeks_load = (target - before.state.load) * before.tangent.load > 0.0;
  for (int tries = 0; tries < 80; ++tries) {
    return_to(before, equations_.problem(), now_);
    const bool found = go(length);
    if (found) {
      const CurveEvent over = overrun(equations_, now_, target, seeks_load);
      if (over.point != none && over.length > on_break) {
        length *=
            std::clamp(part_until(over, equations_.problem(), before.state, now_.state, target),
                       0.01, 1.0 - 1e-3 * (tries > 20));
        continue;
      }
      if (over.point == by_load) return to_load(equations_, now_, target);
      if (over.point != none) return cross(equations_, now_, over);
      if (keeps_direction(before.tangent, tries == 0)) return CurveStep::moved;
    }
    length *= 0.5, stride_ *= 0.5;
    if (stride_ < 1e-14) return CurveStep::failed;
  }
  return CurveStep::failed;
}

/// Goes on along the tangent where the step ended, if that is close to the one before. Later steps
/// may be longer where the direction hardly changes.
bool CurveWalk::keeps_direction(const CurveTangent& before, bool first_try) {
  auto tangent = equations_.tangent(now_.state, before);
  if (!tangent) return false;
  const double cosine = equations_.cosine(*tangent, before);
  if (!(cosine > 0.98)) return false;
  if (first_try && cosine > 0.998) stride_ = std::min(2.0 * stride_, 0.2);
  now_.tangent = std::move(*tangent);
  return true;
}

void CurveWalk::find_turn(const CurvePosition& before) {
  return_to(before, equations_.problem(), now_);
  double length = longest_curved(equations_, now_, stride_);
  for (int k = 0; k < 60 && length * now_.tangent.load > 1e-15; ++k) {
    const CurvePosition last = now_;
    auto tangent = go(length) ? equations_.tangent(now_.state, last.tangent) : std::nullopt;
    if (tangent && tangent->load > 0.0) {
      now_.tangent = std::move(*tangent);
      continue;
    }
    return_to(last, equations_.problem(), now_);
    length *= 0.5;
  }
}

} // namespace hvi::solver
