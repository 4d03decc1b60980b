// See paint.hpp: loads libhvi_draw.so, which draws with libcairo.
#include "lang/draw/paint.hpp"

#include "lang/draw/cairo/bridge.h"
#include "lang/draw/png.hpp"
#include "lang/draw/svg.hpp"
#include "solver/common/failure.hpp"
#include "solver/common/open_module.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/output/file.hpp"

#include <cmath>
#include <cstdlib>
#include <memory>

namespace hvi::lang::draw {
namespace {

constexpr solver::ModuleFile draw_module{
    "libhvi_draw.so", "HVI_DRAW_MODULE", "draws PNG pictures",
    "it needs the package libcairo2; SVG pictures are drawn without it"};

/// Throws Failure(output): the results that are there are not lost for a picture.
const HviCanvasFunctions& functions() {
  try {
    return *solver::module_function<HviCanvasEntry>(draw_module, "hvi_canvas_functions")();
  } catch (const solver::Failure& failure) {
    throw solver::Failure(solver::FailureKind::output, {}, failure.what(), failure.help);
  }
}

struct Painter {
  const HviCanvasFunctions& on;
  HviCanvas* canvas;

  static std::array<double, 3> rgb(const Colour& c) { return {c.red, c.green, c.blue}; }
  void operator()(const Stroke& s) const {
    const auto n = static_cast<int>(s.line.size());
    if (n > 0) on.stroke(canvas, s.line[0].data(), n, rgb(s.colour).data(), s.width);
  }
  void operator()(const Fill& f) const {
    const auto n = static_cast<int>(f.outline.size());
    if (n > 0) on.fill(canvas, f.outline[0].data(), n, rgb(f.colour).data());
  }
  void operator()(const Words& w) const {
    on.words(canvas, w.at[0], w.at[1], w.text.c_str(), w.size, w.anchor, rgb(w.colour).data(),
             w.upwards ? 1 : 0);
  }
  void operator()(const Panel& p) const {
    on.panel(canvas, p.at[0], p.at[1], p.width, p.height, p.image.width, p.image.height,
             p.image.rgba.data());
  }
};

int whole(double x) { return static_cast<int>(std::ceil(x)); }

} // namespace

Image painted(const Sheet& sheet, double scale) {
  const HviCanvasFunctions& on = functions();
  const int width = whole(sheet.width), height = whole(sheet.height);
  const std::unique_ptr<HviCanvas, void (*)(HviCanvas*)> canvas(on.open(width, height, scale),
                                                                on.close);
  for (const Mark& mark : sheet.marks) std::visit(Painter{on, canvas.get()}, mark);
  Image out;
  out.width = static_cast<int>(std::lround(width * scale));
  out.height = static_cast<int>(std::lround(height * scale));
  out.rgba.resize(4 * static_cast<std::size_t>(out.width) * out.height);
  if (on.pixels(canvas.get(), out.rgba.data()) != 0)
    throw solver::OutOfMemory("no memory to draw a picture");
  return out;
}

void write_sheet(const Sheet& sheet, const std::filesystem::path& file) {
  const std::string bytes =
      file.extension() == ".svg" ? svg_text(sheet) : png_bytes(painted(sheet));
  solver::write_atomically(file, bytes);
}

void write_sheets(std::size_t count, const std::function<Sheet(std::size_t)>& sheet,
                  int milliseconds, const std::filesystem::path& file) {
  const auto image = [&](std::size_t i) { return painted(sheet(i), 1.0); };
  solver::write_atomically(file, apng_bytes(count, image, milliseconds));
}

} // namespace hvi::lang::draw
