#include "lang/syntax/name_parser.hpp"

namespace hvi::lang {

ast::Name NameParser::name(std::string_view what) {
  const bool reserved = is_reserved(cursor_.peek().kind) && !cursor_.at_statement();
  if (!cursor_.at(TokenKind::name) && !reserved) cursor_.fail_expected(what);
  const Token token = cursor_.take();
  const std::string written(cursor_.text(token));
  // The same word again is the same mistake.
  if (reserved && reserved_names_.insert(written).second)
    cursor_.report(diagnose("E0203", token.span, "`" + written + "` is a reserved word, not a name")
                       .with_help("choose another name, such as `" + written + "_1`"));
  return {written, token.span};
}

ast::Name NameParser::declared_name(std::string_view what) {
  ast::Name result = name(what);
  declared_.push_back(result);
  return result;
}

// Any word may follow "." or stand before the "=" of an argument.
ast::Name NameParser::member_name() {
  if (!cursor_.at(TokenKind::name) && !is_reserved(cursor_.peek().kind))
    cursor_.fail_expected("a name");
  const Token token = cursor_.take();
  return {std::string(cursor_.text(token)), token.span};
}

ast::Text NameParser::string() {
  const Token token = cursor_.expect(TokenKind::string, "a text in double quotes");
  std::string_view written = cursor_.text(token);
  if (written.starts_with('"')) written.remove_prefix(1);
  if (written.ends_with('"')) written.remove_suffix(1);
  return {std::string(written), token.span};
}

std::optional<ast::Text> NameParser::optional_string() {
  if (!cursor_.at(TokenKind::string)) return std::nullopt;
  return string();
}

} // namespace hvi::lang
