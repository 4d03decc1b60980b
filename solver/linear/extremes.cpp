// Extreme generalised eigenvalues; see extremes.hpp.
#include "solver/linear/extremes.hpp"

#include "solver/common/failure.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/lanczos.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

constexpr int dense_size = 120; ///< up to here the dense solver answers at once
constexpr int few = 24; ///< up to here a solution for each unknown costs no more than Lanczos
constexpr double tolerance = 1e-9;

SparseMatrix symmetric_part(const SparseMatrix& k) {
  return SparseMatrix(0.5 * (k + SparseMatrix(k.transpose())));
}

auto metric_of(const GramForm& gram) {
  return [&gram](const Vector& v) -> Vector { return gram.matrix() * v; };
}

/// The eigenvalue next above sigma, where K - sigma G is positive definite (sigma itself, a lower
/// bound, if the iteration does not converge); nothing where it is not. `error`: relative, of the
/// eigenvalue of the inverse; that of the distance to sigma.
std::optional<double> least_above(const GramForm& gram, const SparseMatrix& k, double sigma,
                                  double error) {
  const SparseMatrix shifted = k - sigma * gram.matrix();
  try {
    const auto factor = analyse(shifted, {}, true);
    factor->factor(shifted);
    const auto shift_inverted = [&](const Vector&, const Vector& gv) {
      Vector w;
      solve(*factor, gv, w);
      return w;
    };
    const SymmetricMap inverse{k.rows(), shift_inverted, metric_of(gram)};
    if (const auto value = extreme_eigenvalue(inverse, End::largest, error))
      return sigma + 1.0 / *value;
    if (sigma > 0.0) return sigma;
  } catch (const Failure&) { // not positive definite
  }
  return std::nullopt;
}

std::optional<double> extreme(const GramForm& gram, const SparseMatrix& k, End end) {
  const auto forces_moved = [&](const Vector& v, const Vector&) {
    Vector w;
    gram.solve(k * v, w);
    return w;
  };
  return extreme_eigenvalue({k.rows(), forces_moved, metric_of(gram)}, end, tolerance);
}

/// Negative numbers with the least eigenvalue between them: K - sigma G is positive definite for
/// `below`, and not for `above`.
struct ShiftRange {
  double below, above;
  /// Halves the logarithm of below / above until that is at most `most`.
  void narrow(const GramForm& gram, const SparseMatrix& k, double most) {
    while (below / above > most) {
      const double middle = -std::sqrt(below * above);
      if (!(middle > below && middle < above)) return;
      (gram.above(k, middle) ? below : above) = middle;
    }
  }
};

/// The least eigenvalue of a K that is not positive definite. It may be far smaller than the
/// largest one (a form that couples unknowns of different units), where Lanczos' method alone needs
/// thousands of steps, and among many eigenvalues that look alike from a shift far away it may come
/// to another one than the least. So Cholesky's factorisation says between which shifts it lies,
/// and beside it the method converges at once; where it does not, the factorisation goes on.
std::optional<double> least_negative(const GramForm& gram, const SparseMatrix& k) {
  const Vector of_k = k.diagonal(), of_g = gram.matrix().diagonal();
  const double scale = (of_k.array() / of_g.array()).abs().maxCoeff();
  if (!(scale > 0.0))
    return std::nullopt; // a form between unknowns alone: its diagonal says nothing
  constexpr double rounding = 1e-12, apart = 1e3, beside = 1.02;
  const double least_size = rounding * scale;
  double size = least_size;
  while (!gram.above(k, -size))
    if ((size *= apart) > apart * scale) return std::nullopt;
  if (size == least_size) {
    const auto rough = least_above(gram, k, -size, 1e-5);
    return rough && std::abs(*rough) <= size ? 0.0 : rough;
  }
  ShiftRange range{-size, -size / apart};
  range.narrow(gram, k, beside);
  const auto sharp = least_above(gram, k, range.below, 1e-8);
  if (sharp && *sharp <= range.above) return sharp;
  range.narrow(gram, k, 1.0 + tolerance);
  return range.below;
}

/// All eigenvalues, in small spaces.
Vector dense_spectrum(const SparseMatrix& k, const SparseMatrix& g) {
  return generalised_eigenvalues(DenseMatrix(k), DenseMatrix(g));
}

} // namespace

GramForm::GramForm(SparseMatrix g) : g_(std::move(g)), factorisation_(analyse(g_, {}, true)) {
  factorisation_->factor(g_);
}

namespace {

/// Unknowns with an entry that is not 0 in their row or in their column.
std::vector<int> support(const SparseMatrix& k) {
  std::vector<bool> has(static_cast<std::size_t>(k.rows()), false);
  for (int i = 0; i < k.outerSize(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      if (it.value() == 0.0) continue;
      has[static_cast<std::size_t>(it.row())] = has[static_cast<std::size_t>(it.col())] = true;
    }
  std::vector<int> out;
  for (std::size_t i = 0; i < has.size(); ++i)
    if (has[i]) out.push_back(static_cast<int>(i));
  return out;
}

/// A form on few unknowns I. (The Krylov space of the whole matrix has no more dimensions than the
/// rank of K.)
class FormOnSome {
public:
  FormOnSome(const GramForm& gram, const SparseMatrix& k, const std::vector<int>& on) {
    const auto r = static_cast<Eigen::Index>(on.size());
    inverse_.resize(r, r), form_.resize(r, r);
    Vector unit = Vector::Zero(k.rows()), column;
    for (Eigen::Index j = 0; j < r; ++j) {
      unit[on[j]] = 1.0;
      gram.solve(unit, column);
      unit[on[j]] = 0.0;
      for (Eigen::Index i = 0; i < r; ++i) {
        inverse_(i, j) = column[on[i]];
        form_(i, j) = k.coeff(on[i], on[j]);
      }
    }
  }
  /// Of K y = lambda G_c y with G_c = ((G^-1)_II)^-1, the condensed Gram matrix.
  double largest() const { return largest_of(form_); }
  /// Of K^T G^-1 K in the place of K, whose entries are on I, too.
  double largest_square() const {
    return largest_of(DenseMatrix(form_.transpose() * inverse_ * form_));
  }

private:
  double largest_of(const DenseMatrix& form) const {
    const Eigen::Index r = inverse_.rows();
    const DenseMatrix condensed = solve_positive(inverse_, DenseMatrix::Identity(r, r));
    return generalised_eigenvalues(form, 0.5 * (condensed + condensed.transpose()))[r - 1];
  }

  DenseMatrix inverse_, form_; ///< (G^-1)_II, K_II
};

} // namespace

std::optional<double> GramForm::least(const SparseMatrix& k, double below) const {
  const SparseMatrix s = symmetric_part(k);
  if (s.rows() <= dense_size) return dense_spectrum(s, g_)[0];
  for (const double sigma : {below * (1.0 - 1e-5), 0.0})
    if (const auto value = least_above(*this, s, sigma, 1e-5)) return value;
  if (const auto value = least_negative(*this, s)) return value;
  return extreme(*this, s, End::least);
}

std::optional<double> GramForm::largest(const SparseMatrix& k) const {
  const SparseMatrix s = symmetric_part(k);
  const auto on = support(s);
  if (on.empty()) return 0.0;
  if (s.rows() <= dense_size) return dense_spectrum(s, g_)[s.rows() - 1];
  if (static_cast<int>(on.size()) <= few) return std::max(0.0, FormOnSome(*this, s, on).largest());
  if (const auto direct = extreme(*this, s, End::largest)) return direct;
  const auto opposite = least_negative(*this, -s); // it may be far smaller than the others
  return opposite ? std::optional(-*opposite) : std::nullopt;
}

bool GramForm::above(const SparseMatrix& k, double value) const {
  const SparseMatrix shifted = k - value * g_;
  try {
    analyse(shifted, {}, true)->factor(shifted);
    return true;
  } catch (const NotFactorable&) {
    return false;
  }
}

std::optional<double> GramForm::norm(const SparseMatrix& e) const {
  const auto on = support(e);
  if (on.empty()) return 0.0;
  const SparseMatrix transposed = e.transpose();
  if (e.rows() <= dense_size) { // the iteration wants two unknowns at least
    const DenseMatrix dense(g_), half = DenseCholesky(dense).solve_lower(DenseMatrix(e));
    const DenseMatrix square = half.transpose() * half; // E^T G^-1 E
    return std::sqrt(std::max(0.0, generalised_eigenvalues(square, dense)[e.rows() - 1]));
  }
  if (static_cast<int>(on.size()) <= few)
    return std::sqrt(std::max(0.0, FormOnSome(*this, e, on).largest_square()));
  const auto squared = [&](const Vector& v, const Vector&) {
    Vector y, w;
    solve(e * v, y);
    solve(transposed * y, w);
    return w;
  };
  const SymmetricMap map{e.rows(), squared, metric_of(*this)};
  const auto square = extreme_eigenvalue(map, End::largest, tolerance);
  if (!square) return std::nullopt;
  return std::sqrt(std::max(*square, 0.0));
}

std::optional<double> least_by_inverse(Eigen::Index n, const LinearMap& s_inverse,
                                       const LinearMap& m) {
  if (n <= dense_size) { // the largest of M S^-1 M x = (1/l) M x
    DenseMatrix metric(n, n), square(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      metric.col(i) = m(Vector::Unit(n, i));
      square.col(i) = m(s_inverse(metric.col(i)));
    }
    return 1.0 / generalised_eigenvalues(square, metric)[n - 1];
  }
  const SymmetricMap inverse{n, [&](const Vector&, const Vector& mv) { return s_inverse(mv); }, m};
  const auto found = extreme_eigenvalue(inverse, End::largest, tolerance);
  return found ? std::optional(1.0 / *found) : std::nullopt;
}

} // namespace hvi::solver
