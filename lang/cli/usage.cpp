// See usage.hpp.
#include "lang/cli/usage.hpp"

#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <string_view>

namespace hvi::lang {
namespace {

bool is_option(std::string_view word) { return word.size() > 1 && word.front() == '-'; }

/// `--json` of `--json=a`, `-D` of `-Dn=2`.
std::string name_of_option(const std::string& word) {
  return word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> out;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  return out;
}

std::string unknown_option(const CLI::App& command, const std::string& name) {
  const std::string meant = did_you_mean(name, names_of_options(command));
  return fmt::format("`{}` has no option `{}`{}{}; hvi-run {} --help lists them",
                     command.get_name(), name, meant.empty() ? "" : ": ", meant,
                     command.get_name());
}

std::string one_word_more(const CLI::App& command, const std::string& word) {
  if (word.find('=') != std::string::npos)
    return fmt::format("`{}` is no script; parameters are set by -D name=value, without blanks",
                       word);
  return fmt::format("`{}` takes one script, and `{}` is one more word", command.get_name(), word);
}

} // namespace

std::string slip_of(const CLI::App& app, const std::vector<std::string>& words) {
  if (app.get_subcommands().empty())
    return "neither a command nor a script is named: hvi-run FILE.hvi, or hvi-run --help";
  const CLI::App& command = *app.get_subcommands().front();
  if (is_option(words.front()))
    return fmt::format("options stand behind the command: hvi-run {} ... {}", command.get_name(),
                       words.front());
  const CLI::Option* const file = command.get_option_no_throw("FILE");
  const bool one_file =
      file != nullptr && file->get_required() && file->get_items_expected_max() == 1;
  std::string more; // the first word too many
  int files = 0;
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    if (!is_option(words[i])) {
      if (++files == 2) more = words[i];
      continue;
    }
    const std::string name = name_of_option(words[i]);
    const CLI::Option* const option = command.get_option_no_throw(name);
    if (option == nullptr) return unknown_option(command, name);
    if (option->get_items_expected_min() > 0 && words[i] == name) ++i; // its value
  }
  return one_file && files > 1 ? one_word_more(command, more) : std::string();
}

} // namespace hvi::lang
