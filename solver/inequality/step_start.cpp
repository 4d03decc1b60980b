// Starts and answers of a step (step_start.hpp).
#include "solver/inequality/step_start.hpp"

#include "solver/inequality/certificate.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

void note_start(const ContactPoints& points, const InequalityState& io, StepStart& out) {
  const bool told = io.xi_before.size() == points.rows;
  const Vector& xi = told ? io.xi_before : io.xi;
  out.z = io.z_before;
  if (xi.size() == points.rows)
    out.xi = xi;
  else
    out.xi.setZero(points.rows);
  out.state = told ? io.state_before : io.state;
  if (static_cast<int>(out.state.size()) == points.size()) return;
  out.state.resize(points.size());
  for (int p = 0; p < points.size(); ++p) {
    const PreparedLaw& law = points.law(p);
    const double at = io.z_before[points[p].first];
    out.state[p] = 2 * piece_of(law.graph(), law.radial() ? std::abs(at) : at);
  }
}

bool may_have_left(const ContactPoints& points, const StepStart& start,
                   const InequalityState& now) {
  bool soft = false, moved = false;
  for (int p = 0; p < points.size(); ++p) {
    const PreparedLaw& law = points.law(p);
    const int before = start.state[p], after = now.state[p];
    const int from = std::clamp(std::min(before, after) / 2, 0, law.graph().pieces() - 1),
              to = std::clamp(std::max(before, after) / 2, 0, law.graph().pieces() - 1);
    if (law.component_of_piece(from) != law.component_of_piece(to)) return true;
    for (int i = from; i <= to; ++i) {
      const int degree = law.graph().smooth[i].degree;
      soft = soft || law.softens(i);
      moved = moved || (law.softens(i) && degree != 0 && degree != 1);
    }
    moved = moved || before != after;
  }
  return soft && moved;
}

bool accept_answer(StepAnswer& step, double tolerance) {
  InequalityReport& report = step.report;
  certify(step.at, tolerance, report);
  if (!report.converged) return false;
  report.events = report.reattached = 0;
  for (int p = 0; p < step.at.points.size(); ++p) {
    const PreparedLaw& law = step.at.points.law(p);
    const int before = std::clamp(step.start.state[p] / 2, 0, law.graph().pieces() - 1);
    count_crossings(step.at, p, law.component_of_piece(before), report);
  }
  step.at.store(step.io);
  return true;
}

} // namespace hvi::solver
