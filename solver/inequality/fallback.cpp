// The globally convergent method (fallback.hpp): augmented Lagrangian with semismooth Newton
// inside.
//
// The laws are those of augmented_laws.hpp with the largest theta of a few that keeps the problem
// convex; the rest of the concave part is linearised at z_ref, which is moved along, and the energy
// does not rise (Pham Dinh Tao, Le Thi Hoai An, Convex analysis approach to d.c. programming:
// theory, algorithms and applications, Acta Math. Vietnam. 22 (1997) 289-355). For fixed
// multipliers Newton with an exact line search converges from anywhere; then they are updated
// (R. T. Rockafellar, Augmented Lagrangians and applications of the proximal point algorithm in
// convex programming, Math. Oper. Res. 1 (1976) 97-116). gamma shrinks.
#include "solver/inequality/fallback.hpp"

#include "solver/inequality/augmented_laws.hpp"
#include "solver/inequality/iterative_operator.hpp"
#include "solver/inequality/line_search.hpp"
#include "solver/inequality/multipliers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// gamma as parts of the body's compliance. An update moves a multiplier by z / gamma: a slip that
/// is all but rounding has to move one as large as a bound far above the forces at work.
constexpr double smallest_gamma = 1e-16, step_of_gamma = 10.0;
/// Below this residual, so many steps that do not halve it show that rounding is all that is left.
constexpr double nearly_solved = 1e-6;
constexpr int patience = 10;

/// The convex problem of one outer step.
class AugmentedProblem {
public:
  AugmentedProblem(Position& at, LastFactor& factor, const std::vector<RiseAndFall>* parts)
      : laws(at, parts), w_(at), factor_(factor) {}
  bool choose_theta(InequalityReport& report);
  MethodOutcome minimise(const InequalityOptions& options, InequalityReport& report);
  void update_multipliers();

  AugmentedLaws laws;

private:
  struct Place {
    Vector c, z;
  };
  struct Line { ///< c + t direction, from where z and S c are these
    Vector direction, s_direction, z_direction, z, s_c;
  };
  const Errors& gradient(bool stiffness);
  double slope_at(const Line& line, double t, double unit);
  double damping(const Line& line, double before);

  Position& w_;
  LastFactor& factor_;
  Vector multipliers_, in_equation_; ///< of the last gradient_ratio
};

/// At the present c (S c known): what is left of the equation, which is minus the gradient.
const Errors& AugmentedProblem::gradient(bool stiffness) {
  const ContactPoints& points = w_.points;
  multipliers_.resize(points.rows), in_equation_.resize(points.rows);
  for (int p = 0; p < points.size(); ++p) {
    const Small z = points[p].of(w_.z), l = laws.evaluate(p, z, stiffness);
    points[p].put(multipliers_, l);
    points[p].put(in_equation_, laws.in_equation(p, l, z));
  }
  return w_.balance.errors(w_.c, in_equation_);
}

void AugmentedProblem::update_multipliers() {
  gradient(false);
  laws.lambda = multipliers_, laws.z_ref = w_.z;
}

/// Slope of the function along the direction at step t, scaled by `unit`; monotone in t.
double AugmentedProblem::slope_at(const Line& line, double t, double unit) {
  const ContactPoints& points = w_.points;
  const Vector& load = w_.balance.load();
  double sum = 0.0;
  for (int i = 0; i < points.unknowns; ++i)
    sum += line.direction[i] / unit * (line.s_c[i] + t * line.s_direction[i] - load[i]);
  for (int p = 0; p < points.size(); ++p) {
    const Small dz = points[p].of(line.z_direction), z = points[p].of(line.z) + t * dz;
    const Small x = laws.in_equation(p, laws.evaluate(p, z, false), z);
    sum += points[p].weight * (dz / unit).dot(x);
  }
  return sum;
}

/// No energy without symmetry: a step that makes the residual smaller than `before` (largest_left).
double AugmentedProblem::damping(const Line& line, double before) {
  for (double t = 1.0; t > 1e-6; t /= 2.0) {
    w_.c += t * line.direction;
    w_.z = line.z + t * line.z_direction;
    w_.balance.product.update(w_.c);
    const double after = largest_left(gradient(false), w_.points);
    w_.c -= t * line.direction;
    w_.z = line.z;
    if (after <= (1.0 - 0.1 * t) * before) return t;
  }
  return 1e-3;
}

MethodOutcome AugmentedProblem::minimise(const InequalityOptions& options,
                                         InequalityReport& report) {
  const ReducedOperator& op = factor_.op();
  w_.balance.product.update(w_.c);
  w_.update_arguments();
  double best = std::numeric_limits<double>::infinity();
  Place nearest; // where least was left
  Line line;
  for (int k = 0, in_vain = 0; k < options.max_iterations; ++k) {
    if (options.before_iteration) options.before_iteration();
    const Errors& errors = gradient(true);
    const double ratio = errors.worst;
    if (ratio <= w_.balance.target()) return MethodOutcome::solved;
    in_vain = ratio <= 0.5 * best ? 0 : in_vain + 1;
    if (ratio < best) best = ratio, nearest = {w_.c, w_.z};
    if (best <= nearly_solved && in_vain >= patience) { // at rounding
      w_.c = nearest.c, w_.z = nearest.z;
      return best <= options.tolerance ? MethodOutcome::solved : MethodOutcome::failed;
    }
    if (!factor_.make(laws.d, report)) return MethodOutcome::indefinite;
    if (const IterativeOperator* by_iterations = op.iterative())
      by_iterations->solve_for_direction(errors.left, line.direction);
    else
      op.solve(errors.left, line.direction);
    const double unit = line.direction.lpNorm<Eigen::Infinity>();
    if (!(unit > 0.0) || !std::isfinite(unit)) return MethodOutcome::failed;
    ++report.iterations;
    line.z_direction = w_.points.g * line.direction;
    line.z = w_.z, line.s_c = w_.balance.product.value();
    double t = 1.0;
    if (op.symmetric()) {
      op.apply(line.direction, line.s_direction);
      t = line_search([&](double step) { return slope_at(line, step, unit); });
    } else {
      t = damping(line, largest_left(errors, w_.points));
    }
    w_.c += t * line.direction;
    // Not G c + g again: its rounding, which depends on the axes, would be divided by gamma.
    w_.z = line.z + t * line.z_direction;
    w_.balance.product.update(w_.c);
  }
  return MethodOutcome::failed;
}

/// The largest theta of a few that leaves the smooth part positive definite.
bool AugmentedProblem::choose_theta(InequalityReport& report) {
  for (const double candidate : {1.0, 0.75, 0.5, 0.25, 0.0}) {
    laws.take_concave_part(candidate);
    if (factor_.make(laws.d, report) && factor_.op().definite()) return true;
  }
  return false;
}

/// Beyond its end a component goes on along its tangent. Where that falls faster than the body is
/// stiff, the energy has no lower bound, and points run away: by ever longer strides, while on the
/// way to a solution they become shorter.
class RunningAway {
public:
  explicit RunningAway(const Position& at) : at_(at), tracks_(at.points.size()) {}

  /// Did a point make longer strides outwards than before, several times in a row?
  bool look() {
    bool away = false;
    for (int p = 0; p < at_.points.size(); ++p) {
      Track& track = tracks_[p];
      const double far = beyond_falling_end(p), stride = far - track.far;
      const bool longer =
          track.far > 0.0 && track.stride > 0.0 && stride > longer_by * track.stride;
      track = {far, stride, longer ? track.times + 1 : 0};
      away = away || track.times >= in_a_row;
    }
    return away;
  }

private:
  struct Track {
    double far = 0.0, stride = 0.0;
    int times = 0;
  };
  double beyond_falling_end(int p) const {
    const PreparedLaw& law = at_.points.law(p);
    if (law.components() == 1) return 0.0;
    const LawComponent& k = law.component(at_.places.component[p]);
    const double r = size_of(law, at_.points[p].of(at_.z));
    if (r > k.high && k.high_d < 0.0) return r - k.high;
    return r < k.low && k.low_d < 0.0 ? k.low - r : 0.0;
  }

  static constexpr double longer_by = 1.01;
  static constexpr int in_a_row = 3;
  const Position& at_;
  std::vector<Track> tracks_;
};

/// Is no point beyond the end of its component, where the law is another one?
bool within_components(const Position& at) {
  for (int p = 0; p < at.points.size(); ++p) {
    const PreparedLaw& law = at.points.law(p);
    if (law.components() == 1) continue;
    const LawComponent& k = law.component(at.places.component[p]);
    const double r = size_of(law, at.points[p].of(at.z)), eps = at.snap(p);
    if (r > k.high + eps || r < k.low - eps) return false;
  }
  return true;
}

/// Do the laws hold with the multipliers of the place, which are in `trial` then? Where gamma
/// cannot be `finest` any more, arguments get no nearer to their breaks than that, or ever more
/// slowly (and earlier and larger steps may have left more rounding in them than this one makes):
/// they are taken to be as near as the certificate of the run asks.
bool acceptable(Position& at, bool finest, double tolerance, Vector& trial) {
  return certain_multipliers(at, Snap::certificate, trial) <= tolerance ||
         (finest && (certain_multipliers(at, tolerance, trial) <= tolerance ||
                     likely_multipliers(at, tolerance, trial) <= tolerance));
}

MethodOutcome solve_convex_parts(Position& at, LastFactor& factor, ActiveSetNewton& newton,
                                 const std::vector<RiseAndFall>* parts,
                                 const InequalityOptions& options, InequalityReport& report) {
  report.used_fallback = true;
  at.update_arguments();
  AugmentedProblem f(at, factor, parts);
  if (!f.choose_theta(report)) return MethodOutcome::indefinite;
  double least = smallest_gamma;
  bool finest = false; // was gamma as small as it may be?
  Vector trial;
  RunningAway running(at);
  for (int outer = 0; outer < 80; ++outer) {
    const auto inner = f.minimise(options, report);
    if (inner == MethodOutcome::indefinite && f.laws.shrink >= 1.0) return inner;
    if (!parts && running.look()) return MethodOutcome::left;
    f.update_multipliers();
    const Vector kept_c = at.c;
    f.laws.hand_over(at);
    at.classify();
    if (newton.solve(at, 12, report) == MethodOutcome::solved && (!parts || within_components(at)))
      return MethodOutcome::solved;
    at.c = kept_c;
    at.update_arguments();
    f.laws.hand_over(at);
    // Where multipliers are not unique (more points than unknowns) Newton's states may never
    // settle.
    if (inner == MethodOutcome::solved && acceptable(at, finest, options.tolerance, trial)) {
      at.xi = trial;
      return MethodOutcome::solved;
    }
    // The multipliers have the rounding of z by gamma, the factor that of the body beside 1 /
    // gamma: it may be too small to solve anything.
    double& shrink = f.laws.shrink;
    if (inner != MethodOutcome::solved && shrink < 1.0)
      least = shrink = std::min(1.0, shrink * step_of_gamma);
    else
      shrink = std::max(shrink / step_of_gamma, least);
    finest = finest || shrink == least;
  }
  if (!acceptable(at, true, options.tolerance, trial)) return MethodOutcome::failed;
  at.xi = trial;
  return MethodOutcome::solved;
}

} // namespace

MethodOutcome solve_globally(Position& at, LastFactor& factor, ActiveSetNewton& newton,
                             const InequalityOptions& options, InequalityReport& report) {
  return solve_convex_parts(at, factor, newton, nullptr, options, report);
}

MethodOutcome solve_by_falls(Position& at, LastFactor& factor, ActiveSetNewton& newton,
                             const InequalityOptions& options, InequalityReport& report) {
  std::vector<RiseAndFall> parts;
  for (const PreparedLaw& law : at.points.laws.all()) parts.emplace_back(law);
  return solve_convex_parts(at, factor, newton, &parts, options, report);
}

} // namespace hvi::solver
