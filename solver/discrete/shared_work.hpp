// What runs on one discretisation share: assembled forms, fill-reducing orderings, factors of equal
// matrices. Held by the Discretisation; a study and the search for an accuracy use it.
//
// A run that takes something from here has the same bits as one that computed it, and the seconds
// of computing it count for both: what a setting costs does not depend on what ran before.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/plan/problem.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace hvi::solver {

/// A factor of a run: its own, or one that several runs use.
class SharedFactor {
public:
  SharedFactor() = default;
  SharedFactor(std::shared_ptr<Factorisation> factor, bool shared, bool made_before);
  Factorisation* operator->() const { return factor_.get(); }
  Factorisation& operator*() const { return *factor_; }
  const Factorisation* get() const { return factor_.get(); }
  explicit operator bool() const { return factor_ != nullptr; }
  std::shared_ptr<const Factorisation> kept() const { return factor_; }
  /// Another run may use it, too: it must not be factored again for other values.
  bool is_shared() const { return shared_; }
  /// Of this run: work that another one did is not counted, its seconds are. Zeros where there is
  /// no factor.
  FactorStatistics statistics() const;

private:
  std::shared_ptr<Factorisation> factor_;
  bool shared_ = false;
  FactorStatistics before_;
};

/// What was taken over instead of computed.
struct Spared {
  int matrices = 0, orders = 0, factors = 0;
  double seconds_assembly = 0, seconds_orders = 0, seconds_factors = 0;
  double seconds() const { return seconds_assembly + seconds_orders + seconds_factors; }
};

class SharedWork {
public:
  SharedWork();
  ~SharedWork();
  SharedWork(const SharedWork&) = delete;
  SharedWork& operator=(const SharedWork&) = delete;

  /// The matrix of a form on the unknowns; a form is known by its part, rule and coefficients.
  SparseMatrix form(const FormTerm& term, const std::function<SparseMatrix()>& assemble);
  /// K factored, contact unknowns last. Throws Failure(not_coercive), and Failure(too_large) where
  /// the factor and `to_come` more bytes do not fit.
  SharedFactor factored(const SparseMatrix& k, std::span<const int> contact, bool symmetric,
                        double to_come = 0.0, FactorEntries entries = FactorEntries::doubles);
  Spared spared() const;

private:
  struct Form {
    FormTerm term;
    SparseMatrix matrix;
    double seconds;
  };
  struct Factor {
    SparseMatrix k;
    std::vector<int> contact;
    bool symmetric;
    FactorEntries entries; ///< that were asked for
    std::shared_ptr<Factorisation> factor;
    double seconds;
  };
  std::vector<Form> forms_;
  std::vector<Factor> factors_;
  std::unique_ptr<OrderStore> orders_;
  Spared spared_;
};

/// From `shared`, or made for this run alone when it is null.
SharedFactor take_factor(SharedWork* shared, const SparseMatrix& k, std::span<const int> contact,
                         bool symmetric, double to_come = 0.0,
                         FactorEntries entries = FactorEntries::doubles);
/// factorisation.factor(k) where it fits; throws Failure(too_large) where it does not.
void factor_where_it_fits(Factorisation& factorisation, const SparseMatrix& k,
                          std::size_t n_contact, double to_come);

} // namespace hvi::solver
