// See sheet.hpp.
#include "lang/draw/sheet.hpp"

#include <algorithm>

namespace hvi::lang::draw {
namespace {

constexpr double widest_row = 1920.0; ///< three pictures of a body

/// A mark moved by so much.
struct Moved {
  Spot by;

  Spot operator()(const Spot& at) const { return {at[0] + by[0], at[1] + by[1]}; }
  std::vector<Spot> operator()(std::vector<Spot> line) const {
    for (Spot& at : line) at = (*this)(at);
    return line;
  }
  Mark operator()(Stroke s) const {
    s.line = (*this)(std::move(s.line));
    return s;
  }
  Mark operator()(Fill f) const {
    f.outline = (*this)(std::move(f.outline));
    return f;
  }
  Mark operator()(Words w) const {
    w.at = (*this)(w.at);
    return w;
  }
  Mark operator()(Panel p) const {
    p.at = (*this)(p.at);
    return p;
  }
};

} // namespace

Sheet sheets_in_rows(const std::vector<Sheet>& sheets) {
  Sheet out;
  out.width = out.height = 0.0;
  Spot corner{};
  for (const Sheet& sheet : sheets) {
    if (corner[0] > 0.0 && corner[0] + sheet.width > widest_row) corner = {0.0, out.height};
    for (const Mark& mark : sheet.marks) out.marks.push_back(std::visit(Moved{corner}, mark));
    corner[0] += sheet.width;
    out.width = std::max(out.width, corner[0]);
    out.height = std::max(out.height, corner[1] + sheet.height);
  }
  return out;
}

} // namespace hvi::lang::draw
