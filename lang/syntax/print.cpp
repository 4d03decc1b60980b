// Dump of tokens, see print.hpp. The tree is dumped in print_ast.cpp, the formatter is format.cpp.
#include "lang/syntax/print.hpp"

#include <fmt/format.h>

namespace hvi::lang {
namespace {

void print_line(std::string& out, const SourceFile& source, const Span& span,
                std::string_view kind) {
  const Position begin = source.position(span.begin);
  const std::string place = fmt::format("{}:{}", begin.line, begin.column);
  out += fmt::format("{:<9}{:<16}{}", place, kind, source.text(span));
  while (out.back() == ' ') out.pop_back();
  out += '\n';
}

} // namespace

std::string print_tokens(const SourceFile& source, const TokenStream& stream) {
  std::string out;
  auto comment = stream.comments.begin();
  for (const Token& token : stream.tokens) {
    for (; comment != stream.comments.end() && comment->begin < token.span.begin; ++comment)
      print_line(out, source, *comment, "comment");
    print_line(out, source, token.span, info(token.kind).name);
  }
  return out;
}

} // namespace hvi::lang
