// See held_by_laws.hpp.
#include "solver/discrete/held_by_laws.hpp"

#include "solver/common/joined.hpp"
#include "solver/common/numbers.hpp"
#include "solver/discrete/nearest_point.hpp"
#include "solver/law/slope_bounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace hvi::solver {
namespace {

/// Laws see a motion whose arguments move by more than this part of it.
constexpr double least_seen = 1e-9;
/// Rays and motions whose scalar product is below this part of their sizes are at right angles.
constexpr double no_angle = 1e-12;

/// Of a body, or of one unknown's part of it.
DenseMatrix seen_by_laws(const auto& body, const Contact& contact) {
  return contact.g.leftCols(body.on_unknowns.rows()) * body.on_unknowns;
}

/// What a law's subgradients at a point lie between: an interval, or a ball of radius `high`.
struct Range {
  double low = 0.0, high = 0.0;
  bool empty() const { return low == 0.0 && high == 0.0; }
};

/// The multipliers that laws admit at their points, whatever the arguments.
class Admitted {
public:
  Admitted(const FreeBody::Part& body, const Contact& contact, double t)
      : contact_(contact), t_(t), seen_(seen_by_laws(body, contact)) {
    for (const auto& term : contact.terms)
      for (int p = 0; p < term.n_points(); ++p) add(term, p);
  }

  /// Motions that the laws which do anything at this time do not see.
  DenseMatrix unseen() const {
    DenseMatrix acting = seen_;
    for (const auto& point : points_)
      if (point.range.empty() && point.host < 0)
        acting.middleRows(point.first, point.rows).setZero();
    return kernel(acting, least_seen);
  }

  Vector start() const {
    Vector out = Vector::Zero(seen_.cols());
    for (const auto& point : points_)
      if (point.rows == 1)
        add_force(point, std::clamp(0.0, point.range.low, point.range.high), out);
    return out;
  }

  /// The farthest along y of what they do to the motions.
  Support support(const Vector& y) const {
    Support best{Vector::Zero(y.size()), false};
    Support ray{Vector::Zero(y.size()), true};
    const double along = no_angle * y.norm();
    double farthest = along;
    for (const auto& point : points_) {
      if (point.host >= 0) continue; // goes with its host
      const Part part = farthest_of(point, y);
      if (!part.ray) {
        best.q += part.q;
        continue;
      }
      const Vector q = part.q.normalized();
      if (q.dot(y) > farthest) farthest = q.dot(y), ray.q = q;
    }
    return farthest > along ? ray : best;
  }

private:
  struct Point {
    int first = 0, rows = 1;
    double weight = 0.0;
    Range range;
    int host = -1;  ///< Coulomb: the point whose multiplier bounds it
    int guest = -1; ///< the point that is bounded by this one's
    /// Of a guest: its bound for a multiplier of +-1 of the host, growing with its size.
    double at_plus = 0.0, at_minus = 0.0;
  };
  using Part = Support;

  void add(const ContactTerm& term, int p);
  Range range_of(const ContactTerm& term, int p);
  void bind(const ContactTerm& term, int p, Point& guest);
  Part farthest_of(const Point& point, const Vector& y) const;
  void add_force(const Point& point, double xi, Vector& out) const {
    out += point.weight * xi * seen_.row(point.first).transpose();
  }
  /// The same of a ball of this radius.
  void add_friction(const Point& point, double radius, const Vector& y, Vector& out) const {
    const auto rows = seen_.middleRows(point.first, point.rows);
    const Vector moved = rows * y;
    if (const double size = moved.norm(); size > 0.0)
      out += point.weight * radius / size * (rows.transpose() * moved);
  }
  void add_pressed(const Point& point, double xi, const Vector& y, Vector& out) const {
    add_force(point, xi, out);
    if (point.guest < 0) return;
    const Point& guest = points_[static_cast<std::size_t>(point.guest)];
    add_friction(guest, std::abs(xi) * (xi < 0.0 ? guest.at_minus : guest.at_plus), y, out);
  }

  const Contact& contact_;
  double t_;
  DenseMatrix seen_;
  std::vector<Point> points_;
  std::map<int, int> by_row_;   ///< of xi, the point of a scalar law
  std::map<int, Range> ranges_; ///< by graph
};

void Admitted::add(const ContactTerm& term, int p) {
  const auto& of = contact_.problem.points[static_cast<std::size_t>(term.first_point + p)];
  Point point{of.first_row, of.rows, of.weight, {}};
  if (term.coupled_row >= 0)
    bind(term, p, point);
  else
    point.range = range_of(term, p);
  if (of.rows == 1) by_row_[of.first_row] = static_cast<int>(points_.size());
  points_.push_back(point);
}

/// Laws that read states or memories may have any subgradient: these change within the step.
Range Admitted::range_of(const ContactTerm& term, int p) {
  const auto& of = contact_.problem.points[static_cast<std::size_t>(term.first_point + p)];
  const Law& law = *contact_.laws[static_cast<std::size_t>(of.law)];
  if (law.reads() || law.reads_states()) return {-infinity, infinity};
  const auto known = ranges_.find(of.graph);
  if (known != ranges_.end()) return known->second;
  const auto bounds =
      slope_bounds(law, contact_.problem.graphs[static_cast<std::size_t>(of.graph)]);
  Range out{bounds.low, bounds.high};
  if (law.spec().radial) {
    const double most = std::max(std::abs(bounds.low), std::abs(bounds.high));
    out = {-most, most};
  }
  return ranges_[of.graph] = out;
}

/// Coulomb's bound, where it is proportional to the multiplier; else any friction is admitted.
void Admitted::bind(const ContactTerm& term, int p, Point& guest) {
  const auto& of = contact_.problem.points[static_cast<std::size_t>(term.first_point + p)];
  const Law& law = *contact_.laws[static_cast<std::size_t>(of.law)];
  guest.range = {-infinity, infinity};
  const auto host = by_row_.find(term.coupled_row + p);
  if (host == by_row_.end() || law.reads() || law.reads_states()) return;
  const auto bound = [&](double xi) {
    const auto bounds =
        slope_bounds(law, law.graph(term.points.x[static_cast<std::size_t>(p)], LawTime(t_, xi)));
    return std::max(std::abs(bounds.low), std::abs(bounds.high));
  };
  const double plus = bound(1.0), minus = bound(-1.0);
  const auto grows = [&](double xi, double by) {
    return std::abs(bound(xi) - std::abs(xi) * by) <= 1e-12 * std::abs(xi) * by;
  };
  if (bound(0.0) != 0.0 || !grows(1e3, plus) || !grows(-1e3, minus)) return;
  guest.host = host->second, guest.at_plus = plus, guest.at_minus = minus;
  points_[static_cast<std::size_t>(host->second)].guest = static_cast<int>(points_.size());
}

Admitted::Part Admitted::farthest_of(const Point& point, const Vector& y) const {
  Part out{Vector::Zero(y.size()), false};
  if (point.rows > 1 || (point.range.low == -point.range.high && point.guest < 0)) {
    out.ray = std::isinf(point.range.high);
    add_friction(point, out.ray ? 1.0 : point.range.high, y, out.q);
    if (!(out.q.dot(y) > no_angle * out.q.norm() * y.norm())) out = {Vector::Zero(y.size()), false};
    return out;
  }
  // The ends of the interval, and 0 where friction makes a cone with its tip there.
  double most = -infinity;
  for (const double end : {point.range.low, point.range.high, 0.0}) {
    const bool ray = std::isinf(end);
    if (!ray && (end < point.range.low || end > point.range.high)) continue;
    Vector q = Vector::Zero(y.size());
    add_pressed(point, ray ? std::copysign(1.0, end) : end, y, q);
    const double along = q.dot(y);
    if (ray && !(along > no_angle * q.norm() * y.norm())) continue;
    if (ray || (!out.ray && along > most)) out = {q, ray}, most = along;
    if (ray) return out;
  }
  return out;
}

} // namespace

namespace {

/// Combinations of motions of one unknown that K does not resist.
DenseMatrix not_resisted(const MotionForces& of, const Space& space, const StateLayout& layout) {
  if (space.is_product()) return kernel(resistance(of, space, layout.dof_of), product_of_rounding);
  return kernel(of.forces, product_of_rounding * mean_size(of.sizes));
}

/// Those that K^T does not see, and those others that K does not see. A constant temperature
/// strains a body, but whatever the state is the forms do nothing along it, which is all that (*)
/// says.
struct Unseen {
  DenseMatrix by_transposed, by_matrix_alone;
  Unseen(const ForcesOfMotions& by_k, const DenseMatrix& motions, const Space& space,
         const StateLayout& layout)
      : by_transposed(not_resisted(by_k(motions, true), space, layout)),
        by_matrix_alone(not_resisted(by_k(motions, false), space, layout)) {
    if (by_matrix_alone.cols() > 0 && by_transposed.cols() > 0)
      by_matrix_alone *= kernel(by_transposed.transpose() * by_matrix_alone, least_seen);
  }
};

} // namespace

std::shared_ptr<const FreeBody> find_free_body(std::span<const RigidMotions> motions,
                                               const SparseMatrix& k, const StateLayout& layout) {
  if (k.rows() != layout.n_unknowns) return nullptr;
  return find_free_body(
      motions,
      [&](const DenseMatrix& v, bool transposed) {
        return transposed ? forces_of(SparseMatrix(k.transpose()), v) : forces_of(k, v);
      },
      layout);
}

std::shared_ptr<const FreeBody> find_free_body(std::span<const RigidMotions> motions,
                                               const ForcesOfMotions& by_k,
                                               const StateLayout& layout) {
  if (motions.empty()) return nullptr;
  FreeBody out;
  Eigen::Index count = 0;
  for (const RigidMotions& of : motions) {
    const DenseMatrix all =
        of.on({layout.dof_of.data(), static_cast<std::size_t>(layout.n_unknowns)});
    const Unseen unseen(by_k, all, of.space(), layout);
    const auto take = [&](const DenseMatrix& chosen, bool balances) {
      if (chosen.cols() == 0) return;
      count += chosen.cols();
      out.parts.push_back({of, all * chosen, chosen, balances});
    };
    take(unseen.by_transposed, true);
    take(unseen.by_matrix_alone, false);
  }
  if (out.parts.empty()) return nullptr;
  out.on_unknowns.resize(layout.n_unknowns, count);
  count = 0;
  for (const auto& part : out.parts) {
    out.on_unknowns.middleCols(count, part.chosen.cols()) = part.on_unknowns;
    count += part.chosen.cols();
  }
  return std::make_shared<const FreeBody>(std::move(out));
}

/// Parts below `not_told` of the largest one are left out.
std::string FreeBody::describe(const Vector& combination) const {
  constexpr double not_told = 1e-6;
  std::vector<std::string> out;
  Eigen::Index at = 0;
  for (const Part& part : parts) {
    const Vector mine = combination.segment(at, part.chosen.cols());
    at += mine.size();
    if (mine.norm() > not_told * combination.norm()) out.push_back(part.describe(mine));
  }
  return joined(out, " and ");
}

namespace {

std::vector<std::string> each_in_words(const auto& body, const DenseMatrix& combinations) {
  std::vector<std::string> out;
  for (Eigen::Index i = 0; i < combinations.cols(); ++i)
    out.push_back(body.describe(combinations.col(i)));
  return out;
}

} // namespace

std::vector<std::string> free_motions(const FreeBody& body) {
  const Eigen::Index n = body.on_unknowns.cols();
  return each_in_words(body, DenseMatrix::Identity(n, n));
}

std::vector<std::string> unseen_motions(const FreeBody& body, const Contact& contact) {
  return each_in_words(body, kernel(seen_by_laws(body, contact), least_seen));
}

bool held_strongly(const FreeBody& body, const Contact& contact) {
  if (!std::ranges::all_of(body.parts, &FreeBody::Part::balances)) return false;
  const auto rises = [&](const ContactPoint& point) {
    const Law& law = *contact.laws[static_cast<std::size_t>(point.law)];
    if (law.depends_on_t()) return false;
    const LawGraph& graph = contact.problem.graphs[static_cast<std::size_t>(point.graph)];
    const bool radial = law.spec().radial; // across r the slope rises like s(r)/r
    if (radial && law.slope(graph, 0, 0.0) < 0.0) return false;
    for (int piece = 0; piece < graph.pieces(); ++piece) {
      const auto curvature = law.curvature_range(graph, piece, piece_low(graph, piece, radial),
                                                 piece_high(graph, piece));
      if (!(curvature.low > 0.0) || !curvature.exact) return false;
    }
    return true;
  };
  DenseMatrix seen = seen_by_laws(body, contact);
  for (const auto& point : contact.problem.points)
    if (!rises(point)) seen.middleRows(point.first_row, point.rows).setZero();
  return kernel(seen, least_seen).cols() == 0;
}

void refuse_free(const std::vector<std::string>& motions, const std::string& when,
                 const Origin& origin) {
  if (motions.empty()) return;
  throw Failure(FailureKind::not_coercive, origin,
                fmt::format("nothing holds the body{}, neither values nor forms nor laws: {}", when,
                            joined(motions, "; ")),
                "impose a value, or add a law or a term that resists the motion");
}

/// A law sees one unknown, so C is the product of sets of each.
void refuse_unbalanced(const FreeBody& body, const Contact& contact, const Problem& problem,
                       const Vector& r, double t) {
  const Origin origin =
      problem.loads.empty() ? problem.law_terms.front().origin : problem.loads.front().origin;
  const std::string when =
      problem.time.is_static ? std::string() : fmt::format(" at t = {:.6g}", t);
  for (const FreeBody::Part& part : body.parts) {
    const Admitted admitted(part, contact, t);
    refuse_free(each_in_words(part, admitted.unseen()), when, origin);
    if (!part.balances) continue;
    const auto nearest = nearest_point(part.on_unknowns.transpose() * r, admitted.start(),
                                       [&](const Vector& y) { return admitted.support(y); });
    if (!nearest.outside) continue;
    throw Failure(FailureKind::not_coercive, origin,
                  fmt::format("the laws that hold the body cannot balance its load{}: {}", when,
                              part.describe(nearest.apart)),
                  "the resultant of the loads has to press into what laws resist: change it, "
                  "strengthen the laws, or impose a value");
  }
}

std::string runaway(const FreeBody& body, const Vector& d) {
  const Vector motion = least_squares(body.on_unknowns, d);
  if (!motion.allFinite() || motion.isZero(0.0)) return "laws alone hold the body";
  return "laws alone hold the body, and nothing stopped it: " + body.describe(motion);
}

double balance_error(const FreeBody& body, const Contact& contact, const Vector& r,
                     const Vector& xi) {
  double worst = 0.0;
  for (const FreeBody::Part& part : body.parts) {
    if (!part.balances) continue;
    const Vector left = part.on_unknowns.transpose() * (r - contact.force * xi);
    const Vector size = part.on_unknowns.cwiseAbs().transpose() *
                        (r.cwiseAbs() + contact.force.cwiseAbs() * xi.cwiseAbs());
    for (Eigen::Index i = 0; i < left.size(); ++i)
      if (const double error = std::abs(left[i]) / size[i]; left[i] != 0.0 && !(error <= worst))
        worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
  }
  return worst;
}

} // namespace hvi::solver
