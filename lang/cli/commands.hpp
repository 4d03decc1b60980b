// The commands. Each is a session (lang/session.hpp) with what it prints, and returns an exit code.
#pragma once

#include "lang/cli/options.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

int run_command(const std::string& path, const Options& options);
int check_command(const std::vector<std::string>& paths, const Options& options);
int plan_command(const std::string& path, const Options& options);
int study_command(const std::string& path, const Options& options);
/// How far a model can be trusted: margins, certificates, energies, sensitivity.
int stability_command(const std::string& path, const Options& options);
int test_command(const std::vector<std::string>& paths, const Options& options);
int format_command(const std::vector<std::string>& paths, bool only_check);
int dump_command(const std::string& path, const std::string& phase, const Options& options);
/// One diagnostic; all of them, as Markdown, when no code is given.
int explain_command(const std::string& code);
int params_command(const std::string& path, const Options& options);
/// Answers an editor over the standard streams until it says that it ends.
int serve_editor_command();
/// A commented script to start from, written to `file` (empty: KIND.hvi), which is not there yet;
/// without a kind, what there is.
int new_command(const std::string& kind, const std::string& file);
/// Describes a mesh file; of a script, its parts too, and draws them.
int mesh_command(const std::string& path, const Options& options);

} // namespace hvi::lang
