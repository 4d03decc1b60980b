// See state_kinds.hpp.
#include "solver/step/state_kinds.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

std::vector<int> kinds_of_states(const Contact& contact) {
  std::vector<int> out(static_cast<std::size_t>(contact.state_values.size()), 0);
  for (const auto& group : contact.state_groups)
    for (const int i : group.states)
      std::fill_n(out.begin() + contact.first_state[static_cast<std::size_t>(i)], group.n_points,
                  i);
  return out;
}

Vector by_squared_sizes(const Vector& v, const std::vector<int>& kinds) {
  const int last = kinds.empty() ? 0 : *std::ranges::max_element(kinds);
  std::vector<double> largest(static_cast<std::size_t>(last) + 1, 0.0);
  const auto of = [&](Eigen::Index i) -> double& {
    return largest[static_cast<std::size_t>(kinds[static_cast<std::size_t>(i)])];
  };
  for (Eigen::Index i = 0; i < v.size(); ++i) of(i) = std::max(of(i), std::abs(v[i]));
  Vector out = Vector::Zero(v.size());
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (of(i) > 0.0) out[i] = v[i] / of(i) / of(i);
  return out;
}

} // namespace hvi::solver
