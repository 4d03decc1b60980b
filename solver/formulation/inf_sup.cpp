// See inf_sup.hpp. The constants are eigenvalues of S = C G^-1 C^T against the matrix of |p|, found
// by solutions of a saddle point with G and C.
#include "solver/formulation/inf_sup.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/common/numbers.hpp"
#include "solver/discrete/product_form.hpp"
#include "solver/discrete/rigid_motions.hpp"
#include "solver/formulation/at_rest.hpp"
#include "solver/formulation/multiplier_norm.hpp"
#include "solver/linear/extremes.hpp"
#include "solver/linear/general_lu.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

/// So stiff, against G, are the rows that hold points at rest: several may say the same, so that
/// they are no equations of their own. What is not seen at rest has a constant of the order of
/// stiffness^-1/2, of such constants.
constexpr double stiffness = 1e9;
constexpr double least_at_rest = 3e-4; ///< of such constants, above that
constexpr double least_constant = 1e-6;

/// One unknown, p, and its couplings. All is computed with v and p in units of their shape
/// functions: G and the matrix of |p| have diagonals of 1, and the largest entry of C is 1.
class Multiplier {
public:
  /// Nothing for unknowns with a form or a law of their own.
  static std::optional<Multiplier> of(const OnMesh& on, int unknown);

  bool without_means() const { return norm_.leaves_out_means(); }
  double size() const { return size_; }
  /// beta of the v with R v = 0, R without rows: of all v.
  double constant(const SparseMatrix& held) const;
  /// The rows of laws with jumps on the other unknowns, of size 1 in these units.
  SparseMatrix rows_of_laws() const;

private:
  Multiplier(const OnMesh& on, const SparseMatrix& couplings, int unknown);
  bool is_own(Eigen::Index i) const {
    return on_.contact.of_unknown[static_cast<std::size_t>(i)] == unknown_;
  }
  SparseMatrix saddle_point(const SparseMatrix& held) const;
  Vector of_all(const Vector& p) const {
    Vector out = Vector::Zero(units_.size());
    out(own_) = p;
    return out;
  }

  const OnMesh& on_;
  int unknown_;
  MultiplierNorm norm_;
  Vector units_;
  SparseMatrix gram_, couplings_; ///< G and C in these units
  double size_ = 0.0;             ///< of C's largest entry, where G and |p| alone have them
  std::vector<int> own_;
};

std::optional<Multiplier> Multiplier::of(const OnMesh& on, int unknown) {
  const auto& of_unknown = on.contact.of_unknown;
  if (std::ranges::find(of_unknown, unknown) == of_unknown.end()) return std::nullopt;
  SparseMatrix couplings(on.layout.n_unknowns, on.layout.n_unknowns);
  for (const int field : {field_of_u(0), field_of_u(1)})
    couplings += combine(on.operators, on.operators.weights.row(field).transpose());
  const ProductForm form(couplings, of_unknown, unknowns_with_laws(on.problem),
                         couplings_of(on.problem));
  if (!form.is_multiplier(unknown)) return std::nullopt;
  return Multiplier(on, couplings, unknown);
}

Multiplier::Multiplier(const OnMesh& on, const SparseMatrix& couplings, int unknown)
    : on_(on), unknown_(unknown), norm_(on.problem, on.discretisation, on.layout, unknown),
      units_(on.gram.diagonal()) {
  const Vector of_p = norm_.diagonal();
  for (int i = 0; i < units_.size(); ++i) {
    if (is_own(i)) own_.push_back(i), units_[i] = of_p[i];
    units_[i] = 1.0 / std::sqrt(units_[i]);
  }
  couplings_ = units_.asDiagonal() * couplings * units_.asDiagonal();
  gram_ = units_.asDiagonal() * on.gram * units_.asDiagonal();
  for (const int i : own_)
    for (SparseMatrix::InnerIterator it(couplings_, i); it; ++it)
      if (!is_own(it.col())) size_ = std::max(size_, std::abs(it.value()));
  if (size_ > 0.0) couplings_ *= 1.0 / size_;
}

/// [G + stiffness R^T R, C^T; C 0].
SparseMatrix Multiplier::saddle_point(const SparseMatrix& held) const {
  const SparseMatrix gram = gram_ + stiffness * SparseMatrix(held.transpose() * held);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < gram.rows(); ++i) {
    for (SparseMatrix::InnerIterator it(gram, i); it && !is_own(i); ++it)
      if (!is_own(it.col())) entries.emplace_back(i, static_cast<int>(it.col()), it.value());
    for (SparseMatrix::InnerIterator it(couplings_, i); it && is_own(i); ++it) {
      if (is_own(it.col())) continue;
      entries.emplace_back(i, static_cast<int>(it.col()), it.value());
      entries.emplace_back(static_cast<int>(it.col()), i, it.value());
    }
  }
  SparseMatrix out(gram.rows(), gram.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

double Multiplier::constant(const SparseMatrix& held) const {
  const SparseMatrix k = saddle_point(held);
  std::unique_ptr<Factorisation> factor;
  try {
    factor = general_factor(k, {});
    factor->factor(k);
  } catch (const NotFactorable&) {
    return 0.0;
  }
  // Of the solution for [0; p] the other part is -S^-1 p.
  const auto s_inverse = [&](const Vector& p) -> Vector {
    Vector x;
    solve(*factor, of_all(p), x);
    return -x(own_);
  };
  const Vector own = units_(own_);
  const auto squares = [&](const Vector& p) -> Vector {
    return own.cwiseProduct(Vector(norm_.times(of_all(own.cwiseProduct(p)))(own_)));
  };
  const auto squared = least_by_inverse(static_cast<Eigen::Index>(own_.size()), s_inverse, squares);
  return squared ? size_ * std::sqrt(std::max(*squared, 0.0)) : not_a_number;
}

SparseMatrix Multiplier::rows_of_laws() const {
  Vector units = Vector::Zero(on_.contact.g.cols());
  for (Eigen::Index i = 0; i < units_.size(); ++i)
    if (!is_own(i)) units[i] = units_[i];
  return rows_at_rest(on_.problem, on_.contact, on_.contact.g, units).leftCols(units_.size());
}

/// Above these shares of what single entries make of it a constant is not rounding; NaN is.
bool is_seen(double beta, double size) { return beta > least_constant * size; }
bool is_seen_at_rest(double beta, double size) { return beta > least_at_rest * size; }

} // namespace

bool InfSup::sees_all() const { return is_seen(constant, size); }
bool InfSup::sees_all_at_rest() const { return !at_rest || is_seen_at_rest(*at_rest, size); }

std::vector<char> masses_in_gram(const Discretisation& d) {
  auto masses = d.dofs.needs_mass();
  for (const RigidMotions& of : motions_of_unknowns(d))
    masses[static_cast<std::size_t>(of.unknown())] = 1;
  return masses;
}

SparseMatrix gram_on_unknowns(const Discretisation& d, const StateLayout& layout) {
  return restrict_rows(gram_v(d.space, masses_in_gram(d)), layout).leftCols(layout.n_unknowns);
}

std::optional<InfSup> inf_sup(const OnMesh& on, int unknown, bool at_rest) {
  const auto p = Multiplier::of(on, unknown);
  if (!p) return std::nullopt;
  InfSup out{p->constant(SparseMatrix(0, on.gram.cols())), p->without_means(), p->size(), {}};
  if (!at_rest) return out;
  if (const SparseMatrix held = p->rows_of_laws(); held.rows() > 0) out.at_rest = p->constant(held);
  return out;
}

bool sees_multipliers_at_rest(const Problem& problem, const Discretisation& d,
                              const StateLayout& layout, const Operators& operators) {
  const Contact contact = make_contact(problem, d, layout);
  const SparseMatrix gram = gram_on_unknowns(d, layout);
  const OnMesh on{problem, d, layout, operators, contact, gram};
  for (int b = 0; b < n_unknowns(d.space); ++b)
    if (const auto p = Multiplier::of(on, b))
      if (const SparseMatrix held = p->rows_of_laws(); held.rows() > 0)
        if (!is_seen_at_rest(p->constant(held), p->size())) return false;
  return true;
}

} // namespace hvi::solver
