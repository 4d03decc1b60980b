// What others ask a stepper for between steps; see step.hpp.
#include "solver/time/step.hpp"

namespace hvi::solver {

SymmetricBlocks Stepper::from_bases(const FormTerm& form) const {
  if (halves_.empty() || layout_.interior) return {};
  const auto factors = as_combination(operators_, discretisation_, form);
  return factors ? SymmetricBlocks::sum(halves_, *factors) : SymmetricBlocks();
}

Vector Stepper::coefficients(int n) const {
  Vector by_field = Vector::Zero(operators_.n_fields());
  by_field[field_u] = 1.0;
  if (!grid_.is_static()) by_field[field_rate] = grid_.rate(n);
  for (int m = 0; m < memory_->size(); ++m) by_field[first_history_field + m] = memory_->w0(m);
  return operators_.weights.transpose() * by_field;
}

void Stepper::rate(Vector& out) const {
  if (step_ == 0 || grid_.is_static()) {
    out.setZero(layout_.n_state);
    return;
  }
  out = grid_.rate(step_) * d_previous_;
  if (grid_.carry(step_) != 0.0) out -= grid_.carry(step_) * d_before_;
}

void Stepper::history_field(int m, Vector& out) const {
  out = memory_->known(m) + memory_->w0(m) * u_;
}

std::int64_t Stepper::field_reads() const {
  std::int64_t sum = earlier_reads_;
  for (const auto& report : memory_->reports()) sum += report.reads;
  return sum;
}

void Stepper::account(WorkCounters& work, Timing& timing) const {
  work.matrices = operators_.n_bases();
  work.products = products_;
  work.newton = newton_;
  work.fallback_steps = fallbacks_;
  work.followed_steps = followed_;
  work.inner_steps = inner_steps_;
  work.unfollowed_steps = unfollowed_;
  work.field_reads = field_reads();
  for (const auto& report : memory_->reports()) {
    work.history_fields += static_cast<int>(report.fields);
    work.bytes += report.bytes;
  }
  const auto charge = [&](const FactorStatistics& factor) {
    work.analyses += factor.analyses;
    work.factorisations += factor.factorisations;
    work.sweeps += factor.sweeps;
    work.bytes += factor.bytes;
    timing.ordering += factor.seconds_analyse;
    timing.factor += factor.seconds_factor;
    timing.swept_bytes += factor.bytes_swept;
  };
  if (layout_.interior) charge(layout_.interior->statistics());
  for (const auto& base : operators_.bases)
    work.bytes += static_cast<double>(base.nonZeros()) * (sizeof(double) + sizeof(int));
  for (const auto& half : halves_) work.bytes += half.bytes();
  for (const auto& cached : matrices_) {
    work.bytes += cached.matrix->bytes();
    const auto statistics = cached.matrix->statistics();
    charge(statistics);
    timing.inequality += cached.matrix->seconds_inequality;
    timing.sweeps += cached.matrix->seconds_sweeps;
  }
}

} // namespace hvi::solver
