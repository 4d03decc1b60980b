// The accepted state of a run; see evolution.hpp. Used by the Stepper and by Balance.
#include "solver/step/evolution.hpp"

#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace hvi::solver {
namespace {

constexpr int end_of_derivatives = highest_derivative + 1;

/// Can a run that has come this far have been planned so? It may have been continued beyond its
/// plan since.
bool is_of_a_run(const MemoryExtent& extent, const TimeGrid& grid, int step) {
  if (grid.is_static()) return extent == MemoryExtent{};
  constexpr double rounding = 1e-6;
  const auto steps = static_cast<double>(extent.steps);
  double shortest = std::numeric_limits<double>::infinity(); // of the steps that were planned
  for (int n = 1; n <= std::min<std::int64_t>(step, extent.steps); ++n)
    shortest = std::min(shortest, grid.length(n) * (1.0 + 4.0 * grid.rounding(n)));
  return std::isfinite(extent.horizon) && extent.shortest_step > 0.0 && extent.steps > 0 &&
         extent.shortest_step <= (1.0 + rounding) * shortest &&
         steps * extent.shortest_step <= (1.0 + rounding) * extent.horizon;
}

} // namespace

Evolution::Evolution(const Plan& plan, Vector u0, bool imposed)
    : plan_(plan), imposed_(imposed), scheme_(make_scheme(plan.problem)), u_(std::move(u0)) {
  scheme_->start(static_cast<int>(u_.size()));
  shares_ = present_shares(*scheme_, count_fields(plan.problem));
  std::set<int> seen;
  const auto keep = [&](int field) {
    if (is_memory(field) && seen.insert(memory_of(field)).second)
      accepted_memories_.emplace_back(memory_of(field), Vector::Zero(u_.size()));
  };
  for (const auto& term : plan.problem.law_terms) {
    keep(term.field);
    for (const auto& row : term.seen)
      for (const SeenField& part : row) keep(part.field);
    for (const int field : fields_read(plan.problem.laws[static_cast<std::size_t>(term.law)]))
      keep(field);
  }
  if (scheme_->looks_back())
    for (int m = 0; m < std::ssize(plan.problem.histories); ++m) keep(field_of_memory(m));
  memory_.emplace(plan, static_cast<int>(u_.size()));
}

void Evolution::start() {
  if (!grid().is_static()) memory_->start(grid().t(0), u_);
}

void Evolution::derivative(int j, Vector& out) const {
  if (step_ > 0)
    scheme_->derivative(step_, j, out);
  else if (const Vector* velocity = scheme_->velocity(); j == 1 && velocity != nullptr)
    out = *velocity;
  else if (scheme_->needs_acceleration())
    scheme_->derivative(0, j, out);
  else
    out.setZero(u_.size());
}

const Vector& Evolution::accepted_memory(int m) const {
  return std::ranges::find(accepted_memories_, m, &std::pair<int, Vector>::first)->second;
}

void Evolution::history_field(int m, Vector& out) const {
  out = memory_->known(m) + memory_->w0(m) * u_;
}

std::int64_t Evolution::field_reads() const {
  std::int64_t sum = earlier_reads_;
  for (const auto& report : memory_->reports()) sum += report.reads;
  return sum;
}

std::optional<MemoryStop> Evolution::begin_step(int n) { return memory_->begin_step(grid().t(n)); }

LawFields Evolution::law_fields(int n, std::span<const int> others, const Vector& u,
                                const Vector* d) const {
  LawFields out(u);
  for (const int j : others) {
    if (is_memory(j)) {
      const int m = memory_of(j);
      out.add(j, memory_->w0(m), memory_->known(m) + memory_->w0(m) * u);
      continue;
    }
    Vector increment = u - u_; // imposed values move, too
    if (d != nullptr) increment.head(d->size()) = *d;
    const double factor = scheme_->factor(n, j);
    increment *= factor;
    for (const auto& [of_known, known] : scheme_->known(n, j))
      if (known != nullptr) increment += of_known * *known;
    out.add(j, factor, std::move(increment));
  }
  return out;
}

LawFields Evolution::law_fields(std::span<const int> others) const {
  LawFields out(u_);
  for (const auto& [m, value] : accepted_memories_)
    out.add(field_of_memory(m), memory_->w0(m), value);
  for (const int j : others) {
    if (is_memory(j)) continue;
    Vector value;
    derivative(j, value);
    out.add(j, scheme_->factor(std::max(step_, 1), j), std::move(value));
  }
  return out;
}

Vector Evolution::factors(int n) const {
  Vector out(field_of_memory(memory_->size()));
  out[field_of_u(0)] = 1.0;
  for (int j = 1; j < end_of_derivatives; ++j) out[j] = scheme_->factor(n, j);
  for (int m = 0; m < memory_->size(); ++m) out[field_of_memory(m)] = memory_->w0(m);
  return out;
}

Vector Evolution::in_equation(int n) const { return factors(n).cwiseProduct(shares_); }

/// add(term) for each term that the equation has of the accepted state.
template <class Add>
void Evolution::for_past(const DenseMatrix& weights, int b, const Add& add) const {
  if (!scheme_->looks_back()) return;
  const auto weight = weights.col(b);
  const double past = scheme_->past(0); // of u and of memories
  if (weight[field_of_u(0)] != 0.0) add(past * weight[field_of_u(0)] * u_);
  for (int m = 0; m < memory_->size(); ++m)
    if (const double w = weight[field_of_memory(m)]; w != 0.0) add(past * w * accepted_memory(m));
  for (int j = 1; j < end_of_derivatives; ++j) {
    const double w = scheme_->past(j) * weight[j];
    if (w == 0.0) continue;
    Vector before;
    derivative(j, before);
    add(w * before);
  }
}

bool Evolution::known_part(int n, const DenseMatrix& weights, int b, bool past, const Vector& known,
                           Vector& out) const {
  const auto weight = weights.col(b);
  const double present = scheme_->present(0); // of u and of memories
  double on_known = weight[field_of_u(0)];
  for (int m = 0; m < memory_->size(); ++m) on_known += weight[field_of_memory(m)] * memory_->w0(m);
  on_known *= present;
  bool any = on_known != 0.0;
  const auto add = [&](const auto& term) {
    if (any)
      out -= term;
    else
      out = -term;
    any = true;
  };
  if (any) out = -on_known * known;
  for (int m = 0; m < memory_->size(); ++m)
    if (const double w = weight[field_of_memory(m)]; w != 0.0) add(present * w * memory_->known(m));
  for (int j = 1; j < end_of_derivatives; ++j) {
    const double of_increment = scheme_->factor(n, j);
    if (of_increment == 0.0 || weight[j] == 0.0) continue;
    const double w = scheme_->present(j) * weight[j];
    if (imposed_) add(w * of_increment * (known - u_)); // imposed values move
    for (const auto& [factor, of] : scheme_->known(n, j))
      if (of != nullptr) add(w * factor * *of);
  }
  if (past) for_past(weights, b, add);
  return any;
}

bool Evolution::past_part(const DenseMatrix& weights, int b, Vector& out) const {
  bool any = false;
  for_past(weights, b, [&](const auto& term) {
    if (any)
      out += term;
    else
      out = term;
    any = true;
  });
  return any;
}

void Evolution::acting(const DenseMatrix& weights, int b, Vector& out, Vector& work) const {
  const auto weight = weights.col(b);
  out = weight[field_of_u(0)] * u_;
  for (int j = 1; j < end_of_derivatives; ++j) {
    if (weight[j] == 0.0 || grid().is_static()) continue;
    derivative(j, work);
    out += weight[j] * work;
  }
  for (int m = 0; m < memory_->size(); ++m)
    if (const double w = weight[field_of_memory(m)]; w != 0.0)
      out += w * (memory_->known(m) + memory_->w0(m) * u_);
}

void Evolution::accept(int n, Vector& u, Vector& d) {
  if (!grid().is_static()) memory_->commit(grid().t(n), u);
  u_.swap(u);
  for (auto& [m, value] : accepted_memories_) history_field(m, value);
  step_ = n;
  if (imposed_) u = u_ - u; // the increment with that of the imposed values
  scheme_->accept(n, imposed_ ? u : d);
}

namespace {

/// The steps taken, equal ones counted: (length, how many) after (first time, last time).
std::vector<double> steps_taken(const TimeGrid& grid, int step) {
  std::vector<double> out{grid.t(0), grid.t(step)};
  for (int n = 1; n <= step; ++n) {
    if (out.size() > 2 && out[out.size() - 2] == grid.length(n))
      out.back() += 1;
    else
      out.insert(out.end(), {grid.length(n), 1.0});
  }
  return out;
}

/// Are those the first `step` steps of the grid, up to the rounding of its times?
bool begins_with(const TimeGrid& grid, int step, const std::vector<double>& taken) {
  if (step > grid.steps() || taken.size() < 2) return false;
  if (step == 0) return true;
  const double rounding = grid.rounding(step) * grid.length(step);
  if (grid.t(0) != taken[0] || std::abs(grid.t(step) - taken[1]) > rounding) return false;
  int n = 0;
  for (std::size_t i = 3; i < taken.size(); i += 2) // pairs of a length and how many steps have it
    for (int done = 0; done < taken[i]; ++done)
      if (const double length = taken[i - 1];
          ++n > step || std::abs(grid.length(n) - length) > 2 * grid.rounding(n) * length)
        return false;
  return n == step;
}

} // namespace

void Evolution::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(step_);
  w.put(steps_taken(grid(), step_));
  w.put(memory_->extent());
  put_vector(w, u_);
  scheme_->save(w);
  memory_->save(out);
  for (const auto& [m, value] : accepted_memories_) put_vector(w, value);
  w.put(field_reads());
}

std::optional<HorizonEnd> Evolution::continue_memory(const MemoryExtent& earlier) {
  if (auto obstacle = extension_obstacle(plan_.problem, earlier); !obstacle.empty())
    return HorizonEnd{{}, std::move(obstacle), ""};
  memory_.emplace(plan_, static_cast<int>(u_.size()), earlier);
  memory_->start(grid().t(0), u_);
  return std::nullopt;
}

std::variant<bool, HorizonEnd> Evolution::restore(std::istream& in) {
  StateReader r(in, {});
  step_ = r.get<int>();
  if (!begins_with(grid(), step_, r.get_vector<double>()))
    r.fail("was saved by a run of other times");
  const auto earlier = r.get<MemoryExtent>();
  if (!is_of_a_run(earlier, grid(), step_)) r.fail("is inconsistent");
  const bool same_end = earlier == memory_->extent();
  if (!same_end) // from the initial state
    if (auto end = continue_memory(earlier)) return *std::move(end);
  get_vector(r, u_, u_.size());
  scheme_->restore(r);
  memory_->restore(in);
  for (auto& [m, value] : accepted_memories_) get_vector(r, value, u_.size());
  earlier_reads_ = r.get_between<std::int64_t>(0, std::int64_t{1} << 60);
  if (auto end = memory_->ended()) return *std::move(end);
  return same_end;
}

} // namespace hvi::solver
