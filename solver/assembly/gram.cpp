// Gram matrices of V and L2, and boundary masses.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/pairing.hpp"
#include "solver/fem/geometry.hpp"

#include <numeric>

namespace hvi::solver {
namespace {

Region all_cells(const Space& space) {
  Region region;
  region.kind = Group::Kind::cells;
  region.entities.resize(space.mesh->cells.size());
  std::iota(region.entities.begin(), region.entities.end(), 0);
  return region;
}

/// u . v
void add_mass(const Space& space, FormTerm& term) {
  for (int i = 0; i < space.components; ++i) {
    term.entries.push_back({slot::value(i), slot::value(i), Expr(1.0)});
  }
}

} // namespace

/// eps(u) : eps(v) = 1/2 sum_ij (d_j u_i d_j v_i + d_i u_j d_j v_i); scalar: grad u . grad v.
/// Axisymmetric: with u_x v_x / x^2.
FormTerm strain_form(const Space& space) {
  FormTerm term;
  const int dim = space.mesh->dim;
  if (space.components == 1) {
    for (int j = 0; j < dim; ++j) {
      term.entries.push_back({slot::gradient(0, j), slot::gradient(0, j), Expr(1.0)});
    }
    return term;
  }
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      term.entries.push_back({slot::gradient(i, j), slot::gradient(i, j), Expr(0.5)});
      term.entries.push_back({slot::gradient(i, j), slot::gradient(j, i), Expr(0.5)});
    }
  }
  if (has_hoop(space)) {
    term.entries.push_back({slot::hoop, slot::hoop, Expr(1.0)});
  }
  return term;
}

SparseMatrix gram_v(const Space& space, bool add_mass_term) {
  SparseMatrix gram = assemble_form(space, all_cells(space), strain_form(space));
  // A second form, so that the strain keeps its cheap one-point rule.
  if (add_mass_term) {
    add_scaled(gram, 1.0, mass(space));
  }
  return gram;
}

SparseMatrix mass(const Space& space) {
  FormTerm term;
  add_mass(space, term);
  return assemble_form(space, all_cells(space), term);
}

namespace {

/// sum_p w_p [u].N[v] on a pair, N = nu nu^T, 1 - nu nu^T or 1.
SparseMatrix pair_mass(const Space& space, const Region& region, Trace trace) {
  const Pairing pairing = make_pairing(space, region);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t p = 0; p < pairing.x.size(); ++p) {
    const auto entry = [&](int i, int j) {
      const double normal = pairing.normal[p][static_cast<std::size_t>(i)] *
                            pairing.normal[p][static_cast<std::size_t>(j)];
      return trace == Trace::normal ? normal
                                    : (i == j ? 1.0 : 0.0) - (trace == Trace::full ? 0.0 : normal);
    };
    const auto row = static_cast<Eigen::Index>(p);
    for (SparseMatrix::InnerIterator a(pairing.jump, row); a; ++a)
      for (SparseMatrix::InnerIterator b(pairing.jump, row); b; ++b)
        for (int i = 0; i < space.components; ++i)
          for (int j = 0; j < space.components; ++j)
            entries.emplace_back(space.dof(static_cast<int>(a.col()), i),
                                 space.dof(static_cast<int>(b.col()), j),
                                 pairing.weight[p] * a.value() * b.value() * entry(i, j));
  }
  SparseMatrix out(space.n_dofs(), space.n_dofs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace

SparseMatrix boundary_mass(const Space& space, const Region& region, Rule rule, Trace trace) {
  if (region.is_pair()) return pair_mass(space, region, trace);
  FormTerm term;
  term.rule = rule;
  if (trace != Trace::normal) {
    add_mass(space, term);
  }
  if (trace != Trace::full) {
    const double sign = trace == Trace::normal ? 1.0 : -1.0;
    for (int i = 0; i < space.components; ++i) {
      for (int j = 0; j < space.components; ++j) {
        term.entries.push_back(
            {slot::value(i), slot::value(j),
             Expr(sign) * Expr::variable(slot::normal(i)) * Expr::variable(slot::normal(j))});
      }
    }
  }
  return assemble_form(space, region, term);
}

} // namespace hvi::solver
