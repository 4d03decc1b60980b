// The norm of an unknown in its space; see space_norm.hpp.
#include "solver/results/space_norm.hpp"

#include "solver/fem/geometry.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

/// Of a body of revolution: eps(u) : eps(u) as a sum of squares, which is zero where strains are;
/// of scalars |grad u|^2.
Expr square_of_strain(const Space& space, int unknown) {
  const SpaceBlock& block = space.blocks[static_cast<std::size_t>(unknown)];
  const int dim = space.mesh->dim;
  const auto of_u = [&](int derivative) {
    return Expr::variable(slot::field(field_of_u(0), slot::of_unknown(unknown, derivative)));
  };
  Expr out(0.0);
  const auto add = [&](double factor, const Expr& e) { out = out + Expr(factor) * e * e; };
  for (int i = 0; i < block.components; ++i)
    for (int j = 0; j < dim; ++j) {
      const Expr slope = of_u(slot::gradient(i, j));
      if (block.components == 1 || i == j)
        add(1.0, slope);
      else if (i < j)
        add(0.5, slope + of_u(slot::gradient(j, i))); // twice (half of the sum)^2
    }
  if (has_hoop(space, block)) add(1.0, of_u(slot::hoop));
  return out;
}

} // namespace

SpaceNorm::SpaceNorm(const Discretisation& d, int unknown) : space_(d.space), unknown_(unknown) {
  const auto b = static_cast<std::size_t>(unknown);
  const SpaceBlock& block = space_.blocks[b];
  cells_ = cells_of(space_, block);
  const auto add = [&](const Expr& e) {
    squares_.emplace_back(space_, cells_, Rule::exact, std::vector{e});
  };
  if (block.components == 1 && d.dofs.held_of[b] == 0) {
    const Expr u =
        Expr::variable(slot::field(field_of_u(0), slot::of_unknown(unknown, slot::value(0))));
    add(u * u);
  }
  if (!space_.mesh->axisymmetric) return;
  add(square_of_strain(space_, unknown));
  cells_.entities.clear();
}

double SpaceNorm::value(const Vector& u, const FieldValues& values) const {
  const SpaceBlock& block = space_.blocks[static_cast<std::size_t>(unknown_)];
  double sum = squares_of_strain(space_, block, cells_, u);
  for (const Integrator& square : squares_) {
    double one = 0.0;
    square.integrate(values, {&one, 1});
    sum += one;
  }
  return std::sqrt(sum);
}

} // namespace hvi::solver
