// Marks on a sheet through libcairo; see bridge.h.
#include "lang/draw/cairo/bridge.h"

#include <cairo.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <vector>

struct HviCanvas {
  cairo_surface_t* surface;
  cairo_t* cairo;
};

namespace {

HviCanvas* open_canvas(int width, int height, double scale) {
  const auto pixels = [&](int n) { return static_cast<int>(std::lround(n * scale)); };
  cairo_surface_t* const surface =
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, pixels(width), pixels(height));
  cairo_t* const cairo = cairo_create(surface);
  cairo_scale(cairo, scale, scale);
  cairo_set_source_rgb(cairo, 1, 1, 1);
  cairo_paint(cairo);
  cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  return new HviCanvas{surface, cairo};
}

void colour(HviCanvas* canvas, const double* rgb) {
  cairo_set_source_rgb(canvas->cairo, rgb[0], rgb[1], rgb[2]);
}

void path(HviCanvas* canvas, const double* points, int n) {
  cairo_new_path(canvas->cairo);
  for (int i = 0; i < n; ++i) cairo_line_to(canvas->cairo, points[2 * i], points[2 * i + 1]);
}

void stroke(HviCanvas* canvas, const double* points, int n, const double* rgb, double width) {
  path(canvas, points, n);
  colour(canvas, rgb);
  cairo_set_line_width(canvas->cairo, width);
  cairo_stroke(canvas->cairo);
}

void fill(HviCanvas* canvas, const double* points, int n, const double* rgb) {
  path(canvas, points, n);
  colour(canvas, rgb);
  cairo_fill(canvas->cairo);
}

void words(HviCanvas* canvas, double x, double y, const char* utf8, double size, double anchor,
           const double* rgb, int upwards) {
  cairo_t* const cairo = canvas->cairo;
  cairo_save(cairo);
  colour(canvas, rgb);
  cairo_set_font_size(cairo, size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, utf8, &extents);
  cairo_translate(cairo, x, y);
  if (upwards != 0) cairo_rotate(cairo, -std::numbers::pi / 2.0);
  cairo_move_to(cairo, -anchor * extents.x_advance, 0.0);
  cairo_show_text(cairo, utf8);
  cairo_restore(cairo);
}

/// Cairo's pixels: 32 bits in the machine's order, premultiplied.
std::uint32_t premultiplied(const unsigned char* rgba) {
  const std::uint32_t a = rgba[3];
  const auto part = [&](int i) { return (rgba[i] * a + 127) / 255; };
  return a << 24 | part(0) << 16 | part(1) << 8 | part(2);
}

void panel(HviCanvas* canvas, double x, double y, double width, double height, int columns,
           int rows, const unsigned char* rgba) {
  const int stride = cairo_format_stride_for_width(CAIRO_FORMAT_ARGB32, columns);
  std::vector<unsigned char> bytes(static_cast<std::size_t>(stride) * rows);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const std::uint32_t pixel =
          premultiplied(rgba + 4 * (static_cast<std::size_t>(r) * columns + c));
      std::memcpy(bytes.data() + static_cast<std::size_t>(r) * stride + 4 * c, &pixel, 4);
    }
  cairo_surface_t* const image =
      cairo_image_surface_create_for_data(bytes.data(), CAIRO_FORMAT_ARGB32, columns, rows, stride);
  cairo_t* const cairo = canvas->cairo;
  cairo_save(cairo);
  cairo_translate(cairo, x, y);
  cairo_scale(cairo, width / columns, height / rows);
  cairo_set_source_surface(cairo, image, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cairo), CAIRO_FILTER_NEAREST);
  cairo_paint(cairo);
  cairo_restore(cairo);
  cairo_surface_destroy(image);
}

int pixels(HviCanvas* canvas, unsigned char* rgba) {
  if (cairo_status(canvas->cairo) == CAIRO_STATUS_NO_MEMORY ||
      cairo_surface_status(canvas->surface) != CAIRO_STATUS_SUCCESS)
    return 1;
  cairo_surface_flush(canvas->surface);
  const int columns = cairo_image_surface_get_width(canvas->surface);
  const int rows = cairo_image_surface_get_height(canvas->surface);
  const int stride = cairo_image_surface_get_stride(canvas->surface);
  const unsigned char* const data = cairo_image_surface_get_data(canvas->surface);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, data + static_cast<std::size_t>(r) * stride + 4 * c, 4);
      *rgba++ = static_cast<unsigned char>(pixel >> 16); // the ground is white: all is opaque
      *rgba++ = static_cast<unsigned char>(pixel >> 8);
      *rgba++ = static_cast<unsigned char>(pixel);
      *rgba++ = 255;
    }
  return 0;
}

void close_canvas(HviCanvas* canvas) {
  cairo_destroy(canvas->cairo);
  cairo_surface_destroy(canvas->surface);
  delete canvas;
}

} // namespace

const HviCanvasFunctions* hvi_canvas_functions(void) {
  static constexpr HviCanvasFunctions functions{open_canvas, stroke, fill,        words,
                                                panel,       pixels, close_canvas};
  return &functions;
}
