// Matrices, orders and factors that runs share; see shared_work.hpp.
#include "solver/discrete/shared_work.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/linear/ordering.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

constexpr std::size_t most_forms = 8, most_kept = 2;
constexpr double most_bytes = 1e9; ///< of a factor that is kept

template <class T>
bool equal(const T* a, const T* b, Eigen::Index n) {
  return std::equal(a, a + n, b);
}

bool same(const SparseMatrix& a, const SparseMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
         equal(a.outerIndexPtr(), b.outerIndexPtr(), a.rows() + 1) &&
         equal(a.innerIndexPtr(), b.innerIndexPtr(), a.nonZeros()) &&
         equal(a.valuePtr(), b.valuePtr(), a.nonZeros());
}

bool same(const FormTerm& a, const FormTerm& b) {
  return a.part == b.part && a.rule == b.rule &&
         std::equal(a.entries.begin(), a.entries.end(), b.entries.begin(), b.entries.end(),
                    [](const auto& x, const auto& y) {
                      return x.test == y.test && x.trial == y.trial &&
                             x.coefficient == y.coefficient;
                    });
}

} // namespace

SharedFactor::SharedFactor(std::shared_ptr<Factorisation> factor, bool shared, bool made_before)
    : factor_(std::move(factor)), shared_(shared) {
  if (made_before) before_ = factor_->statistics();
}

FactorStatistics SharedFactor::statistics() const {
  if (!factor_) return {};
  auto out = factor_->statistics();
  out.analyses -= before_.analyses;
  out.factorisations -= before_.factorisations;
  out.triangular_solves -= before_.triangular_solves;
  out.bytes_read -= before_.bytes_read;
  return out;
}

SharedWork::SharedWork() : orders_(std::make_unique<OrderStore>()) {}
SharedWork::~SharedWork() = default;

SparseMatrix SharedWork::form(const FormTerm& term, const std::function<SparseMatrix()>& assemble) {
  for (const Form& known : forms_)
    if (same(known.term, term)) {
      ++spared_.matrices;
      spared_.seconds_assembly += known.seconds;
      return known.matrix;
    }
  const double start = cpu_seconds();
  auto made = assemble();
  if (forms_.size() == most_forms) forms_.erase(forms_.begin());
  forms_.push_back({term, made, cpu_seconds() - start});
  return made;
}

SharedFactor SharedWork::factored(const SparseMatrix& k, std::span<const int> contact,
                                  bool symmetric, double to_come, FactorEntries entries) {
  for (const Factor& known : factors_) {
    const bool free = known.factor.use_count() == 1; // what a forward solve keeps is for one user
    if (!free || known.symmetric != symmetric || known.entries != entries ||
        !std::ranges::equal(known.contact, contact) || !same(known.k, k))
      continue;
    ++spared_.factors;
    spared_.seconds_factors += known.seconds;
    return {known.factor, true, true};
  }
  const double start = cpu_seconds();
  std::shared_ptr<Factorisation> made = analyse(k, contact, symmetric, orders_.get(), entries);
  factor_where_it_fits(*made, k, contact.size(), to_come);
  const double seconds = cpu_seconds() - start + orders_->seconds_of_last();
  if (made->statistics().bytes > most_bytes) return {made, false, false};
  if (factors_.size() == most_kept) factors_.erase(factors_.begin());
  factors_.push_back({k, {contact.begin(), contact.end()}, symmetric, entries, made, seconds});
  return {made, true, false};
}

Spared SharedWork::spared() const {
  Spared out = spared_;
  out.orders = orders_->reused();
  out.seconds_orders = orders_->seconds_spared();
  return out;
}

/// The factor, the values of K in its order, and of the contact unknowns S, its factor and what
/// Newton's method makes of them.
void factor_where_it_fits(Factorisation& factorisation, const SparseMatrix& k,
                          std::size_t n_contact, double to_come) {
  const auto contacts = static_cast<double>(n_contact);
  const double factor = factorisation.statistics().bytes,
               values = 4.0 * static_cast<double>(k.nonZeros()),
               dense = 2.0 * sizeof(double) * contacts * contacts;
  require_memory(factor + values + dense + to_come,
                 fmt::format("the factor of a matrix of {} unknowns ({})", k.rows(),
                             to_come > 0.0
                                 ? bytes_text(factor) + ") and its memories (" + bytes_text(to_come)
                                 : bytes_text(factor)));
  factorisation.factor(k);
}

SharedFactor take_factor(SharedWork* shared, const SparseMatrix& k, std::span<const int> contact,
                         bool symmetric, double to_come, FactorEntries entries) {
  if (shared != nullptr) return shared->factored(k, contact, symmetric, to_come, entries);
  std::shared_ptr<Factorisation> made = analyse(k, contact, symmetric, nullptr, entries);
  factor_where_it_fits(*made, k, contact.size(), to_come);
  return {made, false, false};
}

} // namespace hvi::solver
