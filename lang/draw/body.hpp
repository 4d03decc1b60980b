// A body with a field on it, as a sheet.
#pragma once

#include "lang/draw/sheet.hpp"
#include "solver/output/field_frame.hpp"

#include <limits>
#include <span>
#include <string>

namespace hvi::lang::draw {

struct BodyPicture {
  std::string title, field;     ///< the field's name in the frame
  std::string label;            ///< over the bar
  std::string unit_of_length{}; ///< " [mm]", behind the names of the axes
  double deformed = 0.0;        ///< the body is moved by this multiple of the displacement
  double widest = 690.0, highest = 470.0; ///< of the panel with the body
};

/// What several sheets have in common.
struct BodyWindow {
  double left = std::numeric_limits<double>::infinity(), right = -left, bottom = left,
         top = -left;             ///< of the plane of the view
  double least = 0.0, most = 0.0; ///< of the colours
};
/// That shows all frames whole, with the colours of all their values.
BodyWindow window_of(std::span<const solver::FieldFrame> frames, const BodyPicture& picture);

/// The body in the colours of the field, in 3D lit, with the edges that matter; in 2D with axes.
/// Values of cells are drawn cell by cell, so that the bar ends at the largest one. A field of
/// multipliers is drawn as arrows of the forces on the body. In 1D a curve.
Sheet body_sheet(const solver::FieldFrame& frame, const BodyPicture& picture,
                 const BodyWindow& window);
/// In its own window.
Sheet body_sheet(const solver::FieldFrame& frame, const BodyPicture& picture);

} // namespace hvi::lang::draw
