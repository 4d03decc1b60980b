// See outputs.hpp.
#include "lang/cli/outputs.hpp"

#include "lang/diag/real_path.hpp"
#include "lang/report/page.hpp"
#include "solver/common/hash.hpp"
#include "solver/output/file.hpp"
#include "solver/output/table.hpp"
#include "solver/plan/result_files.hpp"
#include "solver/results/result_json.hpp"
#include "solver/time/checkpoint.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <set>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

/// A file's place: the folder as it really is, and the name in it. What is renamed to a name takes
/// the place of a link, not of what it leads to.
fs::path place_of(const fs::path& path) {
  std::error_code ignore;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return real_path(fs::absolute(folder, ignore)) / path.filename();
}

void add_mesh_files(const solver::MeshSpec& mesh, std::vector<fs::path>& out) {
  if (mesh.kind == solver::MeshSpec::Kind::file) out.emplace_back(mesh.path);
  for (const auto& piece : mesh.pieces) add_mesh_files(piece, out);
}

/// All files a script is made of.
std::vector<fs::path> inputs_of(const Script& script) {
  std::vector<fs::path> out{script.path};
  const fs::path folder = fs::path(script.path).parent_path();
  for (int f = 1; f < script.sources.n_files(); ++f)
    out.push_back(folder / script.sources.file(f).path());
  if (script.model) {
    out.insert(out.end(), script.model->files_read.begin(), script.model->files_read.end());
    add_mesh_files(script.model->mesh, out);
  }
  return out;
}

std::vector<fs::path> places_of(const std::vector<fs::path>& paths) {
  std::vector<fs::path> out;
  for (const auto& path : paths) out.push_back(place_of(path));
  return out;
}

bool is_in_one_of(const fs::path& place, const std::vector<fs::path>& series) {
  return std::ranges::any_of(series, [&](const fs::path& stem) {
    return place.parent_path() == stem.parent_path() &&
           solver::in_series(place.filename().string(), stem.filename().string());
  });
}

/// The input that one of the outputs would overwrite; empty: none.
fs::path overwritten(const Outputs& outputs, const std::vector<fs::path>& inputs) {
  const auto files = places_of(outputs.files), series = places_of(outputs.series);
  for (const fs::path& input : inputs)
    for (const fs::path& place : {place_of(input), real_path(input)})
      if (std::ranges::find(files, place) != files.end() || is_in_one_of(place, series))
        return input;
  return {};
}

/// A file that two of the outputs would be written to; empty: none.
fs::path written_twice(const Outputs& outputs) {
  const auto series = places_of(outputs.series);
  std::set<fs::path> before;
  for (const fs::path& file : outputs.files) {
    const fs::path place = place_of(file);
    if (!before.insert(place).second || is_in_one_of(place, series)) return file;
  }
  return {};
}

/// A text as a part of a file's name.
std::string as_name(const std::string& value) {
  std::string out = value;
  std::replace_if(
      out.begin(), out.end(),
      [](unsigned char c) {
        return std::isalnum(c) == 0 && c != '.' && c != '+' && c != '-' && c != '=' && c != '_';
      },
      '_');
  return out;
}

} // namespace

Outputs outputs_in(const std::string& folder, const std::vector<std::string>& names,
                   const Options& options) {
  Outputs out;
  if (!names.empty()) out.folder = folder;
  for (const std::string& name : names) out.files.push_back(fs::path(folder) / name);
  if (!options.json.empty() && !json_only(options)) out.files.emplace_back(options.json);
  return out;
}

void write_page(const std::string& folder, const std::string& title, const ReportParts& parts) {
  solver::write_atomically(fs::path(folder) / (title + report_ending), report_page(parts));
}

Outputs outputs_of_run(const Script& script, const Options& options) {
  const std::string& title = script.model->title;
  const bool units = script.model->units.used();
  std::vector<std::string> names, series;
  if (!options.no_files) {
    for (const solver::ResultFiles& result : solver::result_files(script.plan->report, title)) {
      names.push_back(result.file);
      if (result.columns && units) names.push_back(solver::metadata_file(result.file));
      series.insert(series.end(), result.series.begin(), result.series.end());
    }
    if (options.checkpoint > 0 || options.resume)
      names.push_back(solver::checkpoint_path("", title).string());
    if (options.monitors || options.report) names.push_back(title + "_monitors.csv");
    if (options.report) names.push_back(title + report_ending);
  }
  Outputs out = outputs_in(output_folder(script, options), names, options);
  for (const auto& stem : series) out.series.push_back(fs::path(out.folder) / stem);
  return out;
}

Exit HeldOutputs::take(const Outputs& outputs, const Options& options, Session& session) {
  Script& script = session.script;
  const auto refuse = [&](const char* what, std::string message, std::string help) {
    script.diagnostics.add(diagnose(what, Span{}, std::move(message)).with_help(std::move(help)));
    return exit_script;
  };
  if (outputs.files.empty() && outputs.series.empty()) return exit_ok;
  const auto last = fs::path(outputs.folder).filename();
  if (last == ".." || (last == "." && options.output_folder.empty()))
    return refuse("E0604", fmt::format("`{}` is no name for a folder of results", outputs.folder),
                  "name a folder: -o results");
  if (const auto input = overwritten(outputs, inputs_of(script)); !input.empty())
    return refuse("E0609",
                  fmt::format("a result would take the place of `{}`, which the script reads",
                              input.string()),
                  "choose another output folder (-o) or file");
  if (const auto file = written_twice(outputs); !file.empty())
    return refuse("E0609", fmt::format("two results would be written to `{}`", file.string()),
                  "give each a file of its own");
  return session.attempt([&] {
    if (!outputs.folder.empty()) lock_.emplace(outputs.folder);
    std::vector<fs::path> folders;
    for (const auto& file : outputs.files) folders.push_back(file.parent_path());
    for (const auto& stem : outputs.series) folders.push_back(stem.parent_path());
    std::ranges::sort(folders);
    folders.erase(std::unique(folders.begin(), folders.end()), folders.end());
    for (const auto& folder : folders) solver::remove_leftovers(folder);
    for (const auto& file : outputs.files) solver::try_to_write(file);
  });
}

void write_json(const Options& options, const nlohmann::ordered_json& value) {
  if (options.json.empty()) return;
  const std::string text = solver::json_text(value);
  if (json_only(options))
    std::fwrite(text.data(), 1, text.size(), stdout);
  else
    solver::write_atomically(options.json, text);
}

std::string output_folder(const std::string& path, const Options& options,
                          const std::string& ending) {
  if (!options.output_folder.empty()) return options.output_folder;
  // Results of other parameters are other results: their folder is another one.
  std::string parameters;
  for (const auto& [name, value] : options.defines) parameters += "-" + name + "=" + value;
  constexpr std::size_t longest = 100;
  if (const std::string name = as_name(parameters); name != parameters || name.size() > longest)
    parameters = fmt::format("{}-{:016x}", name.substr(0, longest), solver::hash_of(parameters));
  return fs::path(path).stem().string() + ending + parameters;
}

std::string output_folder(const Script& script, const Options& options) {
  return output_folder(script.path, options);
}

} // namespace hvi::lang
