// A script and what it imports; see script.hpp.
#include "lang/script.hpp"

#include "lang/diag/real_path.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/diag/unreadable.hpp"
#include "lang/stdlib.hpp"
#include "lang/syntax/parser.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

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
    std::string near = did_you_mean(name->text, known);
    const std::string file = name->text + ".hvi";
    std::error_code problem;
    if (fs::exists(fs::path(script.path).parent_path() / file, problem))
      near = fmt::format("a file is imported by its name in quotes: `import \"{}\"`", file);
    failed = true;
    report(script, "E0318", name->span, fmt::format("there is no module `{}`", name->text),
           near.empty() ? fmt::format("modules: {}", solver::joined(known)) : near);
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
    const std::string stem = fs::path(text.text).stem().string();
    const auto modules = standard_library();
    const bool module = std::ranges::find(modules, stem, &Module::name) != modules.end();
    report(script, "E0601", text.span, why_unreadable(full.string(), text.text),
           module ? fmt::format("modules of the standard library have no quotes: `import {}`", stem)
                  : meant_file(folder.string(), text.text));
    return std::nullopt;
  }
  failed = false;
  return script.sources.add(text.text, std::move(*content));
}

} // namespace

void parse_script(Script& script) {
  auto text = script.text ? script.text : read_text(script.path);
  if (!text) {
    report(script, "E0601", Span{}, why_unreadable(script.path, script.path),
           meant_file("", script.path));
    return;
  }
  std::set<std::string> seen;
  seen.insert(real_path(script.path).string());
  const int id = script.sources.add(script.path, std::move(*text));
  script.programs.push_back(parse(script.sources.file(id), script.diagnostics));
  for (std::size_t p = 0; p < script.programs.size(); ++p) {
    std::vector<std::pair<int, bool>> files; // and whether it is of the standard library
    for (const ast::Statement& statement : script.programs[p].statements)
      if (const auto* import = std::get_if<ast::Import>(&statement))
        if (auto file = load_import(script, *import, seen, script.programs[p].names_lost))
          files.emplace_back(*file, std::holds_alternative<ast::Name>(import->module));
    for (const auto& [file, library] : files) {
      script.programs.push_back(parse(script.sources.file(file), script.diagnostics));
      script.programs.back().library = library;
    }
  }
}

Span span_of(const Script& script, solver::Origin origin) {
  if (!script.model || origin.id < 0 || origin.id >= static_cast<int>(script.model->origins.size()))
    return {};
  return script.model->origins[static_cast<std::size_t>(origin.id)];
}

int line_of(const Script& script, solver::Origin origin) {
  const Span span = span_of(script, origin);
  return span.valid() && span.file == 0 ? script.sources.begin(span).line : 0;
}

std::map<std::string, solver::UnitsByName> units_by_kind(const Script& script) {
  const ModelUnits& units = script.model->units;
  if (!units.used()) return {};
  std::map<std::string, solver::UnitsByName> out{
      {"params", {}}, {"variables", units.of}, {"columns", units.of_columns}};
  for (const ModelParam& p : script.model->params)
    if (!p.unit.empty()) out["params"][p.name] = p.unit;
  return out;
}

solver::UnitsByName units_told(const Script& script) {
  solver::UnitsByName out;
  const auto by_kind = units_by_kind(script);
  for (const char* kind : {"variables", "columns", "params"}) // what a name means most of all last
    if (const auto of_kind = by_kind.find(kind); of_kind != by_kind.end())
      for (const auto& [name, unit] : of_kind->second) out[name] = unit;
  return out;
}

solver::ResultContext json_context(const Script& script) {
  solver::ResultContext context;
  for (const ModelParam& p : script.model->params)
    if (const auto* v = std::get_if<double>(&p.value)) context.params[p.name] = p.as_declared(*v);
  context.units = units_told(script);
  context.units_by_kind = units_by_kind(script);
  context.line_of = [&](solver::Origin origin) { return line_of(script, origin); };
  return context;
}

} // namespace hvi::lang
