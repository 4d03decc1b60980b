// See svg.hpp.
#include "lang/draw/svg.hpp"

#include "lang/draw/png.hpp"
#include "solver/output/encode.hpp"
#include "solver/output/vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

namespace hvi::lang::draw {
namespace {

std::string hex(const Colour& c) {
  const auto byte = [](double x) {
    return static_cast<int>(std::lround(255.0 * std::clamp(x, 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(c.red), byte(c.green), byte(c.blue));
}

std::string svg_points(const std::vector<Spot>& line) {
  std::string out;
  for (const Spot& p : line) out += fmt::format("{:.2f},{:.2f} ", p[0], p[1]);
  return out;
}

/// What XML 1.0 knows no letters for is left out.
std::string printable(std::string text) {
  std::erase_if(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  return text;
}

struct SvgWriter {
  std::string out;

  void operator()(const Stroke& s) {
    out += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" "
                       "stroke-linejoin=\"round\" stroke-linecap=\"round\"/>\n",
                       svg_points(s.line), hex(s.colour), s.width);
  }
  void operator()(const Fill& f) {
    out +=
        fmt::format("<polygon points=\"{}\" fill=\"{}\"/>\n", svg_points(f.outline), hex(f.colour));
  }
  void operator()(const Words& w) {
    const char* const anchor = w.anchor < 0.25 ? "start" : w.anchor < 0.75 ? "middle" : "end";
    const std::string turned =
        w.upwards ? fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", w.at[0], w.at[1]) : "";
    out += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:g}\" text-anchor=\"{}\" "
                       "fill=\"{}\"{}>{}</text>\n",
                       w.at[0], w.at[1], w.size, anchor, hex(w.colour), turned,
                       solver::xml_escaped(printable(w.text)));
  }
  void operator()(const Panel& p) {
    const std::string bytes = png_bytes(p.image);
    out += fmt::format("<image x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
                       "href=\"data:image/png;base64,{}\"/>\n",
                       p.at[0], p.at[1], p.width, p.height,
                       solver::base64(std::as_bytes(std::span(bytes))));
  }
};

} // namespace

std::string svg_text(const Sheet& sheet) {
  SvgWriter writer;
  writer.out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      sheet.width, sheet.height);
  for (const Mark& mark : sheet.marks) std::visit(writer, mark);
  return writer.out + "</svg>\n";
}

} // namespace hvi::lang::draw
