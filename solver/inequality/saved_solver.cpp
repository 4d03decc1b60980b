// What a solver carries from one solve to the next, as bytes (engine.hpp, inequality.hpp): the
// stiffnesses its last factor belongs to, the inverse, and whether the problem is convex. All else
// is computed anew in every solve.
#include "solver/common/stream.hpp"
#include "solver/inequality/engine.hpp"

#include <cmath>

namespace hvi::solver {

void InequalityEngine::save(std::ostream& out) const {
  StateWriter w(out);
  const Preconditioner& preconditioner = parts_.tangent.preconditioner();
  w.put(static_cast<std::uint8_t>(parts_.factor.made()));
  w.put(parts_.tangent.last_iterations());
  w.put(preconditioner.served());
  w.put(parts_.at.snap.factor);
  w.put(parts_.factor.stiffnesses());
  // Columns are solved for in groups: their bits depend on them.
  w.put(static_cast<std::uint64_t>(preconditioner.columns().size()));
  for (const auto& [unknown, column] : preconditioner.columns()) {
    w.put(unknown);
    w.put(std::vector<double>(column.data(), column.data() + column.size()));
  }
  parts_.inverse.save(w);
  const auto convex = parts_.follower.convexity();
  w.put(convex ? static_cast<std::uint8_t>(*convex) : std::uint8_t{2}); // 2: not known
}

/// The factor is a function of the stiffnesses, so it is computed and not stored.
void InequalityEngine::restore(std::istream& in) {
  StateReader r(in, {});
  const bool was_factored = r.get<std::uint8_t>() != 0;
  const auto [last_iterations, served] = r.get_counts<2>();
  parts_.at.snap.factor = r.get_finite();
  auto stiffnesses = r.get_numbers();
  FarColumns columns;
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const int unknown = r.get_between(0, parts_.points.unknowns - 1);
    const auto values = r.get_vector<double>(static_cast<std::size_t>(parts_.points.unknowns));
    columns[unknown] = Eigen::Map<const Vector>(values.data(), parts_.points.unknowns);
  }
  parts_.inverse.restore(r);
  const int convex = r.get_between<std::uint8_t>(0, 2);
  parts_.follower.restore(convex == 2 ? std::nullopt : std::optional(convex == 1));
  if (was_factored && stiffnesses.size() != parts_.points.entries)
    r.fail("has another number of contact points");
  parts_.factor.remake(std::move(stiffnesses), was_factored);
  parts_.tangent.restore(last_iterations, std::move(columns), was_factored ? served : 0);
}

} // namespace hvi::solver
