// Moreau envelopes of the shifted laws (augmented_laws.hpp).
#include "solver/inequality/augmented_laws.hpp"

#include <algorithm>

namespace hvi::solver {

AugmentedLaws::AugmentedLaws(const Position& at, const std::vector<RiseAndFall>* parts)
    : lambda(Vector::Zero(at.points.rows)), z_ref(at.z), d(at.points.no_matrices()),
      points_(at.points), component_(at.places.component), parts_(parts), hits_(at.points.size()) {
  for (int p = 0; p < points_.size(); ++p) {
    const double m = shift(p);
    const Small x = points_[p].of(at.xi), z = points_[p].of(at.z), f = fall(p, x);
    points_[p].put(lambda, x + m * z + f);
    hits_[p].state = at.places.state[p];
  }
}

Small AugmentedLaws::fall(int p, const Small& otherwise) const {
  const int rows = points_[p].rows;
  if (!parts_) return Small::Zero(rows);
  const PreparedLaw& law = points_.law(p);
  const Small ref = points_[p].of(z_ref);
  const double size = (*parts_)[points_[p].law].fall(size_of(law, ref));
  if (!law.radial()) return along_first(rows, size);
  if (size == 0.0) return Small::Zero(rows);
  return size * direction_of(ref, otherwise);
}

Small AugmentedLaws::evaluate(int p, const Small& z, bool with_stiffness) {
  const PreparedLaw& law = points_.law(p);
  const double g = points_[p].gamma * shrink, m = shift(p);
  const Small l = points_[p].of(lambda);
  const Small y = z + g * l;
  const double size = size_of(law, y);
  hits_[p] = parts_ ? (*parts_)[points_[p].law].resolvent(size, g)
                    : law.resolvent(component_[p], size, g, hits_[p]);
  const GraphPoint& hit = hits_[p];
  const double ratio = law.radial() && size > 0.0 ? hit.z / size : 0.0;
  const bool at_break = hit.state < 0 || hit.state % 2 == 1;
  // Inside a piece (y - hit.z) / g is the slope there: a difference would divide rounding by g.
  const double slope = hit.s + m * hit.z;
  if (with_stiffness) set_stiffness(p, y, size, g);
  if (!law.radial())
    return along_first(points_[p].rows, at_break ? (z[0] - hit.z) / g + l[0] : slope);
  if (at_break || !(size > 0.0)) return (y - ratio * y) / g;
  return slope * (y / size);
}

/// At the point of the graph where `evaluate` landed for y of this size.
void AugmentedLaws::set_stiffness(int p, const Small& y, double size, double g) {
  const bool radial = points_.law(p).radial();
  const GraphPoint& hit = hits_[p];
  const double m = shift(p), ratio = radial && size > 0.0 ? hit.z / size : 0.0;
  const bool at_break = hit.state < 0 || hit.state % 2 == 1;
  const double k = m + hit.d;
  const double along = at_break ? 1.0 / g : k / (1.0 + g * k);
  const double across = (1.0 - ratio) / g;
  const int rows = points_[p].rows;
  const auto out = points_[p].block(d);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < rows; ++j) {
      const double nn = !radial ? 1.0 : (size > 0.0 ? y[i] * y[j] / (size * size) : 0.0);
      double& entry = out[rows * i + j];
      entry = (along - across) * nn + (i == j ? across : 0.0);
      if (!radial) entry = along;
      if (i == j) entry -= theta_ * m;
    }
}

Small AugmentedLaws::in_equation(int p, const Small& l, const Small& z) const {
  const double m = shift(p);
  const Small ref = points_[p].of(z_ref), f = fall(p, l);
  return l - theta_ * m * z - (1.0 - theta_) * m * ref - f;
}

void AugmentedLaws::take_concave_part(double theta) {
  theta_ = theta;
  for (int p = 0; p < points_.size(); ++p) points_[p].put_multiple(d, -theta_ * shift(p));
}

void AugmentedLaws::hand_over(Position& to) const {
  for (int p = 0; p < points_.size(); ++p) {
    const double m = shift(p);
    const Small l = points_[p].of(lambda), z = points_[p].of(to.z), f = fall(p, l);
    points_[p].put(to.xi, l - m * z - f);
    to.places.state[p] = hits_[p].state;
    if (parts_)
      to.places.component[p] = points_.law(p).component_of_piece(std::max(hits_[p].state, 0) / 2);
  }
}

} // namespace hvi::solver
