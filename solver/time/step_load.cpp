// See step_load.hpp. Used by Balance and by the energies that check it.
#include "solver/time/step_load.hpp"

namespace hvi::solver {

void add_step_load(const LoadAssembler& loads, const TimeSpec& time, const TimeScheme& scheme,
                   int n, Vector& out) {
  const TimeGrid& grid = scheme.grid();
  const bool mean = time.sampling == LoadSampling::average && !grid.is_static();
  const auto add_sample = [&](int m, Vector& to) {
    if (mean && m > 0)
      loads.add_mean(grid.t(m - 1), grid.t(m), to);
    else
      loads.add(grid.t(m), to);
  };
  if (!scheme.looks_back() || (mean && time.scheme == Scheme::midpoint)) return add_sample(n, out);
  Vector now = Vector::Zero(out.size()), before = Vector::Zero(out.size());
  add_sample(n, now);
  add_sample(n - 1, before);
  out += scheme.present(0) * now + scheme.past(0) * before;
}

} // namespace hvi::solver
