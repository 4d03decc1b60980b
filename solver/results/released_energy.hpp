// What states take from stored energies: bonds that are broken, layers that are worn off, damage.
//
//   of a law on u:   sum_p w_p ( j(z; beta_{n-1}) - j(z; beta_n) ),   z of u_{n-1}, both at t_n
//   of forms in u:   u . (B(z_{n-1}) - B(z_n)) u_{n-1} / 2,           u = u_{n-1}
//
// Where a scheme takes the mean of the forces of u at both ends (newmark, midpoint), u = u_n in the
// second line: then the work of these forces is the change of their energy and this, to rounding.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/step/run_state.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

class ReleasedEnergy {
public:
  /// Keeps a reference to the problem. The run stands at its initial state.
  ReleasedEnergy(const Problem& problem, const RunState& run);

  /// Of the columns: `released_NAME` of a law, `released_forms`.
  const std::vector<std::string>& names() const { return names_; }
  bool of_forms() const { return of_forms_; }
  bool of_mean_forces() const;
  /// The laws of an accepted step, which began at the full vector `before`.
  void add_laws(const RunState& run, const Vector& before);
  void add_forms(double released) { sums_.back() += released; }
  const std::vector<double>& sums() const { return sums_; }

  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  double released(const RunState& run, const ContactTerm& term, const Vector& before) const;

  const Problem& problem_;
  std::vector<int> terms_; ///< law terms with a column
  bool of_forms_ = false;
  std::vector<std::string> names_;
  std::vector<double> sums_; ///< so far: of the terms, of forms
  Vector states_;            ///< at the end of the last step
};

/// `prefix` and the name of a law term; with its part's where the law acts on several.
std::string monitor_column(const Problem& problem, const std::string& prefix, const LawTerm& term);
/// j(r). Beyond an obstacle, where only rounding takes r, it is what it is at the obstacle.
double potential_at(const Law& law, const LawGraph& graph, double r);

} // namespace hvi::solver
