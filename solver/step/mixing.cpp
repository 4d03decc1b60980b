// See mixing.hpp.
#include "solver/step/mixing.hpp"

#include "solver/common/numbers.hpp"
#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr std::size_t changes_kept = 10;
constexpr int free_passes = 15;
/// Changes of the gap that depend on each other up to this say nothing new.
constexpr double dependent = 1e-10;
/// A gap that grows by so much: what was kept is of another piece of the map.
constexpr double another_piece = 10.0;
/// Passes in a row with one sign of a component's gap after which its other end is out of date.
constexpr int one_sided = 5;

} // namespace

Vector Mixing::next(const Vector& x, const Vector& image) {
  const Vector gap = image - x;
  note_bracket(x, gap);
  Vector out = mixed(image, by_size(gap, x, image));
  if (++passes_ > free_passes) stay_inside(out);
  return out;
}

Vector Mixing::by_size(const Vector& gap, const Vector& x, const Vector& image) {
  std::vector<double> now;
  for (Eigen::Index i = 0; i < gap.size(); ++i) {
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(i)]);
    if (kind >= now.size()) now.resize(kind + 1, 0.0);
    now[kind] = std::max({now[kind], std::abs(x[i]), std::abs(image[i])});
  }
  sizes_.resize(now.size(), 0.0);
  for (std::size_t kind = 0; kind < now.size(); ++kind)
    if (sizes_[kind] == 0.0) sizes_[kind] = now[kind];
  Vector out = gap;
  for (Eigen::Index i = 0; i < gap.size(); ++i) {
    const double size = sizes_[static_cast<std::size_t>(kinds_[static_cast<std::size_t>(i)])];
    if (size > 0.0) out[i] /= size;
  }
  return out;
}

void Mixing::note_bracket(const Vector& x, const Vector& gap) {
  if (low_.size() != x.size()) {
    low_ = Vector::Constant(x.size(), -infinity);
    high_ = Vector::Constant(x.size(), infinity);
    same_side_.assign(static_cast<std::size_t>(x.size()), 0);
  }
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const bool above = gap[i] > 0.0; // is the fixed point
    const int side = above ? 1 : -1;
    int& passes = same_side_[static_cast<std::size_t>(i)];
    passes = side * passes > 0 ? passes + side : side;
    (above ? low_ : high_)[i] = x[i];
    if (low_[i] < high_[i] && std::abs(passes) < one_sided) continue;
    // The other components have moved this one's fixed point.
    (above ? high_ : low_)[i] = above ? infinity : -infinity;
  }
}

void Mixing::stay_inside(Vector& x) const {
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (!(x[i] > low_[i] && x[i] < high_[i]) && std::isfinite(low_[i]) && std::isfinite(high_[i]))
      x[i] = low_[i] + (high_[i] - low_[i]) / 2.0;
}

Vector Mixing::mixed(const Vector& image, const Vector& gap) {
  if (last_gap_.size() > 0) {
    changes_of_images_.push_back(image - last_image_);
    changes_of_gaps_.push_back(gap - last_gap_);
    if (gap.norm() > another_piece * last_gap_.norm())
      changes_of_images_.clear(), changes_of_gaps_.clear();
    if (changes_of_gaps_.size() > changes_kept)
      changes_of_images_.pop_front(), changes_of_gaps_.pop_front();
  }
  last_image_ = image, last_gap_ = gap;
  if (changes_of_gaps_.empty()) return image;
  const auto n = static_cast<Eigen::Index>(changes_of_gaps_.size());
  DenseMatrix gaps(gap.size(), n), images(gap.size(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    gaps.col(k) = changes_of_gaps_[static_cast<std::size_t>(k)];
    images.col(k) = changes_of_images_[static_cast<std::size_t>(k)];
  }
  return image - images * least_squares(gaps, gap, dependent);
}

} // namespace hvi::solver
