// Drawing through gnuplot.
#pragma once

#include <filesystem>
#include <string>

namespace hvi::lang {

/// The size of a picture in pixels, and what SVG lays behind it.
struct Canvas {
  int width = 900, height = 600;
  bool white = false; ///< SVG: a white ground instead of none
};

/// Draws a picture, PNG or (by its ending) SVG, which appears whole or not at all. gnuplot runs
/// without a shell in a private folder, reads `commands` and writes a file with a name of ours
/// there: in its own `set output` a path that begins with `|` would be a command to run. Throws
/// Failure(output) when gnuplot is not there or refuses.
void plot(const std::string& commands, const std::filesystem::path& picture, Canvas canvas = {});

/// A text inside gnuplot's single quotes, which know no escapes: what could end them is left out.
std::string quoted(std::string text);

} // namespace hvi::lang
