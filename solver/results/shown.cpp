// See shown.hpp.
#include "solver/results/shown.hpp"

#include "solver/common/stream.hpp"

#include <cstdint>
#include <numeric>

namespace hvi::solver {
namespace {

/// All arrays of a frame, one behind the other.
template <class Frame, class Use>
void for_each_array(Frame& frame, const Use& use) {
  for (auto& one : frame.grids) {
    for (auto& array : one.grid.point_data) use(array.values);
    for (auto& array : one.grid.cell_data) use(array.values);
  }
}

/// Every so many steps make at most so many frames.
int stride(const Plan& plan, int most) {
  const int steps = std::max(1, static_cast<int>(plan.problem.time.grid.size()) - 1);
  return (steps + most - 1) / most;
}

} // namespace

bool moves(const PictureSpec& picture) { return picture.file.ends_with(".apng"); }

ShownFrames::ShownFrames(const Plan& plan, const Discretisation& d, const Contact& contact,
                         Shown& out)
    : out_(out) {
  out_.pictures.clear();
  out_.frames.clear();
  out_.since = 0;
  for (const PictureSpec& picture : plan.report.pictures) {
    pictures_.push_back(FrameMaker::of_picture(plan.problem, d, contact, picture.field));
    moving_.push_back(moves(picture) ? stride(plan, most_moving_frames) : 0);
  }
  taken_.resize(pictures_.size());
  if (out_.fields.empty()) return;
  std::vector<int> laws(contact.terms.size());
  std::iota(laws.begin(), laws.end(), 0);
  kept_.emplace(plan.problem, d, contact, out_.fields, laws);
  every_ = stride(plan, out_.most_frames);
}

bool ShownFrames::keeps(int step, bool last) const {
  return due(every_, step, last) ||
         std::ranges::any_of(moving_, [&](int every) { return due(every, step, last); });
}

void ShownFrames::keep(const Snapshot& now, const RunState& run, bool last) {
  if (due(every_, now.step(), last)) out_.frames.push_back(kept_->at(now, &run));
  for (std::size_t i = 0; i < pictures_.size(); ++i)
    if (due(moving_[i], now.step(), last)) taken_[i].push_back(pictures_[i].at(now, nullptr));
}

void ShownFrames::keep_end(const Snapshot& now, const RunState& run) {
  if (kept_) out_.frames.push_back(kept_->at(now, &run));
}

std::vector<Expr> ShownFrames::expressions() const {
  std::vector<Expr> out;
  const auto add = [&](const FrameMaker& maker) {
    const auto more = maker.expressions();
    out.insert(out.end(), more.begin(), more.end());
  };
  for (const FrameMaker& maker : pictures_) add(maker);
  if (kept_) add(*kept_);
  return out;
}

void ShownFrames::finish(const Snapshot& end) {
  for (std::size_t i = 0; i < pictures_.size(); ++i)
    out_.pictures.push_back(taken_[i].empty() ? std::vector{pictures_[i].at(end, nullptr)}
                                              : taken_[i]);
}

void ShownFrames::save(std::ostream& out) const {
  StateWriter w(out);
  for (const auto& frames : taken_) {
    w.put(static_cast<std::uint64_t>(frames.size()));
    for (const FieldFrame& frame : frames) {
      w.put(frame.t);
      w.put(frame.step);
      for_each_array(frame, [&](const std::vector<double>& values) { w.put(values); });
    }
  }
}

void ShownFrames::restore(std::istream& in, const Snapshot& now) {
  StateReader r(in, {});
  out_.since = now.step();
  for (std::size_t i = 0; i < taken_.size(); ++i)
    for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
      // Its grids and arrays; then what was in them.
      FieldFrame frame = pictures_[i].at(now, nullptr);
      frame.t = r.get<double>();
      frame.step = r.get<int>();
      for_each_array(frame, [&](std::vector<double>& values) {
        values = r.get_vector<double>(values.size());
      });
      taken_[i].push_back(std::move(frame));
    }
}

} // namespace hvi::solver
