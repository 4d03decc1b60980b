// hvi-run new: a commented script to start from.
#include "lang/cli/commands.hpp"
#include "lang/cli/say.hpp"
#include "lang/cli/starts.hpp"
#include "lang/diag/suggest.hpp"
#include "solver/common/joined.hpp"
#include "solver/output/file.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace hvi::lang {

namespace {

/// Its first line, which is a comment.
std::string_view summary(const Module& start) {
  return start.text.substr(2, start.text.find('\n') - 2);
}

} // namespace

int new_command(const std::string& kind, const std::string& file) {
  std::vector<std::string> kinds;
  for (const Module& start : scripts_to_start_from()) kinds.emplace_back(start.name);
  if (kind.empty()) {
    for (const Module& start : scripts_to_start_from())
      say("{:<10} {}\n", start.name, summary(start));
    return exit_ok;
  }
  for (const Module& start : scripts_to_start_from()) {
    if (start.name != kind) continue;
    const std::string path = file.empty() ? kind + ".hvi" : file;
    std::error_code ignore;
    if (std::filesystem::exists(std::filesystem::symlink_status(path, ignore))) {
      tell("hvi-run: `{}` is there already; name another file: hvi-run new {} FILE\n", path, kind);
      return exit_usage;
    }
    try {
      solver::write_atomically(path, start.text);
    } catch (const solver::Failure& failure) {
      tell("error[{}]: {}\n", ending_of(failure.kind).code, failure.what());
      return ending_of(failure.kind).exit;
    }
    say("{}: {}\nhvi-run {} solves it, hvi-run mesh {} draws its mesh\n", path, summary(start),
        path, path);
    return exit_ok;
  }
  const std::string near = did_you_mean(kind, kinds);
  tell("hvi-run: there is no script of the kind `{}`{}{}; kinds: {}\n", kind,
       near.empty() ? "" : ", ", near, solver::joined(kinds));
  return exit_usage;
}

} // namespace hvi::lang
