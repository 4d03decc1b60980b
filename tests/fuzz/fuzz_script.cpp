// libFuzzer target for scripts: any bytes lex, parse and are checked without a crash; a script
// without syntax errors survives the formatter with the same tree, and formatting twice changes
// nothing.
#include "lang/check/check.hpp"
#include "lang/diag/render.hpp"
#include "lang/syntax/parser.hpp"
#include "lang/syntax/print.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

using namespace hvi::lang;

void require(bool holds, const char* what, const std::string& text) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n%s\n", what, text.c_str());
  std::abort();
}

void check_round_trip(const std::string& script) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", script);
  const ast::Program program = parse(source, diagnostics);
  const auto formatted = format(source, diagnostics);
  require(formatted.has_value() && !diagnostics.has_errors(), "the script has errors now", script);
  const SourceFile second(0, "script.hvi", *formatted);
  const ast::Program reread = parse(second, diagnostics);
  require(!diagnostics.has_errors(), "the formatted script has errors", *formatted);
  require(print_ast(program) == print_ast(reread), "the tree has changed", *formatted);
  const auto again = format(second, diagnostics);
  require(again == formatted, "formatting is not idempotent", *formatted + "\n---\n" + *again);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string script(data, data + size);
  SourceMap sources;
  const int id = sources.add("script.hvi", script);
  Diagnostics diagnostics;
  const ast::Program program = parse(sources.file(id), diagnostics);
  require(print_ast(program, &sources.file(id)).size() < 1U << 30U, "the dump explodes", script);
  if (!diagnostics.has_errors()) check_round_trip(script);
  // There is no such folder: a script that is read from nowhere has no files.
  CheckOptions options;
  options.folder = "/nonexistent";
  if (const auto model = check({program}, options, diagnostics))
    require(!to_string(*model).empty(), "the model has no dump", script);
  if (diagnostics.size() > 0) {
    RenderOptions few; // noise has an error in every line, and all are rendered alike
    few.limit = 4;
    require(!render(diagnostics, sources, few).empty(), "nothing is rendered", script);
    require(!render_json(diagnostics, sources).empty(), "nothing is rendered", script);
  }
  return 0;
}
