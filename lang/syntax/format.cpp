// The formatter behind `hvi-run fmt`, see print.hpp. It lays out the tokens of the source anew and
// never invents or drops one, so that meaning and comments cannot be lost; the syntax tree only
// says where lines break (layout.cpp).
#include "lang/syntax/layout.hpp"
#include "lang/syntax/lexer.hpp"
#include "lang/syntax/lines.hpp"
#include "lang/syntax/parser.hpp"
#include "lang/syntax/print.hpp"

#include <algorithm>

namespace hvi::lang {
namespace {

class Formatter {
public:
  Formatter(const SourceFile& source, const TokenStream& stream, const Layout& layout)
      : source_(source), stream_(stream), layout_(layout) {}
  std::string run();

private:
  void comments_before(const Token& token);
  void comment(const Span& span, const Token& next);
  void token(std::size_t index);
  void begin_line(std::uint32_t at, std::size_t indent);
  [[nodiscard]] std::size_t blanks(const Token& left, const Token& right) const;
  [[nodiscard]] bool behind_sign(std::size_t index) const;
  [[nodiscard]] bool spaced_in_source(const Token& sign) const;
  [[nodiscard]] std::size_t n_newlines(std::uint32_t begin, std::uint32_t end) const;

  const SourceFile& source_;
  const TokenStream& stream_;
  const Layout& layout_;
  std::vector<Line> lines_;
  std::size_t next_comment_ = 0;
  std::uint32_t last_end_ = 0; // of the last token or comment
  bool comment_ends_line_ = true;
  std::size_t base_indent_ = 0; // of the line that the layout began last
};

std::size_t Formatter::n_newlines(std::uint32_t begin, std::uint32_t end) const {
  const std::string_view text = source_.text({source_.id(), begin, end});
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

void Formatter::begin_line(std::uint32_t at, std::size_t indent) {
  Line& line = lines_.emplace_back();
  line.indent = indent;
  line.blank_before = n_newlines(last_end_, at) > 1;
}

void Formatter::comments_before(const Token& token) {
  const auto& comments = stream_.comments;
  while (next_comment_ < comments.size() && comments[next_comment_].begin < token.span.begin)
    comment(comments[next_comment_++], token);
}

void Formatter::comment(const Span& span, const Token& next) {
  const bool trailing =
      !lines_.empty() && !comment_ends_line_ && n_newlines(last_end_, span.begin) == 0;
  if (!trailing) {
    const auto planned = layout_.breaks.find(next.span.begin);
    const bool outside = next.kind == TokenKind::end;
    const std::size_t inside_indent = base_indent_ + continuation_indent;
    begin_line(span.begin, planned != layout_.breaks.end() ? planned->second
                           : outside                       ? 0
                                                           : inside_indent);
  }
  lines_.back().comment = source_.text(span);
  last_end_ = span.end;
  comment_ends_line_ = true;
}

// `*` and `/` keep the author's blanks, which show what belongs together.
bool Formatter::spaced_in_source(const Token& sign) const {
  const auto is_blank = [&](std::uint32_t at) {
    const std::string_view c = source_.text({source_.id(), at, at + 1});
    return c == " " || c == "\t" || c == "\n" || c == "\r";
  };
  return is_blank(sign.span.begin - 1) && is_blank(sign.span.end);
}

std::size_t Formatter::blanks(const Token& left, const Token& right) const {
  using enum TokenKind;
  if (layout_.set_apart.contains(right.span.begin)) return 2;
  if (layout_.glued_left.contains(right.span.begin)) return 0;
  if (layout_.glued_right.contains(left.span.begin)) return 0;
  if (left.kind == number && right.kind == dot) return 1; // `2 .x` has two tokens, `2.x` is none
  if (left.kind == open_paren || left.kind == open_bracket || left.kind == clarke) return 0;
  switch (right.kind) {
  case close_paren:
  case close_bracket:
  case comma:
  case semicolon:
  case dot:
  case prime:
  case caret:
  case clarke:
    return 0;
  case star:
  case slash:
    return spaced_in_source(right) ? 1 : 0;
  default:
    break;
  }
  if (left.kind == dot || left.kind == caret) return 0;
  if (left.kind == star || left.kind == slash) return spaced_in_source(left) ? 1 : 0;
  return 1;
}

// Behind the minus of a power, `m^-1` and `m^(-1/2)` also in units, which the tree keeps as texts.
bool Formatter::behind_sign(std::size_t index) const {
  if (index < 2 || stream_.tokens[index - 1].kind != TokenKind::minus) return false;
  const TokenKind before = stream_.tokens[index - 2].kind;
  return before == TokenKind::caret || before == TokenKind::open_paren;
}

void Formatter::token(std::size_t index) {
  const Token& token = stream_.tokens[index];
  const auto planned = layout_.breaks.find(token.span.begin);
  if (planned != layout_.breaks.end()) {
    base_indent_ = planned->second;
    begin_line(token.span.begin, base_indent_);
    lines_.back().begins_statement = is_statement_word(token.kind) && base_indent_ == 0;
  } else if (comment_ends_line_) {
    begin_line(token.span.begin, base_indent_ + continuation_indent);
  }
  comment_ends_line_ = false;
  Piece& piece = lines_.back().pieces.emplace_back();
  piece.text = token.kind == TokenKind::clarke ? "^0(" : source_.text(token.span);
  if (index > 0 && !behind_sign(index)) piece.blanks = blanks(stream_.tokens[index - 1], token);
  const auto group = layout_.groups.find(token.span.begin);
  if (group != layout_.groups.end()) piece.group = group->second;
  const auto soft = layout_.soft_breaks.find(token.span.begin);
  if (soft != layout_.soft_breaks.end()) piece.soft_break = soft->second;
  last_end_ = token.span.end;
}

std::string Formatter::run() {
  for (std::size_t i = 0; i < stream_.tokens.size(); ++i) {
    comments_before(stream_.tokens[i]);
    if (stream_.tokens[i].kind != TokenKind::end) token(i);
  }
  int n_groups = group_definitions(lines_, layout_.n_groups);
  align_groups(lines_, n_groups);
  n_groups = group_documents(lines_, n_groups);
  align_groups(lines_, n_groups);
  return join(wrap(std::move(lines_)));
}

} // namespace

std::optional<std::string> format(const SourceFile& source, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.n_errors();
  const ast::Program program = parse(source, diagnostics);
  if (diagnostics.n_errors() > errors_before) return std::nullopt;
  Diagnostics already_reported;
  const TokenStream stream = lex(source, already_reported);
  return Formatter(source, stream, lay_out(program)).run();
}

} // namespace hvi::lang
