#include "lang/cli/study_outputs.hpp"

#include "lang/cli/commands.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <sys/utsname.h>

#include <cstdio>
#include <fstream>
#include <thread>

namespace hvi::lang {

std::string machine_line() {
  utsname name{};
  uname(&name);
  std::ifstream cpu("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(cpu, line);)
    if (line.starts_with("model name")) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} threads, {} {}, one thread used; hvi-run {}, g++ {}, Eigen {}.{}.{}",
                     model, std::thread::hardware_concurrency(), name.sysname, name.release,
                     version, __VERSION__, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                     EIGEN_MINOR_VERSION);
}

int report_study(const std::string& path, const Study& study, const std::string& folder,
                 const Options& options) {
  int code = exit_ok;
  std::vector<std::string> files;
  const auto attempt = [&](const auto& write) {
    try {
      write();
    } catch (const solver::Failure& failure) {
      const Ending ending = ending_of(failure.kind);
      tell("error[{}]: {}\n", ending.code, failure.what());
      code = ending.exit;
    }
  };
  attempt([&] {
    files = solver::write_csv(folder, "study.csv", study_csv(study), study_columns(study));
  });
  attempt([&] {
    if (!options.json.empty()) write_json(options, study_json(study));
  });
  if (options.report)
    attempt([&] {
      Session session(path, compile_settings(options));
      session.compile();
      ReportParts parts{session.script};
      parts.study = study_json(study);
      write_page(folder, "study", parts);
      files.push_back(fmt::format("study{}", report_ending));
    });
  if (!json_only(options)) say("{}", study_table(study));
  std::fflush(stdout);
  for (const Drawn& picture : draw_study(study, folder)) {
    if (!picture.failure)
      files.push_back(picture.file);
    else
      tell("warning[W0601]: {}\n", picture.failure->what());
  }
  if (!options.quiet && !json_only(options))
    say("files: {} in {}/\n", solver::joined(files), folder);
  return code;
}

} // namespace hvi::lang
