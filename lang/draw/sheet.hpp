// A drawing as data: what stands on a sheet, from back to front, in pixels from the upper left.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace hvi::lang::draw {

using Spot = std::array<double, 2>;

struct Colour {
  double red = 0.0, green = 0.0, blue = 0.0; ///< 0 to 1, sRGB
};
inline constexpr Colour black{0.0, 0.0, 0.0}, white{1.0, 1.0, 1.0}, grey{0.45, 0.45, 0.45},
    light_grey{0.86, 0.86, 0.86};

/// Pixels row by row from above, four bytes each: red, green, blue, opacity (not premultiplied).
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

struct Stroke {
  std::vector<Spot> line;
  Colour colour;
  double width = 1.0;
};
struct Fill {
  std::vector<Spot> outline;
  Colour colour;
};
struct Words {
  Spot at{}; ///< on the base line
  std::string text;
  double size = 13.0;
  double anchor = 0.0; ///< 0: `at` is where the text begins, 0.5: its middle, 1: its end
  Colour colour = black;
  bool upwards = false; ///< turned by a quarter, read from below
};
struct Panel {
  Spot at{};
  double width = 0.0, height = 0.0;
  Image image;
};

using Mark = std::variant<Stroke, Fill, Words, Panel>;

struct Sheet {
  double width = 900.0, height = 600.0;
  std::vector<Mark> marks;

  void line(std::vector<Spot> points, Colour colour, double thick = 1.0) {
    marks.emplace_back(Stroke{std::move(points), colour, thick});
  }
  void words(Words text) { marks.emplace_back(std::move(text)); }
};

/// Side by side, as many as find room, and below each other.
Sheet sheets_in_rows(const std::vector<Sheet>& sheets);

} // namespace hvi::lang::draw
