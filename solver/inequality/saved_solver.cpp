// What a solver carries from one solve to the next, as bytes (engine.hpp, inequality.hpp): the
// stiffnesses its last factor belongs to. All else is computed anew in every solve.
#include "solver/common/stream.hpp"
#include "solver/inequality/engine.hpp"

namespace hvi::solver {

void InequalityEngine::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(static_cast<std::uint8_t>(factored));
  w.put(last_cg);
  w.put(preconditioned);
  w.put(snap_factor);
  w.put(d_factored);
  w.put(static_cast<std::uint64_t>(far_columns.size())); // solved in groups: bits depend on them
  for (const auto& [unknown, column] : far_columns) {
    w.put(unknown);
    w.put(std::vector<double>(column.data(), column.data() + column.size()));
  }
  w.put(static_cast<std::uint8_t>(kept.made));
  w.put(kept.first_states);
  w.put(static_cast<std::uint64_t>(kept.updates.size()));
  for (const auto& [point, to_state] : kept.updates) w.put(point), w.put(to_state);
  w.put(kept.error);
  w.put(std::array<int, 3>{kept.waited, kept.rest, kept.pause});
}

/// Made as it was made: the bits of an inverse depend on the order of its updates.
void InequalityEngine::restore_inverse(std::istream& in) {
  StateReader r(in, {});
  const bool was_made = r.get<std::uint8_t>() != 0;
  const auto first = r.get_vector<int>();
  std::vector<std::pair<int, int>> updates;
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const int point = r.get<int>();
    updates.emplace_back(point, r.get<int>());
  }
  const double error = r.get<double>();
  const auto counts = r.get_counts<3>(1 << 25);
  kept.made = false;
  if (was_made) {
    if (!kept.possible || static_cast<int>(first.size()) != n_points)
      r.fail("has another number of contact points");
    const auto possible = [&](int point, int at_state) {
      return point >= 0 && point < n_points && at_state >= 0 &&
             prepared[points[point].law].valid_state(at_state);
    };
    bool same = true;
    for (int p = 0; p < n_points; ++p) same = same && possible(p, first[p]);
    same = same && make_inverse(first);
    for (const auto& [point, to_state] : updates)
      same = same && possible(point, to_state) && update_inverse(point, to_state);
    if (!same) r.fail("has other laws");
  }
  kept.error = error;
  kept.waited = counts[0], kept.rest = counts[1], kept.pause = counts[2];
}

/// The factor is a function of the stiffnesses, so it is computed and not stored.
void InequalityEngine::restore(std::istream& in) {
  StateReader r(in, {});
  const bool was_factored = r.get<std::uint8_t>() != 0;
  const auto [iterations, served] = r.get_counts<2>();
  last_cg = iterations;
  snap_factor = r.get_finite();
  d_factored = r.get_vector<std::array<double, 9>>();
  for (const auto& block : d_factored)
    for (const double v : block)
      if (!std::isfinite(v)) r.fail("is inconsistent");
  forget_far();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const int unknown = r.get_between(0, n - 1);
    const auto values = r.get_vector<double>(static_cast<std::size_t>(n));
    far_columns[unknown] = Eigen::Map<const Vector>(values.data(), n);
  }
  restore_inverse(in);
  factored = false;
  if (!was_factored) return;
  if (d_factored.size() != d.size()) r.fail("has another number of contact points");
  d = d_factored;
  assemble();
  factored = op.factor(h, held_unknowns());
  preconditioned = served;
  if (preconditioned >= served_long) op.expect_rough_solves();
}

} // namespace hvi::solver
