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

void Reporter::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(values_);
  tables_.save(w);
  range_.save(out);
  w.put(last_recorded_);
  w.put(static_cast<std::uint64_t>(files_.names().size()));
  for (const auto& name : files_.names()) put_text(w, name);
  for (const auto& series : fields_) series.files.save(out);
  pictures_.save(out);
}

void Reporter::restore(std::istream& in, const RunState& run) {
  StateReader r(in, {});
  values_ = r.get_vector<double>(values_.size());
  tables_.restore(r, run.evolution.step());
  range_.restore(in);
  last_recorded_ = r.get_between(0, run.evolution.step());
  files_.names().clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) files_.names().push_back(get_text(r));
  for (auto& series : fields_) series.files.restore(in);
  now_.take(run);
  pictures_.restore(in, now_);
  if (keeps_before_) before_ = now_;
}

} // namespace hvi::solver
