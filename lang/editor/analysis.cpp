// See analysis.hpp.
#include "lang/editor/analysis.hpp"

#include <algorithm>

namespace hvi::lang {

namespace {

CompileSettings told(CompileSettings settings,
                     std::map<std::pair<int, std::uint32_t>, NameFacts>& facts) {
  settings.on_name = [&facts](const NameFacts& f) { facts[{f.name.file, f.name.begin}] = f; };
  return settings;
}

std::string without_sign(std::string_view comment) {
  comment.remove_prefix(std::min(comment.find_first_not_of("# \t"), comment.size()));
  while (comment.ends_with('\r') || comment.ends_with(' ')) comment.remove_suffix(1);
  return std::string(comment);
}

} // namespace

Analysis::Analysis(const std::string& path, CompileSettings settings, std::string text)
    : session(path, told(std::move(settings), facts), std::move(text)) {
  session.attempt([&] { session.compile(); });
  tokens = tokens_of(script().sources);
  names = index_names(script(), tokens);
}

const NameFacts* Analysis::facts_of(const Definition& definition) const {
  const auto found = facts.find({definition.span.file, definition.span.begin});
  return found == facts.end() ? nullptr : &found->second;
}

std::string comment_of(const Analysis& analysis, const Definition& definition) {
  const auto id = definition.statement.file;
  const SourceFile& file = analysis.script().sources.file(id);
  const auto& comments = analysis.tokens[static_cast<std::size_t>(id)].comments;
  int line = file.position(definition.statement.begin).line - 1;
  std::string out;
  for (auto comment = comments.rbegin(); comment != comments.rend(); ++comment) {
    const Position at = file.position(comment->begin);
    if (at.line > line) continue;
    if (at.line < line || file.line(line).find_first_not_of(" \t") + 1 != std::size_t(at.column))
      break;
    out = without_sign(file.text(*comment)) + (out.empty() ? "" : "\n") + out;
    --line;
  }
  if (definition.kind != NameKind::parameter) return out;
  for (const ast::Statement& statement : analysis.script().programs[std::size_t(id)].statements)
    if (const auto* param = std::get_if<ast::Param>(&statement))
      if (param->name.span == definition.span && param->doc) return param->doc->text;
  return out;
}

std::size_t token_at(const Analysis& analysis, std::uint32_t offset) {
  const auto& all = analysis.tokens[0].tokens;
  const auto found = std::ranges::find_if(all, [&](const Token& t) { return t.span.end > offset; });
  return static_cast<std::size_t>(std::min(found, all.end() - 1) - all.begin());
}

std::optional<OpenCall> call_at(const Analysis& analysis, std::uint32_t offset) {
  using enum TokenKind;
  const auto statement = statement_at(analysis.tokens[0], offset);
  const Token* const first = analysis.tokens[0].tokens.data();
  std::vector<std::optional<OpenCall>> open; // nothing: a bracket that is no call's
  for (std::size_t i = 0; i < statement.size() && statement[i].span.begin < offset; ++i) {
    const TokenKind kind = statement[i].kind;
    const bool opens = kind == open_paren || kind == open_bracket || kind == clarke;
    if (opens && statement[i].span.end > offset) break;
    if (opens) {
      const bool call = kind == open_paren && i > 0 && statement[i - 1].kind == name;
      open.emplace_back();
      if (call)
        open.back() = OpenCall{analysis.text(statement[i - 1].span),
                               static_cast<std::size_t>(&statement[i] - first),
                               0,
                               {}};
    } else if ((kind == close_paren || kind == close_bracket) && !open.empty()) {
      if (statement[i].span.end > offset) break;
      open.pop_back();
    } else if (!open.empty() && open.back()) {
      if (kind == comma) ++open.back()->argument, open.back()->named.reset();
      if (kind == equal && statement[i - 1].kind == name)
        open.back()->named = analysis.text(statement[i - 1].span);
    }
  }
  while (!open.empty() && !open.back()) open.pop_back();
  return open.empty() ? std::nullopt : open.back();
}

} // namespace hvi::lang
