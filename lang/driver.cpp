// Chains the phases. Each arrow of the pipeline map is one call here.
#include "lang/driver.hpp"

#include "lang/check/check.hpp"
#include "lang/diag/real_path.hpp"
#include "lang/diag/render.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/diag/unreadable.hpp"
#include "lang/lower/lower.hpp"
#include "lang/stdlib.hpp"
#include "lang/syntax/parser.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/output/folder_lock.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <set>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

void report(Script& script, std::string_view code, const Span& span, std::string message,
            std::string help = {}) {
  script.diagnostics.add(diagnose(code, span, std::move(message)).with_help(std::move(help)));
}

/// The text of an import: a module of the standard library, or a file beside the script.
std::optional<int> load_import(Script& script, const ast::Import& import,
                               std::set<std::string>& seen, bool& failed) {
  if (const auto* name = std::get_if<ast::Name>(&import.module)) {
    std::vector<std::string> known;
    for (const Module& module : standard_library()) {
      known.emplace_back(module.name);
      if (module.name != name->text) continue;
      const std::string path = fmt::format("stdlib/{}.hvi", name->text);
      if (!seen.insert(path).second) return std::nullopt;
      return script.sources.add(path, std::string(module.text));
    }
    const std::string near = did_you_mean(name->text, known);
    failed = true;
    report(script, "E0318", name->span, fmt::format("there is no module `{}`", name->text),
           near.empty() ? fmt::format("modules: {}", fmt::join(known, ", ")) : near);
    return std::nullopt;
  }
  const auto& text = std::get<ast::Text>(import.module);
  failed = true; // until it is read
  if (script.diagnostics.has_error_in(text.span)) return std::nullopt;
  const fs::path folder = real_path(fs::path(script.path).parent_path() / ".");
  const fs::path full = real_path(folder / text.text);
  const fs::path relative = full.lexically_relative(folder);
  if (fs::path(text.text).is_absolute() || relative.empty() || *relative.begin() == "..") {
    report(script, "E0604", text.span,
           fmt::format("`{}` lies outside the folder of the script", text.text),
           "a script reads files beside it or below it only");
    return std::nullopt;
  }
  if (!seen.insert(full.string()).second) {
    failed = false;
    return std::nullopt;
  }
  auto content = read_text(full.string());
  if (!content) {
    report(script, "E0601", text.span, why_unreadable(full.string(), text.text));
    return std::nullopt;
  }
  failed = false;
  return script.sources.add(text.text, std::move(*content));
}

} // namespace

void parse_script(Script& script) {
  auto text = script.text ? script.text : read_text(script.path);
  if (!text) {
    report(script, "E0601", Span{}, why_unreadable(script.path, script.path));
    return;
  }
  std::set<std::string> seen;
  seen.insert(real_path(script.path).string());
  const int id = script.sources.add(script.path, std::move(*text));
  script.programs.push_back(parse(script.sources.file(id), script.diagnostics));
  for (std::size_t p = 0; p < script.programs.size(); ++p) {
    std::vector<int> files;
    for (const ast::Statement& statement : script.programs[p].statements)
      if (const auto* import = std::get_if<ast::Import>(&statement))
        if (auto file = load_import(script, *import, seen, script.programs[p].names_lost))
          files.push_back(*file);
    for (int file : files) {
      script.programs.push_back(parse(script.sources.file(file), script.diagnostics));
      script.programs.back().library = script.sources.file(file).path().starts_with("stdlib/");
    }
  }
}

bool compile_script(Script& script, const Options& options) {
  parse_script(script);
  if (script.programs.empty()) return false;
  CheckOptions check_options;
  check_options.defines = options.defines;
  check_options.folder = (fs::path(script.path).parent_path() / ".").lexically_normal().string();
  check_options.allow_geo = options.allow_geo;
  script.model = check(script.programs, check_options, script.diagnostics);
  if (!script.model) return false;
  script.model->title = fs::path(script.path).stem().string();
  script.model->options.threads = options.threads;
  script.plan = lower(*script.model);
  if (options.full) script.plan->options.proportional_path = false;
  return true;
}

bool compile_variation(Script& script, const Options& options) {
  if (compile_script(script, options)) return true;
  for (const Diagnostic& diagnostic : script.diagnostics.items())
    if (diagnostic.code == "E0601")
      throw solver::Failure(solver::FailureKind::missing_file, {}, diagnostic.message);
  return false;
}

int exit_code(const solver::Failure& failure) {
  using K = solver::FailureKind;
  // The script may be right on another machine.
  if (dynamic_cast<const solver::TooLarge*>(&failure) != nullptr) return exit_solve;
  switch (failure.kind) {
  case K::missing_file:
  case K::broken_file:
  case K::unknown_group:
  case K::empty_region:
  case K::overlapping_regions:
  case K::bad_mesh:
  case K::bad_value:
  case K::not_coercive:
  case K::not_elliptic:
  case K::bad_law:
  case K::bad_kernel:
  case K::limit:
    return exit_script;
  case K::not_certified:
  case K::output:
    return exit_solve;
  case K::interrupted:
    return exit_interrupted;
  }
  return exit_bug;
}

void add_failure(Script& script, const solver::Failure& failure) {
  using K = solver::FailureKind;
  const char* code = "E0901";
  switch (failure.kind) {
  case K::missing_file:
    code = "E0601";
    break;
  case K::broken_file:
    code = "E0603";
    break;
  case K::unknown_group:
    code = "E0602";
    break;
  case K::empty_region:
    code = "E0418";
    break;
  case K::overlapping_regions:
    code = "E0419";
    break;
  case K::bad_mesh:
    code = "E0603";
    break;
  case K::bad_value:
    code = "E0423";
    break;
  case K::not_coercive:
    code = "E0425";
    break;
  case K::not_elliptic:
    code = "E0504";
    break;
  case K::bad_law:
    code = "E0501";
    break;
  case K::bad_kernel:
    code = "E0502";
    break;
  case K::not_certified:
    code = dynamic_cast<const solver::TooInaccurate*>(&failure) != nullptr ? "E0706" : "E0701";
    break;
  case K::limit:
    code = "E0607";
    break;
  case K::output:
    code = dynamic_cast<const solver::FolderBusy*>(&failure) != nullptr ? "E0608" : "E0702";
    break;
  case K::interrupted:
    code = "E0703";
    break;
  }
  Span span;
  if (script.model && failure.origin.id >= 0 &&
      failure.origin.id < static_cast<int>(script.model->origins.size()))
    span = script.model->origins[failure.origin.id];
  report(script, code, span, failure.what(), failure.help);
}

solver::ResultContext json_context(const Script& script) {
  solver::ResultContext context;
  for (const ModelParam& p : script.model->params)
    if (const auto* v = std::get_if<double>(&p.value)) context.params[p.name] = *v;
  context.line_of = [&](solver::Origin origin) { return line_of(script, origin); };
  return context;
}

int line_of(const Script& script, solver::Origin origin) {
  if (!script.model || origin.id < 0 || origin.id >= static_cast<int>(script.model->origins.size()))
    return 0;
  const Span span = script.model->origins[origin.id];
  return span.valid() && span.file == 0 ? script.sources.begin(span).line : 0;
}

void show_diagnostics(const Script& script, const Options& options) {
  if (script.diagnostics.size() == 0) return;
  RenderOptions render_options;
  render_options.colour = options.colour;
  const std::string text = options.json_diagnostics
                               ? render_json(script.diagnostics, script.sources)
                               : render(script.diagnostics, script.sources, render_options);
  std::fputs(text.c_str(), stderr);
}

} // namespace hvi::lang
