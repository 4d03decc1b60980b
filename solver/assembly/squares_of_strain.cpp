// int eps(u) : eps(u) dx, cell by cell; see assembly.hpp.
//
// grad u is constant in a cell of P1 and linear in one of P2. With the gradients g_b of the
// barycentric coordinates, whose sum is zero, its value at the vertex k is
//   P1: sum_b (u_b - u_k) (x) g_b         P2: sum_b (4 u_kb - u_b - 3 u_k) (x) g_b
// over the other vertices b, with u_kb on the edge between k and b. Translations fall out before
// anything is squared.
#include "solver/assembly/assembly.hpp"
#include "solver/fem/element.hpp"

#include <Eigen/LU>

#include <array>
#include <cmath>

namespace hvi::solver {
namespace {

template <int rows, int columns>
using Fixed = Eigen::Matrix<double, rows, columns>;

/// sym grad u of a vector, grad u of a scalar.
template <int n, int dim>
Fixed<n, dim> strain(const Fixed<n, dim>& slope) {
  if constexpr (n == dim && n > 1)
    return 0.5 * (slope + slope.transpose());
  else
    return slope;
}

/// Of the unknown's cells, one after the other.
template <int n, int dim>
class Cells {
public:
  Cells(const Space& space, const SpaceBlock& block, const Vector& u)
      : space_(space), u_(u.data() + block.first) {
    int at = dim + 1; // edges' nodes stand behind the vertices
    for (const auto& [a, b] : simplex_edges(dim)) edge_[a][b] = edge_[b][a] = at++;
  }

  double square_p1(int cell) {
    go_to(cell);
    Fixed<n, dim> moved;
    for (int b = 0; b < dim; ++b) moved.col(b) = value(b + 1) - value(0);
    return measure_ * strain<n, dim>(moved * g_).squaredNorm();
  }

  /// Of what is linear, with e_k at the vertices:
  /// |cell| (sum_k e_k^2 + (sum_k e_k)^2) / ((dim + 1) (dim + 2))
  double square_p2(int cell) {
    go_to(cell);
    double squares = 0.0;
    Fixed<n, dim> all = Fixed<n, dim>::Zero();
    for (int k = 0; k <= dim; ++k) {
      const Fixed<n, dim> here = strain<n, dim>(slope_at(k));
      squares += here.squaredNorm();
      all += here;
    }
    return measure_ * (squares + all.squaredNorm()) / ((dim + 1.0) * (dim + 2.0));
  }

private:
  void go_to(int cell) {
    nodes_ = space_.nodes_of_cell(cell).data();
    Fixed<dim, dim> edges;
    for (int i = 0; i < dim; ++i)
      for (int b = 0; b < dim; ++b)
        edges(i, b) = space_.nodes[nodes_[b + 1]][i] - space_.nodes[nodes_[0]][i];
    constexpr double simplices_in_a_box[] = {1.0, 1.0, 2.0, 6.0};
    bool regular = true;
    double determinant = 0.0;
    edges.computeInverseAndDetWithCheck(g_, determinant, regular, 0.0);
    measure_ = std::abs(determinant) / simplices_in_a_box[dim];
  }

  Eigen::Map<const Fixed<n, 1>> value(int i) const {
    return Eigen::Map<const Fixed<n, 1>>(u_ +
                                         static_cast<Eigen::Index>(nodes_[i]) * space_.components);
  }

  Fixed<n, dim> slope_at(int k) const {
    Fixed<n, dim> moved = Fixed<n, dim>::Zero(); // by b - 1
    for (int b = 0; b <= dim; ++b) {
      if (b == k) continue;
      const Fixed<n, 1> change = 4.0 * (value(edge_[k][b]) - value(k)) - (value(b) - value(k));
      if (b == 0)
        moved.colwise() -= change; // g_0 is less the sum of the others
      else
        moved.col(b - 1) += change;
    }
    return moved * g_;
  }

  const Space& space_;
  const double* u_; ///< from the unknown's first component on
  std::array<std::array<int, dim + 1>, dim + 1> edge_{};
  const std::int32_t* nodes_ = nullptr;
  double measure_ = 0.0;
  Fixed<dim, dim> g_ = Fixed<dim, dim>::Zero(); ///< of the vertices 1 .. dim, a row each
};

template <int n, int dim>
double sum(const Space& space, const SpaceBlock& block, const Region& cells, const Vector& u) {
  Cells<n, dim> at(space, block, u);
  double out = 0.0;
  for (const int cell : cells.entities)
    out += block.order == 1 ? at.square_p1(cell) : at.square_p2(cell);
  return out;
}

} // namespace

double squares_of_strain(const Space& space, const SpaceBlock& block, const Region& cells,
                         const Vector& u) {
  const bool scalar = block.components == 1;
  switch (space.mesh->dim) {
  case 1:
    return sum<1, 1>(space, block, cells, u);
  case 2:
    return scalar ? sum<1, 2>(space, block, cells, u) : sum<2, 2>(space, block, cells, u);
  default:
    return scalar ? sum<1, 3>(space, block, cells, u) : sum<3, 3>(space, block, cells, u);
  }
}

} // namespace hvi::solver
