// A sheet as pixels, and as a file.
#pragma once

#include "lang/draw/sheet.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>

namespace hvi::lang::draw {

/// By libcairo, whose module is loaded now. Throws Failure(output) where it is not there.
Image painted(const Sheet& sheet, double scale = 2.0);

/// PNG, or SVG by the file's ending, which needs no library; appears whole or not at all.
void write_sheet(const Sheet& sheet, const std::filesystem::path& file);
/// `count` sheets of one size, one after the other, as an animated PNG.
void write_sheets(std::size_t count, const std::function<Sheet(std::size_t)>& sheet,
                  int milliseconds, const std::filesystem::path& file);

} // namespace hvi::lang::draw
