// The matrix of a step with its factor, condensed to the contact unknowns; see step_matrix.hpp.
#include "solver/formulation/step_matrix.hpp"

#include "solver/linear/vector_stream.hpp"

#include <stdexcept>

namespace hvi::solver {

void StepMatrix::factor(const Vector& gamma) {
  solver_.reset(), reduced_.reset(); // which reads S of the factor
  FactoredMatrix::factor(gamma);
  contact_diagonal_.resize(static_cast<Eigen::Index>(contact_.loaded.size()));
  const Vector diagonal = dealt() != nullptr ? dealt()->diagonal() : Vector();
  for (Eigen::Index c = 0; c < contact_diagonal_.size(); ++c) {
    const int i = contact_.loaded[static_cast<std::size_t>(c)];
    contact_diagonal_[c] = dealt() != nullptr ? diagonal[i] : k().coeff(i, i);
  }
  if (contact_.none()) return;
  reduced_ = reduced_operator();
  solver_ = std::make_unique<InequalitySolver>(contact_.problem, *reduced_, options_, law_factors_);
}

double StepMatrix::bytes() const {
  return FactoredMatrix::bytes() + (reduced_ ? reduced_->bytes() : 0.0);
}

bool respond(const StepMatrix& matrix, std::span<const Vector> forces, const InequalityState& at,
             std::vector<Vector>& x, std::vector<Vector>& xi) {
  x.resize(forces.size());
  const SharedFactor& factor = matrix.factorisation();
  if (!factor) return matrix.laws()->respond(at, forces, x, xi);
  DenseMatrix y;
  std::vector<Vector> r, c;
  forward(*factor, forces, y, r);
  if (matrix.laws() == nullptr)
    c = r; // without entries
  else if (!matrix.laws()->respond(at, r, c, xi))
    return false;
  back(*factor, c, y, x);
  return true;
}

void StepMatrix::save(std::ostream& out) const {
  StateWriter w(out);
  put_vector(w, gamma());
  w.put(law_factors_);
  if (solver_) solver_->save(out);
}

void StepMatrix::restore(std::istream& in) {
  StateReader r(in, {});
  Vector saved;
  get_vector(r, saved);
  if (!saved.allFinite()) r.fail("is inconsistent");
  law_factors_ = r.get_vector<double>();
  if (!law_factors_.empty() && law_factors_.size() != slot::most_arguments * contact_.terms.size())
    r.fail("is inconsistent");
  for (const double factor : law_factors_)
    if (!(factor > 0.0)) r.fail("is inconsistent");
  try {
    factor(saved);
  } catch (const std::invalid_argument&) { // other base matrices
    r.fail("is inconsistent");
  }
  if (solver_) solver_->restore(in);
}

} // namespace hvi::solver
