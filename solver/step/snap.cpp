// Did a step cross unstable states? See snap.hpp.
#include "solver/step/snap.hpp"

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
  double along = 0.0, square = 0.0;
  for (int row = point.first_row; row < point.first_row + point.rows; ++row) {
    const double z = z0[row] + s * dz[row];
    if (!law.spec().radial) return law.slope(graph, piece_of(graph, z), z) * dz[row];
    along += z * dz[row], square += z * z;
  }
  const double r = std::sqrt(square);
  return r == 0.0 ? 0.0 : law.slope(graph, piece_of(graph, r), r) / r * along;
}

} // namespace

bool is_snap(const Contact& contact, const Vector& c, double stiffness, Vector& dz) {
  const Vector& z0 = contact.problem.offset;
  dz.noalias() = contact.problem.g * c;
  for (const auto& term : contact.terms) // no path leads from one rate to another
    if (term.field != field_of_u(0)) dz.segment(term.first_row, term.n_rows()).setZero();
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
