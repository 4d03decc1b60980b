// Did a step cross unstable states? See snap.hpp.
#include "solver/time/snap.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int samples = 64;
/// Falls of the slope below this part of its size are rounding.
constexpr double visible = 1e-9;

/// xi(z) . dz of one point, a selection of the subdifferential.
double slope_along(const Contact& contact, const ContactPoint& point, const Vector& z0,
                   const Vector& dz, double s) {
  const auto& graph = contact.problem.graphs[point.graph];
  const auto& law = *contact.laws[point.law];
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> z =
      z0.segment(point.first_row, point.rows) + s * dz.segment(point.first_row, point.rows);
  if (!law.spec().radial)
    return law.slope(graph, piece_of(graph, z[0]), z[0]) * dz[point.first_row];
  const double r = z.norm();
  if (r == 0.0) return 0.0;
  return law.slope(graph, piece_of(graph, r), r) / r *
         z.dot(dz.segment(point.first_row, point.rows));
}

} // namespace

bool is_snap(const Contact& contact, const Vector& c, double stiffness, Vector& dz) {
  const Vector& z0 = contact.problem.offset;
  dz.noalias() = contact.problem.g * c;
  double softening = 0; // the most that the laws can take off the stiffness along d
  for (const auto& point : contact.problem.points) {
    const double m = contact.softening[point.law];
    const double moved = dz.segment(point.first_row, point.rows).squaredNorm();
    if (moved > 0) softening += point.weight * m * moved;
  }
  if (!(softening > stiffness)) return false;
  double last = 0, size = 0;
  for (int i = 0; i <= samples; ++i) {
    const double s = static_cast<double>(i) / samples;
    double slope = s * stiffness;
    for (const auto& point : contact.problem.points)
      if (!dz.segment(point.first_row, point.rows).isZero(0.0))
        slope += point.weight * slope_along(contact, point, z0, dz, s);
    size = std::max(size, std::abs(slope));
    if (i > 0 && slope < last - visible * size) return true;
    last = slope;
  }
  return false;
}

} // namespace hvi::solver
