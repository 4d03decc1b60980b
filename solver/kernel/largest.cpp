// Branch and bound with interval enclosures (largest.hpp).
#include "solver/kernel/largest.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/numbers.hpp"
#include "solver/kernel/interval_rules.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace hvi::solver {

namespace {

double width(const Bounds& b) { return b.high - b.low; }

/// Where a range is cut: in the middle, or (over decades) in the middle of its logarithms.
double cut(const Bounds& b, bool over_decades) {
  if (!over_decades) return b.low + width(b) / 2.0;
  if (b.low < 0.0 && b.high > 0.0) return 0.0;
  const double a = std::abs(b.low), c = std::abs(b.high);
  const double small = std::min(a, c), large = std::max(a, c), sign = b.high > 0.0 ? 1.0 : -1.0;
  if (small == 0.0) return sign * large / 256.0;
  if (large > 4.0 * small) return sign * std::sqrt(small) * std::sqrt(large);
  return b.low + width(b) / 2.0;
}

bool divisible(const Bounds& b, bool over_decades) {
  const double m = cut(b, over_decades);
  return b.low < m && m < b.high && std::max(std::abs(b.low), std::abs(b.high)) > 1e-200;
}

struct Candidate {
  double above; ///< f does not exceed this on the box
  SearchBox box;
  int next = -1; ///< the variable to cut; -1: none is divisible
  bool operator<(const Candidate& other) const { return above < other.above; }
};

} // namespace

class SearchRun {
public:
  SearchRun(const LargestSearch& search, const SearchSpace& space, const SearchEffort& effort)
      : search_(search), space_(space), effort_(effort), n_(search.variables_.size()) {
    const auto& v = search.variables_;
    for (const Slot s : search.tape_.inputs()) {
      const auto at = std::find(v.begin(), v.end(), s) - v.begin();
      place_.push_back(at < static_cast<std::ptrdiff_t>(n_) ? at : -1);
      inputs_.push_back(place_.back() < 0 ? space.fixed(s) : Bounds{});
    }
    found_.value = {effort.seen, infinity};
  }

  LargestValue run() {
    for (const SearchBox& box : space_.boxes) consider(box);
    while (!queue_.empty() && found_.evaluations < effort_.evaluations) {
      const Candidate top = queue_.top();
      if (top.above <= enough()) break;
      queue_.pop();
      if (top.next < 0) {
        settled_ = std::max(settled_, top.above);
        continue;
      }
      SearchBox half = top.box;
      Bounds& range = half[static_cast<std::size_t>(top.next)];
      const double middle = cut(range, over_decades(static_cast<std::size_t>(top.next)));
      const double high = range.high;
      range.high = middle;
      consider(half);
      range.low = middle, range.high = high;
      consider(half);
    }
    double above = std::max(settled_, found_.value.low);
    if (!queue_.empty()) above = std::max(above, queue_.top().above);
    found_.value.high = above;
    return found_;
  }

private:
  bool over_decades(std::size_t i) const { return space_.over_decades && i == 0; }
  double enough() const {
    const double low = found_.value.low;
    return std::isfinite(low) ? low + effort_.digits * std::abs(low) + effort_.noise : low;
  }

  bool enclose(const SearchBox& box, std::span<Bounds> out) {
    ++found_.evaluations;
    for (std::size_t i = 0; i < place_.size(); ++i)
      if (place_[i] >= 0) inputs_[i] = box[static_cast<std::size_t>(place_[i])];
    return search_.tape_(inputs_, out, work_);
  }

  /// f at a point of the box: its lower bound there counts as seen.
  Bounds look(const SearchPoint& p) {
    SearchBox at;
    for (std::size_t i = 0; i < n_; ++i) at[i] = {p[i], p[i]};
    Bounds f;
    enclose(at, {&f, 1});
    return f;
  }
  void see(SearchPoint p) {
    if (space_.pull) space_.pull(p);
    const Bounds f = look(p);
    if (f.defined && f.known && f.low > found_.value.low) {
      found_.value.low = f.low;
      found_.at = p;
    }
  }

  void consider(SearchBox box) {
    if (space_.meets && !space_.meets(box)) return;
    std::array<Bounds, 7> out;
    const std::size_t n_out = search_.has_slopes_ ? n_ + 1 : 1;
    bool continuous = enclose(box, {out.data(), n_out});
    double above = bound(out[0]);
    bool smooth = continuous && search_.has_slopes_ && has_slopes(out);
    if (smooth && fix_monotone(box, out)) {
      continuous = enclose(box, {out.data(), n_out});
      above = std::min(above, bound(out[0]));
      smooth = continuous && has_slopes(out);
    }
    if (dropped(above)) return;
    SearchPoint centre{};
    for (std::size_t i = 0; i < n_; ++i) centre[i] = middle_of(box[i]);
    if (smooth) above = std::min(above, by_mean_value(box, out, centre));
    see(centre);
    if (dropped(above)) return;
    queue_.push({above, box, variable_to_cut(box, out, smooth)});
  }

  /// Is a box with this bound of no interest? The bound counts nevertheless.
  bool dropped(double above) {
    if (!(found_.value.low > -infinity) || above > enough()) return false;
    settled_ = std::max(settled_, above);
    return true;
  }
  static double bound(const Bounds& f) { return f.known ? f.high : infinity; }
  static double middle_of(const Bounds& b) { return b.low + width(b) / 2.0; }

  bool has_slopes(const std::array<Bounds, 7>& out) const {
    if (!out[0].defined) return false;
    return std::all_of(
        out.begin() + 1, out.begin() + 1 + static_cast<std::ptrdiff_t>(n_), [](const Bounds& d) {
          return d.known && d.defined && std::isfinite(d.low) && std::isfinite(d.high);
        });
  }

  /// Where f rises (falls) in a variable all over the box, its largest value is at that end. Not
  /// so where only a part of the range counts.
  bool fix_monotone(SearchBox& box, const std::array<Bounds, 7>& out) const {
    bool fixed = false;
    for (std::size_t i = 0; i < n_; ++i) {
      if (rules::is_point(box[i]) || (space_.constrained >> i & 1U) != 0) continue;
      if (out[i + 1].low >= 0.0)
        box[i].low = box[i].high, fixed = true;
      else if (out[i + 1].high <= 0.0)
        box[i].high = box[i].low, fixed = true;
    }
    return fixed;
  }

  double by_mean_value(const SearchBox& box, const std::array<Bounds, 7>& out,
                       const SearchPoint& centre) {
    Bounds sum = look(centre);
    if (!sum.known || !sum.defined) return infinity;
    for (std::size_t i = 0; i < n_; ++i) {
      const Bounds away = rules::add(box[i], {-centre[i], -centre[i]});
      sum = rules::add(sum, rules::multiply(out[i + 1], away));
    }
    return std::isnan(sum.high) ? infinity : sum.high;
  }

  /// The variable through which f may change most; without slopes the widest one.
  int variable_to_cut(const SearchBox& box, const std::array<Bounds, 7>& out, bool smooth) const {
    int best = -1;
    double most = -1.0;
    for (std::size_t i = 0; i < n_; ++i) {
      if (!divisible(box[i], over_decades(i))) continue;
      double weight = 0.0;
      if (smooth) {
        weight = std::max(std::abs(out[i + 1].low), std::abs(out[i + 1].high)) * width(box[i]);
      } else {
        const Bounds& whole = space_.boxes.front()[i];
        const double size =
            over_decades(i) ? std::max(std::abs(box[i].low), std::abs(box[i].high)) : width(whole);
        weight = size > 0.0 ? width(box[i]) / size : 0.0;
      }
      if (weight > most) most = weight, best = static_cast<int>(i);
    }
    return best;
  }

  const LargestSearch& search_;
  const SearchSpace& space_;
  const SearchEffort& effort_;
  std::size_t n_;
  std::vector<std::ptrdiff_t> place_; ///< of the tape's inputs among the variables; -1: fixed
  std::vector<Bounds> inputs_, work_;
  std::priority_queue<Candidate> queue_;
  double settled_ = -infinity; ///< bound of the boxes that are not cut further
  LargestValue found_;
};

LargestSearch::LargestSearch(const Expr& f, std::vector<Slot> variables)
    : f_(f), variables_(std::move(variables)) {
  std::vector<Expr> outputs{f};
  try {
    for (const Slot s : variables_) outputs.push_back(derivative(f, s));
  } catch (const Failure&) { // an order of a Bessel function: its enclosure has to do
    outputs.resize(1);
  }
  tape_ = IntervalTape(outputs);
  has_slopes_ = outputs.size() > 1;
}

LargestValue LargestSearch::operator()(const SearchSpace& space, const SearchEffort& effort) const {
  return SearchRun(*this, space, effort).run();
}

} // namespace hvi::solver
