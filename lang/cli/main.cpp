// The command line, and nothing else.
#include "lang/cli/among_processes.hpp"
#include "lang/cli/commands.hpp"
#include "lang/cli/heap.hpp"
#include "lang/cli/no_memory.hpp"
#include "lang/cli/say.hpp"
#include "lang/cli/usage.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/diag/unreadable.hpp"
#include "solver/common/joined.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/blas_memory.hpp"
#include "solver/linear/blas_threads.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace {

using hvi::lang::Options;
using hvi::lang::tell;
using hvi::solver::FailureKind;

constexpr int no_memory_exit = hvi::lang::ending_of(FailureKind::too_large).exit;

/// -D name=value; of one name the last one counts, so that a command of somebody else's can be
/// added to.
bool add_define(const std::string& text, Options& options) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return false;
  options.defines[text.substr(0, equals)] = text.substr(equals + 1);
  return true;
}

std::string named(const std::string& text) { return text.empty() ? "an empty name" : ""; }

/// CLI11's own check of positive numbers lets NaN pass, and tells the largest one with 300 digits.
std::string positive(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool good = !text.empty() && *end == '\0' && value > 0.0 && std::isfinite(value);
  return good ? "" : "not a positive number: " + text;
}

bool writes_json(std::string_view command) {
  constexpr std::array none = {"fmt", "params", "dump", "test", "mesh"};
  return std::ranges::find(none, command) == none.end();
}

void add_common(CLI::App& app, std::string_view command, Options& options,
                std::vector<std::string>& defines) {
  app.add_option("-D", defines, "set a parameter: -D n=64; of one name the last one counts")
      ->allow_extra_args(false);
  app.add_option("-o", options.output_folder, "output folder (default: named after the script)")
      ->check(named);
  if (writes_json(command))
    app.add_option("--json", options.json, "write the result as JSON; `-`: to the standard output")
        ->check(named);
  else // else its value would be taken for a file of the command
    app.add_option_function<std::string>("--json",
                                         [](const std::string&) {
                                           throw CLI::ValidationError(
                                               "--json", "this command writes no JSON");
                                         })
        ->group("");
  app.add_flag("--quiet", options.quiet, "the table only");
  app.add_flag("--strict", options.strict, "refuse where the theorem does not apply");
  app.add_flag("--profile", options.profile, "where the time went");
  app.add_flag("--full", options.full,
               "solve for all unknowns at every step, also where the contact unknowns would do");
  app.add_flag("--both-sides", options.both_sides,
               "keep the contact unknowns of both sides of a pair, also where jumps would do");
  app.add_flag("--allow-geo", options.allow_geo, "read .geo files (they can run programs)");
  app.add_option("--solver", options.solver,
                 "of the linear systems: direct, iterative or automatic")
      ->check(CLI::IsMember({"direct", "iterative", "automatic"}));
  app.add_option("--factor", options.factor, "of a matrix in single or double precision")
      ->check(CLI::IsMember({"single", "double"}));
  app.add_option("--threads", options.threads, "threads of our own loops")
      ->check(CLI::Range(1, 256));
  app.add_option("--blas-threads", options.blas_threads,
                 "threads of OpenBLAS, for large factors: other last digits")
      ->check(CLI::Range(1, 256));
  app.add_flag_callback(
      "--no-color", [&] { options.colour = options.colour_out = false; }, "no colours");
  app.add_option_function<std::string>(
         "--diagnostics", [&](const std::string& s) { options.json_diagnostics = s == "json"; },
         "text or json")
      ->check(CLI::IsMember({"text", "json"}));
}

/// The first word is neither a command nor a script.
void no_command(std::string_view word, CLI::App& app) {
  std::vector<std::string> commands;
  for (const CLI::App* one : app.get_subcommands([](CLI::App*) { return true; }))
    commands.push_back(one->get_name());
  std::string meant = hvi::lang::did_you_mean(word, commands);
  if (std::error_code none; std::filesystem::is_regular_file(std::string(word) + ".hvi", none))
    meant = fmt::format("did you mean `{}.hvi`?", word);
  else if (meant.empty())
    meant = hvi::lang::meant_file("", std::string(word));
  tell("hvi-run: `{}` is neither a command nor a script (FILE.hvi){}{}\n", word,
       meant.empty() ? "" : ": ", meant);
  tell("commands: {}; --help says more\n", hvi::solver::joined(commands));
}

/// What the command line says, apart from the options of runs.
struct CommandLine {
  Options options;
  std::vector<std::string> defines, files;
  std::string code, phase, fresh_file;
  bool only_check = false, explain_all = false;
  bool over_streams = true; ///< there is no other way; editors say so all the same
};

CLI::Option* add_report(CLI::App& command, Options& options) {
  return command.add_flag("--report", options.report, "write a page to read in a browser");
}

/// Of a run, whether it writes a page or not.
void add_run(CLI::App& run, Options& options) {
  run.add_option("--checkpoint", options.checkpoint, "save the state every N steps")
      ->check(positive);
  run.add_flag("--resume", options.resume, "go on from the last checkpoint");
  run.add_option("--accuracy", options.accuracy,
                 "find the cheapest setting with this relative error")
      ->check(positive)
      ->excludes("--resume"); // what it compares are all steps
  run.add_option("--of", options.accuracy_of, "the accuracy of this column, not of u in V")
      ->check(named);
  run.add_flag("--as-written", options.as_written,
               "with --accuracy: keep element, scheme and grading, vary mesh and steps only");
  run.add_option("--budget", options.budget, "CPU seconds a run for --accuracy may take")
      ->check(positive);
  run.add_flag("--monitors", options.monitors, "energies and a-priori bounds, step by step");
}

void add_what_is_written(CLI::App& run, Options& options) {
  auto* no_files = run.add_flag("--no-files", options.no_files, "print only, write nothing")
                       ->excludes("--checkpoint", "--resume");
  no_files->excludes(add_report(run, options));
  if (auto* folder = run.get_option_no_throw("-o")) no_files->excludes(folder);
}

/// All commands; options of scripts for the one that is `given`, or for all where none is.
void add_commands(CLI::App& app, std::string_view given, CommandLine& line) {
  const auto command = [&](const char* name, const char* what, bool many = false) {
    CLI::App* sub = app.add_subcommand(name, what);
    // Options are made for the command that is given only: they are most of what a start costs.
    if (given != name && !given.starts_with("-")) return sub;
    add_common(*sub, name, line.options, line.defines);
    auto* option = sub->add_option("FILE", line.files, "script")->required();
    if (!many) option->expected(1);
    return sub;
  };
  CLI::App* const run = command("run", "solve a script");
  add_run(*run, line.options);
  add_what_is_written(*run, line.options);
  add_run(*command("report", "solve a script and write a page to read in a browser"), line.options);
  auto* check = command("check", "check scripts without solving", true);
  add_report(*check, line.options);
  auto* script_only =
      check->add_flag("--script-only", line.options.script_only, "without the mesh");
  for (const char* of_mesh : {"--json", "--strict", "--report"})
    if (auto* option = check->get_option_no_throw(of_mesh)) script_only->excludes(option);
  command("plan", "what a run would do");
  add_report(*command("study", "what accuracy costs: runs the ladders of a script"), line.options);
  add_report(*command("stability", "how far a model can be trusted"), line.options);
  command("test", "run scripts and judge their expectations", true);
  command("fmt", "format scripts in place", true)
      ->add_flag("--check", line.only_check, "only say which are not formatted");
  command("params", "list the parameters");
  command("mesh", "describe a mesh file, or draw the mesh and the parts of a script");
  auto* dump = command("dump", "print a phase");
  for (const char* name : {"tokens", "ast", "model", "units", "plan"})
    dump->add_flag_callback(
        std::string("--") + name, [&line, name] { line.phase = name; }, "this phase");
  app.add_subcommand("serve-editor", "language server: answers an editor")
      ->add_flag("--stdio", line.over_streams, "over the standard streams, as always");
  auto* fresh = app.add_subcommand("new", "write a commented script to start from");
  fresh->add_option("KIND", line.code,
                    "contact, memory, friction, ... (none: says which there are)");
  fresh->add_option("FILE", line.fresh_file, "where to (default: KIND.hvi)");
  auto* explain = app.add_subcommand("explain", "explain a diagnostic");
  explain->add_option("CODE", line.code, "E0301");
  explain->add_flag("--all", line.explain_all, "every diagnostic, as Markdown");
}

int perform(const std::string& command, const CommandLine& line) {
  const std::vector<std::string>& files = line.files;
  const Options& options = line.options;
  if (command == "run" || command == "report") return hvi::lang::run_command(files[0], options);
  if (command == "check") return hvi::lang::check_command(files, options);
  if (command == "plan") return hvi::lang::plan_command(files[0], options);
  if (command == "study") return hvi::lang::study_command(files[0], options);
  if (command == "stability") return hvi::lang::stability_command(files[0], options);
  if (command == "test") return hvi::lang::test_command(files, options);
  if (command == "fmt") return hvi::lang::format_command(files, line.only_check);
  if (command == "params") return hvi::lang::params_command(files[0], options);
  if (command == "mesh") return hvi::lang::mesh_command(files[0], options);
  if (command == "new") return hvi::lang::new_command(line.code, line.fresh_file);
  if (command == "explain") return hvi::lang::explain_command(line.code);
  if (command == "serve-editor") return hvi::lang::serve_editor_command();
  return hvi::lang::dump_command(files[0], line.phase.empty() ? "plan" : line.phase, options);
}

void tell_of_serial_blas(const Options& options) {
  if (options.blas_threads > 1 && !hvi::solver::blas_is_made_for_threads())
    tell(
        "note: OpenBLAS is its serial build here and takes one thread: libopenblas0-pthread is the "
        "one for threads\n");
}

int dispatch(int argc, char** argv) {
  CommandLine line;
  line.options.colour = isatty(STDERR_FILENO) && !std::getenv("NO_COLOR");
  line.options.colour_out = isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
  CLI::App app{"hvi-run: solves history-dependent hemivariational inequalities"};
  app.set_version_flag("--version", std::string("hvi-run ") + hvi::lang::version);
  app.require_subcommand(1);
  const std::string_view given = argc > 1 ? argv[1] : "-";
  add_commands(app, given, line);
  if (argc == 1) {
    tell("{}", app.help("hvi-run"));
    return hvi::lang::exit_usage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && !given.starts_with("-")) {
      no_command(given, app);
      return hvi::lang::exit_usage;
    }
    if (error.get_exit_code() != 0) { // --help is one, too
      const std::vector<std::string> words(argv + 1, argv + argc);
      if (const std::string slip = hvi::lang::slip_of(app, words); !slip.empty()) {
        tell("hvi-run: {}\n", slip);
        return hvi::lang::exit_usage;
      }
    }
    const int status = app.exit(error);
    return status == 0 ? hvi::lang::exit_ok : hvi::lang::exit_usage;
  }
  const std::string command = app.get_subcommands().front()->get_name();
  if (command == "explain" && line.code.empty() != line.explain_all) {
    tell("hvi-run: explain takes a code, or --all\n");
    return hvi::lang::exit_usage;
  }
  if (!line.options.json.empty() && line.files.size() > 1) {
    tell("hvi-run: --json writes the result of one script, not of {}\n", line.files.size());
    return hvi::lang::exit_usage;
  }
  for (const std::string& define : line.defines)
    if (!add_define(define, line.options)) {
      tell("hvi-run: -D takes name=value, not `{}`\n", define);
      return hvi::lang::exit_usage;
    }
  line.options.report = line.options.report || command == "report";
  tell_of_serial_blas(line.options);
  const hvi::solver::BlasThreads blas_threads(line.options.blas_threads);
  return perform(command, line);
}

/// The first word that is neither an option of a run nor a value of one; 0: there is none.
int first_word(int argc, char** argv) {
  if (argc < 2) return 0;
  if (argv[1][0] != '-') return 1; // as mostly: options cost time to make
  CommandLine line;
  CLI::App run;
  add_common(run, "run", line.options, line.defines);
  add_run(run, line.options);
  add_what_is_written(run, line.options);
  for (int i = 1; i < argc; ++i) {
    if (argv[i][0] != '-') return i;
    const auto* const option = run.get_option_no_throw(argv[i]);
    if (option != nullptr && option->get_items_expected_min() > 0) ++i;
  }
  return 0;
}

/// `hvi-run FILE ...` is `hvi-run run FILE ...`: the word is put in when the first word that is no
/// option names a script.
std::vector<char*> with_command(int argc, char** argv, std::string& word) {
  std::vector<char*> out(argv, argv + argc);
  const int first = first_word(argc, argv);
  if (first > 0 && std::string_view(argv[first]).ends_with(".hvi"))
    out.insert(out.begin() + 1, word.data());
  return out;
}

/// If a standard stream is closed, the next file to be opened gets its number, and messages would
/// be written into that file.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) < 0) return;
}

/// What was printed has to have arrived: a full disk or a closed pipe shows here at the latest.
int flushed(int code) {
  errno = 0;
  const bool arrived = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (arrived || code == hvi::lang::exit_bug) return code;
  const char* const reason = errno != 0 ? std::strerror(errno) : "it did not take all";
  const auto ending = hvi::lang::ending_of(FailureKind::output);
  for (const char* text :
       {"error[", ending.code, "]: cannot write to the standard output: ", reason, "\n"})
    std::fputs(text, stderr); // allocates nothing
  return ending.exit;
}

int ended(const hvi::lang::Ending& ending, const char* what, const std::exception& error) {
  tell("error[{}]: {}: {}\n", ending.code, what, error.what());
  return ending.exit;
}

int run_program(int argc, char** argv) {
  try {
    std::string word = "run";
    auto arguments = with_command(argc, argv, word);
    return dispatch(static_cast<int>(arguments.size()), arguments.data());
  } catch (const hvi::solver::OutOfMemory& error) {
    hvi::lang::tell_no_memory(error.what());
    return no_memory_exit;
  } catch (const std::bad_alloc&) {
    hvi::lang::tell_no_memory();
    return no_memory_exit;
  } catch (const std::system_error& error) { // no thread, no file, no process to be had
    return ended(hvi::lang::no_resources, "the system refused something", error);
  } catch (const std::exception& error) {
    return ended(hvi::lang::our_mistake, "internal error", error);
  }
}

} // namespace

int main(int argc, char** argv) {
  hvi::lang::prepare_heap();
  if (!hvi::solver::reserve_blas_memory()) {
    hvi::lang::tell_no_memory("out of memory: a run needs some 200 MiB of addresses");
    return no_memory_exit;
  }
  const hvi::solver::OneBlasThread one_thread;
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a file beyond a limit is a failed write, with a message
  std::signal(SIGPIPE, SIG_IGN); // and so is a pipe that nobody reads
  return hvi::lang::among_processes([&] { return flushed(run_program(argc, argv)); });
}
