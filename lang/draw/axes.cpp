// See axes.hpp.
#include "lang/draw/axes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace hvi::lang::draw {
namespace {

constexpr double number_size = 12.0, name_size = 13.0, tick_length = 5.0;

std::string with_minus(std::string text) {
  for (std::size_t at = 0; (at = text.find('-', at)) != std::string::npos; at += 3)
    text.replace(at, 1, "\u2212");
  return text;
}

std::vector<double> multiples(double step, double low, double high) {
  std::vector<double> out;
  constexpr double rounding = 1e-9;
  for (double k = std::ceil(low / step - rounding); k * step <= high + rounding * step; ++k)
    out.push_back(k == 0.0 ? 0.0 : k * step);
  return out;
}

} // namespace

std::vector<double> ticks(double low, double high, int wanted) {
  if (!(high > low) || !std::isfinite(high - low)) return {low};
  const double rough = (high - low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double digit = rough / power;
  constexpr std::array steps{10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1};
  std::size_t at = digit < 1.5 ? 3 : digit < 3.5 ? 2 : digit < 7.5 ? 1 : 0;
  std::vector<double> out = multiples(power * steps[at], low, high);
  while (out.size() < 2 && ++at < steps.size()) // one number is no scale
    out = multiples(power * steps[at], low, high);
  return out;
}

std::string number_text(double x) { return with_minus(fmt::format("{:.4g}", x)); }

std::vector<std::string> number_texts(const std::vector<double>& numbers) {
  for (int digits = 3; digits < 12; ++digits) {
    std::vector<std::string> out;
    for (const double x : numbers) out.push_back(with_minus(fmt::format("{:.{}g}", x, digits)));
    if (std::set<std::string>(out.begin(), out.end()).size() == numbers.size()) return out;
  }
  std::vector<std::string> out;
  for (const double x : numbers) out.push_back(number_text(x));
  return out;
}

void add_axes(Sheet& sheet, const Plane& plane, const std::string& x_name,
              const std::string& y_name, bool grid) {
  const double right = plane.left + plane.width, bottom = plane.top + plane.height;
  const auto xs =
      ticks(plane.x_low, plane.x_high, std::clamp(static_cast<int>(plane.width / 90), 1, 8));
  const auto ys =
      ticks(plane.y_low, plane.y_high, std::clamp(static_cast<int>(plane.height / 60), 1, 8));
  const auto x_texts = number_texts(xs), y_texts = number_texts(ys);
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const double x = plane(xs[i], plane.y_low)[0];
    if (grid) sheet.line({{x, plane.top}, {x, bottom}}, light_grey, 0.8);
    sheet.line({{x, bottom}, {x, bottom + tick_length}}, black, 0.9);
    sheet.words({{x, bottom + 19.0}, x_texts[i], number_size, 0.5});
  }
  for (std::size_t i = 0; i < ys.size(); ++i) {
    const double y = plane(plane.x_low, ys[i])[1];
    if (grid) sheet.line({{plane.left, y}, {right, y}}, light_grey, 0.8);
    sheet.line({{plane.left - tick_length, y}, {plane.left, y}}, black, 0.9);
    sheet.words({{plane.left - 9.0, y + 4.0}, y_texts[i], number_size, 1.0});
  }
  sheet.line({{plane.left, plane.top}, {plane.left, bottom}, {right, bottom}}, black, 0.9);
  if (!x_name.empty())
    sheet.words({{0.5 * (plane.left + right), bottom + 38.0}, x_name, name_size, 0.5});
  if (!y_name.empty())
    sheet.words(
        {{plane.left - 58.0, 0.5 * (plane.top + bottom)}, y_name, name_size, 0.5, black, true});
}

void add_bar(Sheet& sheet, const ColourMap& colours, double left, double top, double height,
             const std::string& name) {
  constexpr double wide = 16.0;
  constexpr int rows = 256;
  const double low = colours.low(), high = colours.high();
  Panel panel{{left, top}, wide, height, {1, rows, {}}};
  for (int row = 0; row < rows; ++row) {
    const Colour c = colours(high + (low - high) * (row + 0.5) / rows);
    for (const double part : {c.red, c.green, c.blue, 1.0})
      panel.image.rgba.push_back(static_cast<std::uint8_t>(std::lround(255.0 * part)));
  }
  sheet.marks.emplace_back(std::move(panel));
  const double right = left + wide, bottom = top + height;
  sheet.line({{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}}, black, 0.8);
  const auto values = high > low ? ticks(low, high, std::clamp(static_cast<int>(height / 55), 2, 7))
                                 : std::vector<double>{low};
  const auto texts = number_texts(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double y =
        high > low ? bottom - height * (values[i] - low) / (high - low) : 0.5 * (top + bottom);
    sheet.line({{right, y}, {right + 4.0, y}}, black, 0.8);
    sheet.words({{right + 8.0, y + 4.0}, texts[i], number_size, 0.0});
  }
  sheet.words({{left, top - 12.0}, name, name_size, 0.0});
}

} // namespace hvi::lang::draw
