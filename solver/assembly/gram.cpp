// Gram matrices of V and L2, and boundary masses.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/pairing.hpp"
#include "solver/fem/geometry.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

bool has_domains(const Space& space) {
  return std::ranges::any_of(space.blocks,
                             [](const SpaceBlock& block) { return block.domain != nullptr; });
}

/// u . v of one unknown
void add_mass(const Space& space, int unknown, FormTerm& term) {
  for (int i = 0; i < space.blocks[static_cast<std::size_t>(unknown)].components; ++i) {
    const int value = slot::of_unknown(unknown, slot::value(i));
    term.entries.push_back({value, value, Expr(1.0)});
  }
}

/// Of all unknowns.
void add_mass(const Space& space, FormTerm& term) {
  for (int b = 0; b < n_unknowns(space); ++b) add_mass(space, b, term);
}

/// eps(u) : eps(v) = 1/2 sum_ij (d_j u_i d_j v_i + d_i u_j d_j v_i); scalar: grad u . grad v.
/// Axisymmetric: with u_x v_x / x^2.
FormTerm strain_form(const Space& space, int unknown) {
  FormTerm term;
  const int dim = space.mesh->dim;
  const SpaceBlock& block = space.blocks[static_cast<std::size_t>(unknown)];
  const auto add = [&](int test, int trial, double factor) {
    term.entries.push_back(
        {slot::of_unknown(unknown, test), slot::of_unknown(unknown, trial), Expr(factor)});
  };
  if (block.components == 1) {
    for (int j = 0; j < dim; ++j) add(slot::gradient(0, j), slot::gradient(0, j), 1.0);
    return term;
  }
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      add(slot::gradient(i, j), slot::gradient(i, j), 0.5);
      add(slot::gradient(i, j), slot::gradient(j, i), 0.5);
    }
  }
  if (has_hoop(space, block)) add(slot::hoop, slot::hoop, 1.0);
  return term;
}

SparseMatrix gram_of(const Space& space, const Region& cells, const FormTerm& strains,
                     const FormTerm& masses) {
  SparseMatrix gram = assemble_form(space, cells, strains);
  // A second form, so that the strain keeps its cheap one-point rule.
  if (!masses.entries.empty()) add_scaled(gram, 1.0, assemble_form(space, cells, masses));
  return gram;
}

/// Of unknowns that live on parts of their own.
template <class OfUnknown>
SparseMatrix summed(const Space& space, OfUnknown&& of_unknown) {
  SparseMatrix out(space.n_dofs(), space.n_dofs());
  for (int b = 0; b < n_unknowns(space); ++b) out = SparseMatrix(out + of_unknown(b));
  return out;
}

} // namespace

SparseMatrix gram_v(const Space& space, std::span<const char> with_mass) {
  if (has_domains(space))
    return summed(space, [&](int b) {
      return gram_of_unknown(space, b, with_mass[static_cast<std::size_t>(b)] != 0);
    });
  FormTerm strains, masses;
  for (int b = 0; b < n_unknowns(space); ++b) {
    std::ranges::copy(strain_form(space, b).entries, std::back_inserter(strains.entries));
    if (with_mass[static_cast<std::size_t>(b)] != 0) add_mass(space, b, masses);
  }
  return gram_of(space, cells_of(space, {}), strains, masses);
}

SparseMatrix gram_of_unknown(const Space& space, int unknown, bool with_mass) {
  FormTerm masses;
  if (with_mass) add_mass(space, unknown, masses);
  return gram_of(space, cells_of(space, space.blocks[static_cast<std::size_t>(unknown)]),
                 strain_form(space, unknown), masses);
}

SparseMatrix mass(const Space& space) {
  if (has_domains(space))
    return summed(space, [&](int b) {
      FormTerm own;
      add_mass(space, b, own);
      return assemble_form(space, cells_of(space, space.blocks[static_cast<std::size_t>(b)]), own);
    });
  FormTerm term;
  add_mass(space, term);
  return assemble_form(space, cells_of(space, {}), term);
}

namespace {

/// Adds sum_p w_p [u].N[v] of one unknown, N = nu nu^T, 1 - nu nu^T or 1.
void add_pair_mass(const Space& space, const SpaceBlock& block, const Pairing& pairing,
                   const SparseMatrix& jump, Trace trace,
                   std::vector<Eigen::Triplet<double>>& entries) {
  const auto entry = [&](std::size_t p, int i, int j) {
    if (trace == Trace::full) return i == j ? 1.0 : 0.0;
    const double normal = pairing.normal[p][static_cast<std::size_t>(i)] *
                          pairing.normal[p][static_cast<std::size_t>(j)];
    return trace == Trace::normal ? normal : (i == j ? 1.0 : 0.0) - normal;
  };
  for (std::size_t p = 0; p < pairing.x.size(); ++p) {
    const auto row = static_cast<Eigen::Index>(p);
    for (SparseMatrix::InnerIterator a(jump, row); a; ++a)
      for (SparseMatrix::InnerIterator b(jump, row); b; ++b)
        for (int i = 0; i < block.components; ++i)
          for (int j = 0; j < block.components; ++j)
            entries.emplace_back(space.dof(static_cast<int>(a.col()), block.first + i),
                                 space.dof(static_cast<int>(b.col()), block.first + j),
                                 pairing.weight[p] * a.value() * b.value() * entry(p, i, j));
  }
}

/// On a pair; with several unknowns Trace::normal and tangential are of the first one.
SparseMatrix pair_mass(const Space& space, const Region& region, Trace trace) {
  const Pairing pairing = make_pairing(space, region, space.order);
  const SparseMatrix straight =
      space.is_mixed() ? straightened(space, pairing.jump) : SparseMatrix();
  std::vector<Eigen::Triplet<double>> entries;
  for (const SpaceBlock& block : space.blocks) {
    const SparseMatrix& jump = block.order < space.order ? straight : pairing.jump;
    add_pair_mass(space, block, pairing, jump, trace, entries);
    if (trace != Trace::full) break;
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
    for (int i = 0; i < space.blocks.front().components; ++i) {
      for (int j = 0; j < space.blocks.front().components; ++j) {
        term.entries.push_back(
            {slot::value(i), slot::value(j),
             Expr(sign) * Expr::variable(slot::normal(i)) * Expr::variable(slot::normal(j))});
      }
    }
  }
  return assemble_form(space, region, term);
}

} // namespace hvi::solver
