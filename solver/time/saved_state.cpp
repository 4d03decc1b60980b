// The state of a run as bytes, bit for bit: what a checkpoint holds. Factors and Schur complements
// are functions of the coefficients they were made for, so only those are stored.
#include "solver/time/saved_state.hpp"

#include "solver/common/read_file.hpp"
#include "solver/history/horizon.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/report.hpp"
#include "solver/time/step.hpp"

#include <algorithm>

namespace hvi::solver {

void put_vector(StateWriter& w, const Vector& v) {
  w.put(std::vector<double>(v.data(), v.data() + v.size()));
}

void get_vector(StateReader& r, Vector& v) {
  const auto values = r.get_vector<double>();
  v = Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void put_text(StateWriter& w, const std::string& text) {
  w.put(std::vector<char>(text.begin(), text.end()));
}

void get_vector(StateReader& r, Vector& v, Eigen::Index size) {
  get_vector(r, v);
  if (v.size() != size || !v.allFinite()) r.fail("is inconsistent");
}

std::string get_text(StateReader& r) {
  const auto letters = r.get_vector<char>();
  return {letters.begin(), letters.end()};
}

void Memory::save(std::ostream& out) const {
  StateWriter w(out);
  for (const auto& history : histories_) history->save(out);
  w.put(w0_);
  for (const auto& known : known_) put_vector(w, known);
}

void Memory::restore(std::istream& in) {
  StateReader r(in, {});
  for (auto& history : histories_) history->restore(in);
  w0_ = r.get_vector<double>(histories_.size());
  for (auto& known : known_) get_vector(r, known, known.size());
}

void StepMatrix::save(std::ostream& out) const {
  StateWriter w(out);
  put_vector(w, gamma_);
  if (solver_) solver_->save(out);
}

void StepMatrix::restore(std::istream& in) {
  StateReader r(in, {});
  Vector gamma;
  get_vector(r, gamma, operators_.n_bases());
  factor(gamma);
  if (solver_) solver_->restore(in);
}

namespace {

/// No run keeps more factors at a time.
constexpr std::uint64_t most_matrices = 1000;

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
    for (double left = taken[i], length = taken[i - 1]; left > 0; --left)
      if (++n > step || std::abs(grid.length(n) - length) > 2 * grid.rounding(n) * length)
        return false;
  return n == step;
}

/// The pieces that contact points are on must be pieces of their laws.
void check_states(const Contact& contact, const std::vector<int>& states, const StateReader& r) {
  const auto& points = contact.problem.points;
  bool good = states.empty() || states.size() == points.size();
  for (std::size_t p = 0; good && p < states.size(); ++p)
    good = states[p] >= -1 && states[p] / 2 < contact.problem.graphs[points[p].graph].pieces();
  if (!good) r.fail("is inconsistent");
}

} // namespace

void Stepper::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(step_);
  w.put(steps_taken(grid_, step_));
  w.put(memory_->extent());
  put_text(w, not_unique_);
  for (const Vector* v :
       {&u_, &d_previous_, &d_before_, &inequality_.c, &inequality_.xi, &left_over_.force})
    put_vector(w, *v);
  w.put(inequality_.state);
  memory_->save(out);
  w.put(field_reads());
  w.put(std::array<int, 4>{products_, corrections_, newton_, fallbacks_});
  w.put(static_cast<std::uint64_t>(matrices_.size()));
  for (const auto& cached : matrices_) {
    w.put(cached.rate);
    w.put(cached.length);
    cached.matrix->save(out);
  }
  predictor_.save(out);
  put_vector(w, predicted_gamma_);
  int shortened = -1, index = 0; // which matrix has a factor in reduced precision
  for (const auto& cached : matrices_) {
    if (cached.matrix.get() == shortened_) shortened = index;
    ++index;
  }
  w.put(std::array<int, 2>{shortened, never_shortened_ ? 1 : 0});
  sweeps_.save(out);
  w.put(std::array<int, 2>{refines_ ? 1 : 0, largest_.step});
  w.put(std::array<double, 3>{last_correction_, largest_.size, left_over_.error});
  w.put(static_cast<std::uint64_t>(largest_.on_base.size()));
  for (const Vector& v : largest_.on_base) put_vector(w, v);
}

/// For a run with another end time: its histories are continued unchanged, if they can be.
void Stepper::continue_memory(const MemoryExtent& earlier) {
  if (earlier == memory_->extent()) return;
  if (const auto obstacle = extension_obstacle(plan_, earlier); !obstacle.empty())
    throw HorizonFailure(FailureKind::limit, {}, obstacle);
  memory_.emplace(plan_, layout_.n_state, earlier);
  memory_->start(grid_.t(0), u_);
}

void Stepper::restore(std::istream& in) {
  StateReader r(in, {});
  step_ = r.get<int>();
  if (!begins_with(grid_, step_, r.get_vector<double>()))
    r.fail("was saved by a run of other times");
  const auto earlier = r.get<MemoryExtent>();
  if (!(earlier.horizon >= 0.0 && std::isfinite(earlier.horizon) && earlier.shortest_step >= 0.0 &&
        std::isfinite(earlier.shortest_step) && earlier.steps >= 0))
    r.fail("is inconsistent");
  uniqueness_judged_ = earlier == memory_->extent(); // else there are other steps to judge
  continue_memory(earlier);
  not_unique_ = get_text(r);
  for (Vector* v : {&u_, &d_previous_, &d_before_}) get_vector(r, *v, layout_.n_state);
  get_vector(r, inequality_.c, inequality_.c.size());
  get_vector(r, inequality_.xi, contact_.n_rows());
  get_vector(r, left_over_.force, layout_.n_unknowns);
  inequality_.state = r.get_vector<int>();
  // Laws that move with time are prepared for the step's time before every solve.
  if (!contact_.none() && step_ > 0) prepare(contact_, plan_, grid_.t(step_), u_, inequality_.xi);
  check_states(contact_, inequality_.state, r);
  accepted_ = inequality_;
  memory_->restore(in);
  earlier_reads_ = r.get_between<std::int64_t>(0, std::int64_t{1} << 60);
  const auto counters = r.get_counts<4>();
  matrices_.clear();
  const auto count = r.get_between<std::uint64_t>(0, most_matrices);
  for (std::uint64_t i = 0; i < count; ++i) {
    const double rate = r.get<double>(), length = r.get<double>();
    const StepMatrix* like = matrices_.empty() ? nullptr : matrices_.front().matrix.get();
    matrices_.push_back(
        {rate, length, std::make_unique<StepMatrix>(operators_, contact_, options_, like)});
    matrices_.back().matrix->restore(in);
  }
  products_ = counters[0], corrections_ = counters[1];
  newton_ = counters[2], fallbacks_ = counters[3];
  predictor_.restore(in, layout_.n_unknowns, contact_.n_rows());
  get_vector(r, predicted_gamma_);
  const auto shortened = r.get<std::array<int, 2>>();
  shortened_ = nullptr;
  if (shortened[0] >= 0 && shortened[0] < static_cast<int>(matrices_.size())) {
    auto& matrix = *std::next(matrices_.begin(), shortened[0])->matrix;
    if (matrix.shorten()) shortened_ = &matrix;
  }
  never_shortened_ = shortened[1] != 0;
  sweeps_.restore(in);
  const auto rounding = r.get<std::array<int, 2>>();
  const auto sizes = r.get<std::array<double, 3>>();
  if (rounding[1] < 0 || rounding[1] > step_) r.fail("is inconsistent");
  refines_ = rounding[0] != 0, largest_.step = rounding[1];
  last_correction_ = sizes[0], largest_.size = sizes[1];
  left_over_.error = sizes[2];
  largest_.on_base.resize(
      r.get_between<std::uint64_t>(0, static_cast<std::uint64_t>(operators_.n_bases())));
  for (Vector& v : largest_.on_base) get_vector(r, v, layout_.n_state);
}

namespace {

/// "" when the file holds the bytes it was written with.
std::string what_is_wrong(const std::filesystem::path& path, std::uint64_t hash) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return "is gone";
  const auto bytes = read_file(path);
  if (!bytes) return "cannot be read";
  if (bytes->empty()) return "is empty";
  return hash_of(*bytes) == hash ? "" : "was changed since";
}

} // namespace

void FieldFiles::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(static_cast<std::uint64_t>(entries_.size()));
  for (const auto& entry : entries_) {
    w.put(entry.time);
    w.put(entry.part);
    put_text(w, entry.file);
  }
  w.put(hashes_);
}

void FieldFiles::restore(std::istream& in) {
  StateReader r(in, {});
  entries_.clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const double time = r.get<double>();
    const int part = r.get<int>();
    entries_.push_back({time, part, get_text(r)});
  }
  hashes_ = r.get_vector<std::uint64_t>();
  if (hashes_.size() != entries_.size()) r.fail("names files without their content");
  const auto beside = (folder_ / stem_).parent_path();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto path = beside / std::filesystem::path(entries_[i].file).filename();
    if (const auto wrong = what_is_wrong(path, hashes_[i]); !wrong.empty())
      r.fail("counts on the file `" + path.string() + "`, which " + wrong);
  }
  resumed_ = true;
}

/// More points than a body has; sums of two counts are still numbers.
constexpr int most_events = 1 << 30;

void Reporter::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(values_);
  w.put(rows_);
  w.put(times_);
  for (const auto& column : columns_) w.put(column);
  range_.save(out);
  w.put(last_recorded_);
  w.put(events_);
  w.put(pending_events_);
  w.put(static_cast<std::uint64_t>(written_.size()));
  for (const auto& name : written_) put_text(w, name);
  for (const auto& files : fields_) files.second.save(out);
  for (const Vector& u : pictures_) {
    w.put(static_cast<std::uint8_t>(u.size() > 0));
    if (u.size() > 0) put_vector(w, u);
  }
}

void Reporter::restore(std::istream& in, const Stepper& stepper) {
  StateReader r(in, {});
  values_ = r.get_vector<double>(values_.size());
  rows_ = r.get_vector<int>();
  if (!rows_.empty() && (rows_.front() < 1 || rows_.back() > stepper.step() ||
                         std::ranges::adjacent_find(rows_, std::greater_equal{}) != rows_.end()))
    r.fail("is inconsistent");
  times_ = r.get_vector<double>(rows_.size());
  for (auto& column : columns_) column = r.get_vector<double>(rows_.size());
  range_.restore(in);
  last_recorded_ = r.get_between(0, stepper.step());
  events_ = r.get_vector<int>(rows_.size());
  pending_events_ = r.get<int>();
  const auto no_count = [](int events) { return events < -1 || events > most_events; };
  if (std::ranges::any_of(events_, no_count) || no_count(pending_events_))
    r.fail("is inconsistent");
  written_.clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) written_.push_back(get_text(r));
  for (auto& files : fields_) files.second.restore(in);
  for (Vector& u : pictures_)
    if (r.get<std::uint8_t>() != 0) get_vector(r, u, space_.n_dofs());
  now_.take(stepper);
  if (keeps_before_) before_ = now_;
}

} // namespace hvi::solver
