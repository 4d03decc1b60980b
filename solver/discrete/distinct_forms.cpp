// See distinct_forms.hpp.
#include "solver/discrete/distinct_forms.hpp"

#include "solver/discrete/proportional.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace hvi::solver {
namespace {

bool is_constant(const FormTerm& term) {
  return std::all_of(term.entries.begin(), term.entries.end(),
                     [](const auto& entry) { return entry.coefficient.is_constant(); });
}

/// What its kind says of the tensor of a form, where it was written with one.
bool is_of_kind(const Problem& problem, const FormTerm& term, auto says) {
  return term.tensor && says(problem.tensors[static_cast<std::size_t>(term.tensor->index)].kind);
}

} // namespace

DistinctTerms distinct_terms(const Problem& problem, int n_fields,
                             const std::function<bool(const FormTerm&)>& chosen) {
  DistinctTerms out;
  for (const auto& term : problem.forms) {
    if (!chosen(term)) continue;
    std::size_t known = 0;
    double ratio = 1.0;
    for (; known < out.terms.size(); ++known)
      if (const auto r = symbolic_ratio(term, *out.terms[known])) {
        ratio = *r;
        break;
      }
    if (known == out.terms.size()) {
      out.terms.push_back(&term);
      out.weights.push_back(Vector::Zero(n_fields));
    }
    out.weights[known][term.field] += ratio;
  }
  return out;
}

bool is_mirrored(const Problem& problem, const FormTerm& term) {
  if (!is_constant(term)) return false;
  if (is_of_kind(problem, term, [](auto kind) { return kind == TensorSpec::Kind::isotropic; }))
    return true; // other materials in axes of their own: to rounding only
  std::map<std::pair<int, int>, double> c;
  for (const auto& entry : term.entries) c[{entry.test, entry.trial}] += entry.coefficient.value();
  return std::all_of(c.begin(), c.end(), [&](const auto& one) {
    const auto mirror = c.find({one.first.second, one.first.first});
    return mirror != c.end() ? mirror->second == one.second : one.second == 0.0;
  });
}

bool stays_mirrored(const FormTerm& term) {
  std::map<std::pair<int, int>, Expr> c;
  for (const auto& entry : term.entries) {
    const auto [at, fresh] = c.try_emplace({entry.test, entry.trial}, entry.coefficient);
    if (!fresh) at->second = at->second + entry.coefficient;
  }
  return std::all_of(c.begin(), c.end(), [&](const auto& one) {
    const auto mirror = c.find({one.first.second, one.first.first});
    return mirror != c.end() ? mirror->second == one.second : one.second.is(0.0);
  });
}

bool has_symmetric_tensor(const Problem& problem, const FormTerm& term) {
  return is_of_kind(problem, term, has_major_symmetry);
}

void merge_equal_values(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights) {
  for (std::size_t j = 1; j < matrices.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const auto ratio = numeric_ratio(matrices[j], matrices[i]);
      if (!ratio) continue;
      weights[i] += *ratio * weights[j];
      matrices.erase(matrices.begin() + j);
      weights.erase(weights.begin() + j);
      --j;
      break;
    }
}

void merge_equal_weights(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights) {
  for (std::size_t j = 1; j < matrices.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const auto ratio = column_ratio(weights[j], weights[i]);
      if (!ratio) continue;
      matrices[i] = SparseMatrix(matrices[i] + *ratio * matrices[j]);
      matrices.erase(matrices.begin() + j);
      weights.erase(weights.begin() + j);
      --j;
      break;
    }
}

} // namespace hvi::solver
