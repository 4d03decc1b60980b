// From switches to the graph of a law at a point (builder.hpp).
#include "solver/law/builder.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/table.hpp"
#include "solver/law/law_failure.hpp"
#include "solver/law/rounded_size.hpp"
#include "solver/law/towards.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace hvi::solver {

namespace {

/// A point inside a cell; of an unbounded cell one at the distance of its end's own size.
double sample_of(double low, double high) {
  if (std::isfinite(low) && std::isfinite(high)) return low + (high - low) / 2.0;
  if (std::isfinite(low)) return low + (low == 0.0 ? 1.0 : std::abs(low));
  if (std::isfinite(high)) return high - (high == 0.0 ? 1.0 : std::abs(high));
  return 0.0;
}

std::string where(double r, const LawSpec& spec, const Point& x, LawTime t) {
  std::string text = fmt::format("{} = {}", spec.radial ? "|xi|" : "r", r);
  if (spec.expression.depends_on_any(slot::x(0), slot::x(2) + 1))
    text += fmt::format(", x = ({}, {}, {})", x[0], x[1], x[2]);
  if (spec.expression.depends_on(slot::t)) text += fmt::format(", t = {}", t.t);
  return text;
}

[[noreturn]] void fail(const LawSpec& spec, double r, const Point& x, LawTime t,
                       const std::string& what, const std::string& help) {
  LawFailure failure(
      spec.origin, fmt::format("the law `{}` is not locally Lipschitz: {}", spec.name, what), help);
  failure.argument = r, failure.x = x, failure.t = t;
  throw failure;
}

/// Is it the slot of a state that the law reads?
bool is_read(const LawSpec& spec, Slot s) {
  return s >= slot::law_state(0) && s < slot::law_state(static_cast<int>(spec.states.size()));
}

[[noreturn]] void turns_too_often(const LawSpec& spec, const Switch& s) {
  LawFailure failure(
      spec.origin,
      fmt::format("the law `{}` turns at too many arguments: `{}` changes its sign more than {} "
                  "times, or where cannot be told",
                  spec.name, to_string(s.function), RootFinder::most_roots),
      "a law has finitely many pieces: put cases before this one that leave it a short range, as "
      "`| r > 1 -> ...`");
  failure.condition = s.node;
  throw failure;
}

} // namespace

GraphBuilder::GraphBuilder(const LawSpec& spec)
    : spec_(spec), expression_(expose_kinks(spec.expression)) {
  for (const Slot s : slots_of(expression_))
    if (s != slot::argument(0) && s != slot::t && s != slot::coupled && !is_read(spec, s) &&
        !(s >= slot::reading(0) && s < slot::reading(slot::most_readings)) &&
        !(s >= slot::x(0) && s <= slot::x(2)))
      throw Failure(
          FailureKind::bad_law, spec.origin,
          fmt::format("the law `{}` may depend on its argument, x, t and states only", spec.name));
  switches_ = find_switches({&expression_, 1});
  std::vector<Expr> functions;
  for (const Switch& s : switches_) functions.push_back(s.function);
  if (!functions.empty()) values_ = PointTape(functions);
}

Signature GraphBuilder::signature_at(double r, const Point& x, LawTime t, std::size_t n) const {
  thread_local std::vector<double> values;
  values.resize(switches_.size());
  if (!values.empty()) values_(r, x, t, values);
  Signature signature(n);
  for (std::size_t i = 0; i < n; ++i) signature[i] = outcome_of(switches_[i], values[i]);
  return signature;
}

const RootFinder& GraphBuilder::finder(int i, const Signature& prefix) const {
  auto found = finders_.find({i, prefix});
  if (found == finders_.end()) {
    const Expr f = specialise(switches_[i].function, switches_, prefix);
    found = finders_.emplace(std::pair{i, prefix}, RootFinder(f)).first;
  }
  return found->second;
}

void GraphBuilder::add_roots(int i, const Signature& prefix, const Point& x, LawTime t, double low,
                             double high, std::vector<double>& roots) const {
  const Switch& s = switches_[i];
  const bool crossings = s.kind != Switch::Kind::singular;
  const RootFinder& roots_of = finder(i, prefix);
  const std::vector<double> zero{0.0};
  for (const double target : s.kind == Switch::Kind::table ? s.node.table()->abscissae() : zero)
    if (!roots_of.find(x, t, target, low, high, crossings, roots) && crossings)
      turns_too_often(spec_, s);
}

/// Does switch i still stand in the law where the others have these outcomes?
bool GraphBuilder::is_live(int i, Signature signature) const {
  if (switches_[i].kind == Switch::Kind::singular) return true; // may stand for several nodes
  const auto known = live_.find({i, signature});
  if (known != live_.end()) return known->second;
  const Expr node = specialise(switches_[i].node, switches_, signature);
  const bool live = contains(specialise(expression_, switches_, signature), node);
  live_.emplace(std::pair{i, std::move(signature)}, live);
  return live;
}

/// All places where a switch may turn, sorted. First those that are affine in r; the others are
/// searched cell by cell between them (the function of a nested switch is itself piecewise), where
/// an earlier case leaves them anything to decide.
std::vector<double> GraphBuilder::candidates(const Point& x, LawTime t) const {
  const double start = spec_.radial ? 0.0 : -infinity;
  const auto n = static_cast<int>(switches_.size());
  std::vector<double> breaks;
  std::vector<char> done(switches_.size(), 0);
  for (int i = 0; i < n; ++i) {
    if (switches_[i].nested || !finder(i, {}).affine()) continue;
    add_roots(i, {}, x, t, start, infinity, breaks);
    done[i] = 1;
  }
  for (int i = 0; i < n; ++i) {
    if (done[i]) continue;
    std::sort(breaks.begin(), breaks.end());
    std::vector<double> found;
    for (std::size_t c = 0; c <= breaks.size(); ++c) {
      const double low = c == 0 ? start : breaks[c - 1];
      const double high = c == breaks.size() ? infinity : breaks[c];
      if (low >= high) continue;
      Signature signature = signature_at(sample_of(low, high), x, t, switches_.size());
      for (int k = 0; k < n; ++k)
        if (!done[k]) signature[k] = open_outcome;
      if (!is_live(i, signature)) continue;
      signature.resize(switches_[i].nested ? i : 0);
      add_roots(i, signature, x, t, low, high, found);
    }
    breaks.insert(breaks.end(), found.begin(), found.end());
    done[i] = 1;
  }
  std::sort(breaks.begin(), breaks.end());
  return without_doubles(breaks, x, t);
}

/// Of roots that differ by rounding one stays: that at which most of the functions are exactly 0.
/// sqrt(2*(r - 0.1)) in the case r > 0.1 has no value at the root of 2*r - 0.2 below 0.1.
std::vector<double> GraphBuilder::without_doubles(const std::vector<double>& sorted, const Point& x,
                                                  LawTime t) const {
  const auto zeros = [&](double r) {
    thread_local std::vector<double> values;
    values.resize(switches_.size());
    values_(r, x, t, values);
    return std::count(values.begin(), values.end(), 0.0);
  };
  std::vector<double> kept;
  for (const double b : sorted) {
    const bool same =
        !kept.empty() &&
        b - kept.back() <= 8.0 * 0x1p-52 * std::max(std::abs(kept.back()), std::abs(b));
    if (!same)
      kept.push_back(b);
    else if (b != kept.back() && zeros(b) > zeros(kept.back()))
      kept.back() = b;
  }
  return kept;
}

int GraphBuilder::function_for(const Signature& signature) const {
  const auto known = by_signature_.find(signature);
  if (known != by_signature_.end()) return known->second;
  const Expr e = specialise(expression_, switches_, signature);
  int id = 0;
  while (id < static_cast<int>(functions_.size()) && !(functions_[id].expression() == e)) ++id;
  if (id == static_cast<int>(functions_.size())) functions_.emplace_back(e, spec_.by_slope);
  by_signature_.emplace(signature, id);
  return id;
}

GraphBuilder::Cell GraphBuilder::cell_at(double low, double high, const Point& x, LawTime t) const {
  Cell cell{low, high, sample_of(low, high), 0};
  cell.function = function_for(signature_at(cell.sample, x, t, switches_.size()));
  // An unbounded cell may overflow at the first sample (exp(1e5 r) at 1): look closer to its end.
  const double end = std::isfinite(low) ? low : (std::isfinite(high) ? high : 0.0);
  double r = cell.sample;
  for (int k = 0; k < 12; ++k) {
    if (std::isfinite(functions_[cell.function].slope(r, x, t))) return cell;
    r = end + (r - end) / 16.0;
    if (r == end) break;
  }
  fail(spec_, cell.sample, x, t,
       fmt::format("its slope is not a finite number at {}", where(cell.sample, spec_, x, t)),
       "define the law for every argument, by cases if need be");
}

bool GraphBuilder::singular_at(double r, const Point& x, LawTime t) const {
  thread_local std::vector<double> values;
  values.resize(switches_.size());
  values_(r, x, t, values);
  for (std::size_t i = 0; i < switches_.size(); ++i)
    if (switches_[i].kind == Switch::Kind::singular && !(std::abs(values[i]) > 0.0)) return true;
  return false;
}

/// Drops breaks with the same smooth function on both sides.
void GraphBuilder::merge(std::vector<Cell>& cells, const Point& x, LawTime t) const {
  std::vector<Cell> kept;
  for (const Cell& c : cells) {
    if (!kept.empty() && kept.back().function == c.function && !singular_at(c.low, x, t))
      kept.back().high = c.high;
    else
      kept.push_back(c);
  }
  cells = std::move(kept);
}

LawGraph GraphBuilder::build(const Point& x, LawTime t) const {
  const std::lock_guard guard(lock_);
  const auto breaks = candidates(x, t);
  std::vector<Cell> cells;
  for (std::size_t c = 0; c <= breaks.size(); ++c)
    cells.push_back(cell_at(c == 0 ? (spec_.radial ? 0.0 : -infinity) : breaks[c - 1],
                            c == breaks.size() ? infinity : breaks[c], x, t));
  merge(cells, x, t);
  LawGraph graph;
  graph.x = x, graph.t = t;
  for (const Cell& c : cells) {
    if (&c != &cells.front()) graph.breaks.push_back(c.low);
    graph.functions.push_back(c.function);
    const double centre = std::clamp(0.0, c.low, c.high); // small arguments keep all their digits
    graph.smooth.push_back(functions_[c.function].expand(centre, x, t));
  }
  set_limits(graph);
  set_offsets(graph);
  if (!spec_.by_slope) check_potential(graph);
  return graph;
}

/// The slope's limit at `at` from the side of `inner`. Where the expression itself is undefined
/// there (sin(r)/r, or a root of what rounding makes negative) extrapolations from points that come
/// ever closer must agree, else the limit does not exist. What is left of a power of the distance
/// falls by one ratio each time it is halved, which tells the limit (A. C. Aitken, 1926).
double GraphBuilder::limit(int function, double at, double inner, const Point& x, LawTime t) const {
  const SmoothFunction& f = functions_[function];
  const double direct = f.slope(at, x, t);
  if (std::isfinite(direct)) return direct;
  const Expr rest = without_vanishing(f.slope_expression(), {at, inner > at ? 1.0 : -1.0, x, t});
  const PointTape slope({&rest, 1});
  if (const double of_rest = slope(at, x, t); std::isfinite(of_rest)) return of_rest;
  double best = infinity, value = 0.0;
  const auto try_guess = [&](double guess, double last) {
    const double error = std::abs(guess - last) / std::max(std::abs(guess), 1e-300);
    if (error < best) best = error, value = guess;
  };
  double h = inner - at, last = infinity, last_of_power = infinity;
  for (int k = 0; k < 40; ++k, h /= 2.0) {
    const double far = slope(at + h, x, t), middle = slope(at + h / 2.0, x, t),
                 near = slope(at + h / 4.0, x, t), step = near - middle;
    const double guess = 2.0 * middle - far, ratio = step / (middle - far);
    try_guess(guess, last);
    last = guess;
    // A ratio near 1 is that of a logarithm, which has no limit.
    const double of_power =
        ratio > 0.0 && ratio < 0.99 ? near + step * ratio / (1.0 - ratio) : std::nan("");
    try_guess(of_power, last_of_power);
    last_of_power = of_power;
  }
  if (best <= 1e-8) return value;
  fail(spec_, inner, x, t,
       fmt::format("its slope is infinite or undefined at {}", where(at, spec_, x, t)),
       "the slope must stay bounded near every argument");
}

/// The value at `at`, where `direct` is what e says there. What has none could be written without
/// its quotient or root, but for logarithms: r log(r) tends to 0.
double GraphBuilder::value_beside(const Expr& e, double direct, double at, double inner,
                                  const Point& x, LawTime t) const {
  if (std::isfinite(direct) || !has_logarithm(e)) return direct;
  const Expr rest = without_vanishing(e, {at, inner > at ? 1.0 : -1.0, x, t});
  return rest == e ? direct : PointTape({&rest, 1})(at, x, t);
}

/// A law of a vector is asked at 0 itself, where the limit of a quotient is no help.
double GraphBuilder::slope_at_origin(const LawGraph& graph, double inner) const {
  limit(graph.functions[0], 0.0, inner, graph.x, graph.t);
  const SmoothFunction& first = functions_[graph.functions[0]];
  const auto at_zero = [&](const Expr& e, double direct) {
    return value_beside(e, direct, 0.0, inner, graph.x, graph.t);
  };
  if (!spec_.by_slope)
    check_number(at_zero(first.expression(), first.potential(0.0, graph.x, graph.t)), "potential",
                 0.0, graph);
  const double slope = at_zero(first.slope_expression(), first.slope(0.0, graph.x, graph.t));
  check_number(slope, "slope", 0.0, graph);
  return slope;
}

void GraphBuilder::check_number(double value, const char* of, double at,
                                const LawGraph& graph) const {
  if (std::isfinite(value)) return;
  fail(spec_, at, graph.x, graph.t,
       fmt::format("its {} is no number at {}", of, where(at, spec_, graph.x, graph.t)),
       "write it without the division, root or logarithm that has no value there, or by cases");
}

void GraphBuilder::set_limits(LawGraph& graph) const {
  const int n = graph.pieces();
  const auto inner = [&](int piece) {
    return sample_of(piece_low(graph, piece, spec_.radial), piece_high(graph, piece));
  };
  for (int i = 0; i + 1 < n; ++i) {
    const double b = graph.breaks[i];
    graph.left.push_back(limit(graph.functions[i], b, inner(i), graph.x, graph.t));
    graph.right.push_back(limit(graph.functions[i + 1], b, inner(i + 1), graph.x, graph.t));
  }
  if (spec_.radial) graph.origin = slope_at_origin(graph, inner(0));
  close_rounding_gaps(graph);
}

/// Pieces that are meant to be continuous (2 - 15 (.08 - .02) and 1.1) differ by rounding: no jump.
/// What other pieces and breaks do does not count: beside a wall, or a stiff ground, jumps are
/// jumps.
void GraphBuilder::close_rounding_gaps(LawGraph& graph) const {
  const auto terms = [&](std::size_t piece, double r) { // size of what was added up
    const auto& p = graph.smooth[piece];
    if (p.degree < 0) {
      const double size = size_of_rounded(functions_[graph.functions[piece]].slope_expression(), r,
                                          graph.x, graph.t);
      return std::isfinite(size) ? size : 0.0;
    }
    double sum = 0.0, power = 1.0;
    for (int k = 0; k <= p.degree; ++k, power *= std::abs(r - p.centre))
      sum += std::abs(p.a[k]) * power;
    return sum;
  };
  for (std::size_t i = 0; i < graph.breaks.size(); ++i) {
    const double b = graph.breaks[i], gap = std::abs(graph.left[i] - graph.right[i]);
    if (gap == 0.0) continue;
    const double size = std::max({terms(i, b), terms(i + 1, b), std::abs(graph.left[i])});
    if (gap <= 1e-14 * size) graph.right[i] = graph.left[i];
  }
}

/// Constants of integration: the potential is continuous, and 0 at r = 0 for a law by slope.
void GraphBuilder::set_offsets(LawGraph& graph) const {
  const int n = graph.pieces();
  graph.offsets.assign(n, 0.0);
  const auto relative = [&](int piece, double r) {
    return primitive(spec_, functions_[graph.functions[piece]], graph, piece, r);
  };
  if (!spec_.by_slope) {
    for (int i = 0; i < n; ++i) {
      const auto& p = graph.smooth[i];
      if (p.degree >= 0)
        graph.offsets[i] = functions_[graph.functions[i]].potential(p.centre, graph.x, graph.t);
    }
    return;
  }
  for (int i = 0; i + 1 < n; ++i) {
    const double b = graph.breaks[i];
    graph.offsets[i + 1] = graph.offsets[i] + relative(i, b) - relative(i + 1, b);
  }
  const int home = piece_of(graph, 0.0);
  const double at_zero = graph.offsets[home] + relative(home, 0.0);
  for (double& offset : graph.offsets) offset -= at_zero;
}

void GraphBuilder::check_potential(const LawGraph& graph) const {
  for (int i = 0; i + 1 < graph.pieces(); ++i) {
    const double b = graph.breaks[i];
    const auto potential = [&](int piece) {
      const double inner =
          sample_of(piece_low(graph, piece, spec_.radial), piece_high(graph, piece));
      const SmoothFunction& function = functions_[graph.functions[piece]];
      return value_beside(function.expression(), function.potential(b, graph.x, graph.t), b, inner,
                          graph.x, graph.t);
    };
    const double l = potential(i), r = potential(i + 1);
    for (const double value : {l, r}) check_number(value, "potential", b, graph);
    const double size = std::max(
        {std::abs(l), std::abs(r), std::abs(b * graph.left[i]), std::abs(b * graph.right[i])});
    if (!(std::abs(r - l) <= 1e-9 * size))
      fail(spec_, b, graph.x, graph.t,
           fmt::format("its potential jumps by {} at {} (from {} to {})", r - l,
                       where(b, spec_, graph.x, graph.t), l, r),
           "make the potential continuous: add the constant that closes the jump");
  }
}

namespace {

/// Bisects [a, b] until twenty-point Gauss agrees with its two halves to rounding of the whole.
template <class F>
double refined(const F& f, double a, double b, double whole, double scale, int depth) {
  using Gauss = boost::math::quadrature::gauss<double, 20>;
  const double m = a + (b - a) / 2.0;
  const double left = Gauss::integrate(f, a, m), right = Gauss::integrate(f, m, b);
  scale = std::max(scale, std::abs(left) + std::abs(right));
  if (depth == 0 || std::abs(left + right - whole) <= 1e-14 * scale) return left + right;
  return refined(f, a, m, left, scale, depth - 1) + refined(f, m, b, right, scale, depth - 1);
}

/// Is f close to its tangent near a, at every scale below b - a? Then no panel of [a, b] hides a
/// decay that is faster than the panel is long.
template <class F>
bool calm_near(const F& f, double slope_at_a, double a, double b) {
  const double at_a = f(a), size = std::max(std::abs(at_a), std::abs(f(b)));
  for (const int digits : {10, 20, 30}) {
    const double part = std::ldexp(1.0, -digits), d = part * (b - a);
    const double off = std::abs(f(a + d) - at_a - d * slope_at_a);
    if (!(off <= (10.0 * part * part + 1e-13) * size)) return false;
  }
  return true;
}

/// Panels that halve towards a: a law's scale may be far smaller than the piece (exp(-20 r)). They
/// end where the slope is calm.
template <class F>
double integral(const F& f, double slope_at_a, double a, double b) {
  double sum = 0.0, end = b;
  for (int k = 0; k <= 30; ++k) {
    const bool last = k == 30 || calm_near(f, slope_at_a, a, end);
    const double start = last ? a : a + (end - a) / 2.0;
    const double whole = boost::math::quadrature::gauss<double, 20>::integrate(f, start, end);
    sum += refined(f, start, end, whole, std::abs(sum) + std::abs(whole), 20);
    if (last) break;
    end = start;
  }
  return sum;
}

/// The potential; at an end of its piece where it has no value (r^2 log(r) at 0) that of the next
/// number inside that has one, which it is Lipschitz to.
double potential_inside(const SmoothFunction& function, const LawGraph& graph, int piece, double r,
                        bool radial) {
  const double direct = function.potential(r, graph.x, graph.t);
  if (std::isfinite(direct) || !std::isfinite(r)) return direct;
  const double low = piece_low(graph, piece, radial), high = piece_high(graph, piece);
  if (r != low && r != high) return direct;
  const double least = std::max(0x1p-53 * std::abs(r), std::numeric_limits<double>::min());
  for (const int doubled : {1, 2, 3, 4, 6, 8}) {
    const double step = std::ldexp(least, doubled);
    const double v = function.potential(r == low ? r + step : r - step, graph.x, graph.t);
    if (std::isfinite(v)) return v;
  }
  return direct;
}

} // namespace

double primitive(const LawSpec& spec, const SmoothFunction& function, const LawGraph& graph,
                 int piece, double r) {
  const auto& p = graph.smooth[piece];
  if (p.degree >= 0) return polynomial_primitive(p, r);
  if (!spec.by_slope) return potential_inside(function, graph, piece, r, spec.radial);
  if (r == p.centre) return 0.0;
  if (!std::isfinite(r)) return std::numeric_limits<double>::quiet_NaN();
  const auto slope = [&](double s) {
    const double v = function.slope(s, graph.x, graph.t);
    return std::isfinite(v) ? v : 0.0; // only the end of a piece can be undefined, measure zero
  };
  double value = 0.0, rise = 0.0;
  function.slope_and_curvature(p.centre, graph.x, graph.t, value, rise);
  return integral(slope, rise, p.centre, r);
}

} // namespace hvi::solver
