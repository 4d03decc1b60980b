// The state of a run as bytes, bit for bit: what a checkpoint holds. Factors and Schur complements
// are functions of the coefficients they were made for, so only those are stored.
#include "solver/time/saved_state.hpp"

#include "solver/common/read_file.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/report.hpp"

#include <algorithm>
#include <stdexcept>

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
  put_vector(w, gamma());
  w.put(law_factors_);
  if (solver_) solver_->save(out);
}

void StepMatrix::restore(std::istream& in) {
  StateReader r(in, {});
  Vector saved;
  get_vector(r, saved);
  if (!saved.allFinite()) r.fail("is inconsistent");
  law_factors_ = r.get_vector<double>();
  if (!law_factors_.empty() && law_factors_.size() != 3 * contact_.terms.size())
    r.fail("is inconsistent");
  for (const double factor : law_factors_)
    if (!(factor > 0.0)) r.fail("is inconsistent");
  try {
    factor(saved);
  } catch (const std::invalid_argument&) { // other base matrices
    r.fail("is inconsistent");
  }
  if (solver_) solver_->restore(in);
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
  for (const auto& series : fields_) series.files.save(out);
  for (const auto& [u, values] : pictures_) {
    w.put(static_cast<std::uint8_t>(u.size() > 0));
    if (u.size() == 0) continue;
    put_vector(w, u);
    w.put(values);
  }
  for (const LineValues& line : lines_) line.save(w);
  w.put(static_cast<std::uint8_t>(shown_.has_value()));
  if (shown_) shown_->save(out);
}

void Reporter::restore(std::istream& in, const RunState& run) {
  StateReader r(in, {});
  values_ = r.get_vector<double>(values_.size());
  rows_ = r.get_vector<int>();
  const bool initial = std::ranges::any_of(tables_, [](const auto& t) { return t.from_start; });
  if (!rows_.empty() && (rows_.front() < (initial ? 0 : 1) || rows_.back() > run.evolution.step() ||
                         std::ranges::adjacent_find(rows_, std::greater_equal{}) != rows_.end()))
    r.fail("is inconsistent");
  times_ = r.get_vector<double>(rows_.size());
  for (auto& column : columns_) column = r.get_vector<double>(rows_.size());
  range_.restore(in);
  last_recorded_ = r.get_between(0, run.evolution.step());
  events_ = r.get_vector<int>(rows_.size());
  pending_events_ = r.get<int>();
  const auto no_count = [](int events) { return events < -1 || events > most_events; };
  if (std::ranges::any_of(events_, no_count) || no_count(pending_events_))
    r.fail("is inconsistent");
  written_.clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) written_.push_back(get_text(r));
  for (auto& series : fields_) series.files.restore(in);
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (r.get<std::uint8_t>() == 0) continue;
    get_vector(r, pictures_[i].u, space_.n_dofs());
    pictures_[i].values = r.get_vector<double>(space_.nodes.size() *
                                               plan_.report.pictures[i].field.components.size());
  }
  for (LineValues& line : lines_) line.restore(r);
  now_.take(run);
  const bool with_frames = r.get<std::uint8_t>() != 0;
  if (with_frames != shown_.has_value())
    r.fail(shown_ ? "was saved without pictures" : "was saved with pictures");
  if (shown_) shown_->restore(in, now_);
  if (keeps_before_) before_ = now_;
}

} // namespace hvi::solver
