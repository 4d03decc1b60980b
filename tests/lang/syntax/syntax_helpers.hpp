// What the tests of the syntax phase share: short ways from a text to tokens, trees and errors.
#pragma once

#include "lang/syntax/lexer.hpp"
#include "lang/syntax/parser.hpp"
#include "lang/syntax/print.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace hvi::lang {

/// "E0201 1:9-11; ...": code, line, columns of every diagnostic in order; a span over several
/// lines ends in "line:column".
inline std::string places(const Diagnostics& diagnostics, const SourceFile& source) {
  std::ostringstream out;
  for (const Diagnostic& d : diagnostics.sorted()) {
    const Position begin = source.position(d.primary.begin);
    const Position end = source.position(d.primary.end);
    out << (out.tellp() > 0 ? "; " : "") << d.code << ' ' << begin.line << ':' << begin.column
        << '-';
    if (end.line != begin.line) out << end.line << ':';
    out << end.column;
  }
  return out.str();
}

/// The errors of a script, as above.
inline std::string errors_of(const std::string& script) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", script);
  static_cast<void>(parse(source, diagnostics));
  return places(diagnostics, source);
}

/// The tree without places; with the errors instead if there are any.
inline std::string tree_of(const std::string& script) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", script);
  const ast::Program program = parse(source, diagnostics);
  return diagnostics.size() > 0 ? places(diagnostics, source) : print_ast(program);
}

/// The tree of an expression: of a parameter's value, without the line of the parameter.
inline std::string expression_tree(const std::string& text) {
  std::istringstream lines(tree_of("param p = " + text));
  std::string out, line;
  std::getline(lines, line);
  while (std::getline(lines, line)) out += line.substr(2) + "\n";
  return out;
}

/// The formatted script, or its errors.
inline std::string formatted(const std::string& script) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", script);
  const auto result = format(source, diagnostics);
  return result ? *result : places(diagnostics, source);
}

inline std::string read_file(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Every script of the repository: examples, library, tests.
inline std::vector<std::filesystem::path> repository_scripts() {
  std::vector<std::filesystem::path> result;
  const std::filesystem::path root(HVI_SOURCE_DIR);
  for (const char* folder : {"examples", "stdlib", "tests"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".hvi") result.push_back(entry.path());
  return result;
}

} // namespace hvi::lang
