// See structure.hpp.
#include "lang/editor/structure.hpp"

#include "lang/check/builtins.hpp"
#include "lang/syntax/print.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace hvi::lang {

namespace {

enum Colour {
  keyword,
  number,
  text,
  comment,
  operation,
  parameter,
  type,
  function,
  variable,
  property
};
constexpr std::array<std::string_view, 10> colour_table{
    "keyword",   "number", "string",   "comment",  "operator",
    "parameter", "type",   "function", "variable", "property"};

Colour colour_of(NameKind kind) {
  switch (kind) {
  case NameKind::argument:
    return parameter;
  case NameKind::mesh:
  case NameKind::part:
  case NameKind::space:
    return type;
  case NameKind::kernel:
  case NameKind::superpotential:
  case NameKind::function:
    return function;
  default:
    return variable;
  }
}

/// SymbolKind of the protocol.
int symbol_of(NameKind kind) {
  switch (kind) {
  case NameKind::parameter:
    return 14; // Constant
  case NameKind::kernel:
  case NameKind::superpotential:
  case NameKind::function:
    return 12; // Function
  case NameKind::mesh:
  case NameKind::space:
    return 5; // Class
  case NameKind::part:
    return 3; // Namespace
  default:
    return 13; // Variable
  }
}

struct Painted {
  Span span;
  Colour colour;
};

/// What a name that is not declared stands for by its place and text.
std::optional<Colour> colour_of_word(const Analysis& a, std::size_t i) {
  const auto& all = a.tokens[0].tokens;
  const std::string name = a.text(all[i].span);
  if (i > 0 && all[i - 1].kind == TokenKind::dot) return property;
  if (i + 1 < all.size() && all[i + 1].kind == TokenKind::open_paren && find_built_in(name))
    return function;
  if (is_word(name) || is_reserved_builtin(name)) return variable;
  return std::nullopt;
}

std::optional<Colour> colour_of(const Analysis& a, std::size_t i) {
  const Token& token = a.tokens[0].tokens[i];
  if (is_reserved(token.kind)) return keyword;
  switch (token.kind) {
  case TokenKind::number:
    return number;
  case TokenKind::string:
    return text;
  case TokenKind::name:
    if (const NameUse* use = a.names.at(0, token.span.begin); use && use->span == token.span)
      return colour_of(a.names.definitions[use->definition].kind);
    return colour_of_word(a, i);
  default:
    return std::nullopt;
  }
}

std::vector<Painted> painted(const Analysis& a) {
  std::vector<Painted> out;
  for (std::size_t i = 0; i < a.tokens[0].tokens.size(); ++i)
    if (const auto colour = colour_of(a, i)) out.push_back({a.tokens[0].tokens[i].span, *colour});
  for (const Span& span : a.tokens[0].comments) out.push_back({span, comment});
  std::ranges::sort(out, {}, [](const Painted& p) { return p.span.begin; });
  return out;
}

} // namespace

Json outline(const EditorPlace& place) {
  Json out = Json::array();
  const Analysis& a = place.analysis;
  for (const Definition& d : a.names.definitions) {
    const bool statement = d.kind != NameKind::argument && d.kind != NameKind::column &&
                           d.kind != NameKind::test_function;
    if (d.span.file != 0 || !statement) continue;
    const NameFacts* const facts = a.facts_of(d);
    out.push_back({{"name", d.name},
                   {"detail", facts ? facts->what : std::string(word(d.kind))},
                   {"kind", symbol_of(d.kind)},
                   {"range", place.range(d.statement)},
                   {"selectionRange", place.range(d.span)}});
  }
  return out;
}

std::vector<std::string_view> colour_names() { return {colour_table.begin(), colour_table.end()}; }

Json colours(const EditorPlace& place) {
  std::vector<int> data;
  EditorPosition last;
  for (const Painted& p : painted(place.analysis)) {
    const EditorPosition at = position_of(place.analysis.source(), p.span.begin, place.unit);
    const bool same_line = at.line == last.line;
    data.insert(data.end(),
                {at.line - last.line, same_line ? at.character - last.character : at.character,
                 units_of(place.analysis.source().text(p.span), place.unit),
                 static_cast<int>(p.colour), 0});
    last = at;
  }
  return {{"data", data}};
}

Json formatted(const EditorPlace& place) {
  const SourceFile& source = place.analysis.source();
  Diagnostics told_already;
  const auto text = format(source, told_already);
  if (!text || *text == source.text()) return Json::array();
  const Span all{0, 0, static_cast<std::uint32_t>(source.text().size())};
  return {{{"range", place.range(all)}, {"newText", *text}}};
}

} // namespace hvi::lang
