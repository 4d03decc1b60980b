// What a command writes: checked before the work begins, so that no work is lost.
#pragma once

#include "lang/cli/options.hpp"
#include "lang/report/page.hpp"
#include "solver/output/folder_lock.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// The files a command will write.
struct Outputs {
  std::string folder;                        ///< empty: nothing goes into a folder
  std::vector<std::filesystem::path> files;  ///< in the folder and elsewhere (JSON)
  std::vector<std::filesystem::path> series; ///< stems of NAME_00001.vtu, NAME_00001.pvtu, ...
};

/// Of a run: tables, fields, pictures, checkpoint, monitors, JSON.
Outputs outputs_of_run(const Script& script, const Options& options);
/// Files in a folder, and the JSON that was asked for.
Outputs outputs_in(const std::string& folder, const std::vector<std::string>& names,
                   const Options& options);

/// A page into the output folder. Throws Failure(output).
void write_page(const std::string& folder, const std::string& title, const ReportParts& parts);

/// Holds the output folder while a command works in it.
class HeldOutputs {
public:
  /// A diagnostic and its exit code where an output would take the place of a file the script reads
  /// (E0609), another run writes into the folder (E0608), or something cannot be written (E0702).
  /// What killed runs left there is removed.
  Exit take(const Outputs& outputs, const Options& options, Session& session);

private:
  std::optional<solver::FolderLock> lock_;
};

/// "-": JSON goes to the standard output, and nothing else does.
inline bool json_only(const Options& options) { return options.json == "-"; }
/// Into the file that was asked for, or to the standard output. Throws Failure(output).
void write_json(const Options& options, const nlohmann::ordered_json& value);

/// The folder results go to: -o, or one named after the script and the parameters given.
std::string output_folder(const std::string& path, const Options& options,
                          const std::string& ending = "");
std::string output_folder(const Script& script, const Options& options);

} // namespace hvi::lang
