// Drawing through gnuplot.
#pragma once

#include <string>

namespace hvi::lang {

/// Sends commands to gnuplot through a pipe: no text of a script reaches a shell. Throws
/// Failure(output) when gnuplot is not there or refuses.
void plot(const std::string& commands);

/// A text inside gnuplot's single quotes.
std::string quoted(std::string text);

} // namespace hvi::lang
