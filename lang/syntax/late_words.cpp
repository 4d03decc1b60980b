#include "lang/syntax/late_words.hpp"

#include <string_view>

namespace hvi::lang {

namespace {

/// `state` became a statement word when scripts had it as a name: it is one before `name on` only.
void find_states(const SourceFile& source, std::vector<Token>& tokens) {
  const auto has_text = [&](const Token& token, std::string_view word) {
    return token.kind == TokenKind::name && source.text(token.span) == word;
  };
  for (std::size_t i = 0; i + 2 < tokens.size(); ++i)
    if (has_text(tokens[i], info(TokenKind::state).spelling) &&
        (tokens[i + 1].kind == TokenKind::name || is_reserved(tokens[i + 1].kind)) &&
        has_text(tokens[i + 2], "on"))
      tokens[i].kind = TokenKind::state;
}

/// `units mm, N, s` likewise: before a name that ends the statement or that another unit follows.
/// `every units steps` and `by units points` are older. From the end, as what follows tells.
void find_units(const SourceFile& source, std::vector<Token>& tokens) {
  for (std::size_t i = tokens.size() < 3 ? 0 : tokens.size() - 2; i-- > 0;) {
    const auto text = [&](std::size_t at) { return source.text(tokens[at].span); };
    const TokenKind next = tokens[i + 2].kind;
    const bool ends = next == TokenKind::end || next == TokenKind::comma ||
                      next == TokenKind::star || next == TokenKind::slash ||
                      next == TokenKind::caret || is_statement_word(next);
    if (tokens[i].kind == TokenKind::name && text(i) == info(TokenKind::units).spelling &&
        tokens[i + 1].kind == TokenKind::name && text(i + 1) != "steps" &&
        text(i + 1) != "points" && ends)
      tokens[i].kind = TokenKind::units;
  }
}

} // namespace

void find_late_words(const SourceFile& source, std::vector<Token>& tokens) {
  find_states(source, tokens);
  find_units(source, tokens);
}

} // namespace hvi::lang
