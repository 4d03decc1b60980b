// Drawing through gnuplot (gnuplot.hpp).
#include "lang/gnuplot.hpp"

#include "solver/common/failure.hpp"

#include <cstdio>

namespace hvi::lang {

void plot(const std::string& commands) {
  using solver::Failure;
  using solver::FailureKind;
  FILE* pipe = popen("gnuplot 2>/dev/null", "w");
  if (!pipe) throw Failure(FailureKind::output, {}, "gnuplot cannot be started");
  std::fwrite(commands.data(), 1, commands.size(), pipe);
  if (pclose(pipe) != 0)
    throw Failure(FailureKind::output, {}, "gnuplot did not draw the picture",
                  "apt-get install gnuplot-nox");
}

std::string quoted(std::string text) {
  std::erase_if(text, [](char c) { return c == '\'' || c == '\n' || c == '\\'; });
  return "'" + text + "'";
}

} // namespace hvi::lang
