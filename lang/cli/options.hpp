// What the command line said, and what that asks of a session.
#pragma once

#include "lang/session.hpp"

#include <map>
#include <optional>
#include <string>

namespace hvi::lang {

inline constexpr const char* version = HVI_VERSION; ///< CMakeLists.txt has it

struct Options {
  std::map<std::string, std::string> defines;
  std::string output_folder;
  std::string json;
  bool quiet = false;
  bool no_files = false;   ///< print only; a JSON that was asked for is written all the same
  bool colour = false;     ///< on stderr
  bool colour_out = false; ///< on stdout
  bool strict = false;
  bool allow_geo = false;
  bool json_diagnostics = false;
  bool script_only = false;
  bool profile = false;
  bool full = false;       ///< all unknowns at every step, also where the contact unknowns would do
  bool both_sides = false; ///< of pairs: their contact unknowns, also where jumps would do
  std::string solver;      ///< a word of `using solver`; empty: the script's
  std::string factor;      ///< a word of `using factor`; empty: the script's
  std::optional<int> threads; ///< none: the script's
  int blas_threads = 1;
  int checkpoint = 0; ///< every so many steps; 0: never
  bool resume = false;
  bool monitors = false;
  bool report = false;   ///< a page in the output folder as well
  double accuracy = 0.0; ///< wanted relative error; 0: the script's, or none
  std::string accuracy_of;
  bool as_written = false;      ///< for an accuracy: keep element, scheme and grading
  std::optional<double> budget; ///< CPU seconds a run for an accuracy may be predicted to take
};

/// The options as messages name them.
const Words& option_words();
CompileSettings compile_settings(const Options& options);
/// Prints the diagnostics to stderr (text or JSON).
void show_diagnostics(const Script& script, const Options& options);

} // namespace hvi::lang
