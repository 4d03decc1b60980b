// Numbers moved by one unit in the last place; see nudge.hpp. Called by `stability`.
#include "lang/nudge.hpp"

#include "lang/syntax/lexer.hpp"
#include "solver/discrete/rounding.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::lang {
namespace {

double moved(double value, std::uint64_t index, std::uint64_t sample) {
  return std::nextafter(value, solver::random_unit(index, sample) < 0.0 ? -HUGE_VAL : HUGE_VAL);
}

/// The numbers of statements that are data of the problem.
std::vector<Literal> candidates(const std::string& path, const std::string& text) {
  SourceMap sources;
  Diagnostics ignored;
  const SourceFile& file = sources.file(sources.add(path, text));
  std::vector<Literal> out;
  TokenKind statement = TokenKind::end, before = TokenKind::end;
  for (const Token& token : lex(file, ignored).tokens) {
    if (is_statement_word(token.kind)) statement = token.kind;
    const bool data = statement != TokenKind::param && statement != TokenKind::report &&
                      statement != TokenKind::expect && statement != TokenKind::study;
    if (data && token.kind == TokenKind::number && before != TokenKind::caret) {
      const std::string digits(file.text(token.span));
      const double value = std::strtod(digits.c_str(), nullptr);
      if (value != 0.0) out.push_back({token.span.begin, digits.size(), value});
    }
    before = token.kind;
  }
  return out;
}

bool compiles(const std::string& path, const CompileSettings& settings, const std::string& text) {
  return Session(path, settings, text).compile_variation();
}

} // namespace

std::vector<Literal> movable_literals(const std::string& path, const std::string& text,
                                      const CompileSettings& settings) {
  std::vector<Literal> out;
  for (const Literal& literal : candidates(path, text)) {
    const bool whole = literal.value == std::floor(literal.value);
    if (!whole || compiles(path, settings, moved_text(text, {literal}, 0))) out.push_back(literal);
  }
  return out;
}

std::string moved_text(const std::string& text, const std::vector<Literal>& literals,
                       std::uint64_t sample) {
  std::string out;
  std::size_t at = 0;
  for (const Literal& literal : literals) {
    out += text.substr(at, literal.begin - at);
    out += fmt::format("{:.17g}", moved(literal.value, literal.begin, sample));
    at = literal.begin + literal.length;
  }
  return out + text.substr(at);
}

void move_nodes(solver::Mesh& mesh, std::uint64_t sample) {
  std::uint64_t index = 0;
  for (auto& node : mesh.nodes)
    for (int i = 0; i < mesh.dim; ++i, ++index)
      if (node[i] != 0.0) node[i] = moved(node[i], index, sample);
}

} // namespace hvi::lang
