// The lexer, see lexer.hpp. A class E01 error is a place where no token of the grammar begins;
// signs that lex but never parse (`**`, `||`, `//`) are E02, found here because here they can be
// repaired.
#include "lang/syntax/lexer.hpp"

#include "lang/diag/utf8.hpp"
#include "lang/syntax/foreign.hpp"
#include "lang/syntax/late_words.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <set>
#include <string>
#include <utility>

namespace hvi::lang {
namespace {

constexpr std::size_t max_errors = 100;

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_word(char c) { return is_letter(c) || is_digit(c) || c == '_'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// Signs of other languages that consist of signs of ours.
struct Slip {
  std::string_view wrong;
  TokenKind meant;
  std::string_view code;
  std::string_view message;
};

constexpr auto slips = std::to_array<Slip>({
    {"**", TokenKind::caret, "E0211", "a power is written `^`, not `**`"},
    {"||", TokenKind::or_, "E0212", "`or` is written as a word, not `||`"},
    {"&&", TokenKind::and_, "E0110", "`and` is written as a word, not `&&`"},
    {"=<", TokenKind::less_equal, "E0212", "less or equal is written `<=`, not `=<`"},
    {"<>", TokenKind::not_equal, "E0212", "unequal is written `!=`, not `<>`"},
});

class Lexer {
public:
  Lexer(const SourceFile& source, Diagnostics& diagnostics)
      : source_(source), diagnostics_(diagnostics), text_(source.text()) {}
  TokenStream run();

private:
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
  }
  [[nodiscard]] bool starts_with(std::string_view what) const {
    return text_.substr(at_, what.size()) == what;
  }
  [[nodiscard]] Span span_from(std::size_t begin) const { return span(begin, at_); }
  [[nodiscard]] Span span(std::size_t begin, std::size_t end) const {
    return {source_.id(), static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  }
  void emit(TokenKind kind, std::size_t begin) {
    result_.tokens.push_back({kind, first_on_line_, span_from(begin)});
    first_on_line_ = false;
  }
  void report(Diagnostic diagnostic) {
    if (n_errors_++ < max_errors) diagnostics_.add(std::move(diagnostic));
  }
  void damage() { result_.damage.push_back(static_cast<std::uint32_t>(at_)); }

  void skip_line();
  void token();
  void comment();
  bool foreign_comment();
  [[nodiscard]] bool in_unit() const;
  [[nodiscard]] bool behind_number() const;
  bool percent();
  void foreign_unit(std::size_t begin);
  bool slip();
  bool clarke();
  void word();
  void number();
  void check_number(std::size_t begin);
  void string();
  void sign();
  void report_control(const Span& place, char c);
  void unknown_ascii();
  void unknown_character();
  void typographic(const Foreign& foreign, std::uint32_t length);
  void typographic_string(std::uint32_t opening);

  const SourceFile& source_;
  Diagnostics& diagnostics_;
  std::string_view text_;
  std::size_t at_ = 0;
  bool first_on_line_ = true;
  bool lone_return_ = false; ///< reported
  std::size_t n_errors_ = 0, open_braces_ = 0;
  std::set<std::string_view> reported_words_;
  TokenStream result_;
};

TokenStream Lexer::run() {
  if (text_.size() > max_script_bytes) {
    report(diagnose("E0109", span(0, 0), "this script is larger than 4 MiB")
               .with_help("put data into CSV files and meshes into .msh files"));
    text_ = {};
  }
  result_.tokens.reserve(text_.size() / 4);
  while (at_ < text_.size()) {
    if (is_blank(peek()) && !(peek() == '\r' && peek(1) != '\n')) {
      if (text_[at_++] == '\n') first_on_line_ = true;
    } else {
      token();
    }
  }
  first_on_line_ = true;
  emit(TokenKind::end, at_);
  return std::move(result_);
}

void Lexer::token() {
  const char c = peek();
  if (c == '#') return comment();
  if (is_letter(c)) return word();
  if (is_digit(c)) return number();
  if (c == '"') return string();
  if (static_cast<unsigned char>(c) >= 0x80) return unknown_character();
  if (percent() || foreign_comment() || slip() || clarke()) return;
  sign();
}

void Lexer::skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

void Lexer::comment() {
  const std::size_t begin = at_;
  skip_line();
  std::size_t end = at_;
  while (end > begin && is_blank(text_[end - 1])) --end;
  result_.comments.push_back(span(begin, end));
  // What stands behind it on the next line, as other systems count, would be left out.
  const std::size_t lone = text_.substr(0, end).find('\r', begin);
  if (lone != std::string_view::npos && !std::exchange(lone_return_, true))
    report_control(span(lone, lone + 1), '\r');
}

// Behind `[` of a number, `5 [N/`, or of what has brackets, `(1 + 2) [`, `[0, 1] [`.
bool Lexer::in_unit() const {
  std::size_t i = result_.tokens.size();
  const auto kind = [&](std::size_t at) { return result_.tokens[at].kind; };
  while (i > 0 && kind(i - 1) != TokenKind::open_bracket) {
    const TokenKind k = kind(--i);
    const bool of_a_unit = k == TokenKind::name || k == TokenKind::number || k == TokenKind::star ||
                           k == TokenKind::slash || k == TokenKind::caret ||
                           k == TokenKind::open_paren || k == TokenKind::close_paren;
    if (!of_a_unit) return false;
  }
  if (i < 2) return false;
  const TokenKind before = kind(i - 2);
  return before == TokenKind::number || before == TokenKind::close_paren ||
         before == TokenKind::close_bracket;
}

// 5 %, where no words follow that would be a comment.
bool Lexer::behind_number() const {
  if (first_on_line_ || result_.tokens.empty()) return false;
  const std::size_t next = text_.find_first_not_of(" \t", at_ + 1);
  const bool comment = next < text_.size() && (is_word(text_[next]) || text_[next] == '%');
  return result_.tokens.back().kind == TokenKind::number && !comment;
}

// 5 % and 5 [%]. Without the unit the number would be another one: the rest of the line says no
// more.
bool Lexer::percent() {
  if (peek() != '%') return false;
  const bool unit = in_unit();
  if (!unit && !behind_number()) return false;
  const std::size_t begin = at_++;
  report(diagnose("E0110", span_from(begin), "`%` is no sign of this language")
             .with_help("percent are a unit: `5 [percent]`"));
  damage();
  if (!unit) skip_line();
  return true;
}

// Skipped like a comment, which it is in another language.
bool Lexer::foreign_comment() {
  const std::size_t begin = at_;
  const bool block = starts_with("/*");
  const bool percent = peek() == '%';
  if (!block && !percent && !starts_with("//")) return false;
  damage();
  skip_line();
  if (block) {
    const std::size_t close = text_.find("*/", begin + 2);
    at_ = close == std::string_view::npos ? at_ : close + 2;
    if (text_.substr(begin, at_ - begin).find('\n') != std::string_view::npos)
      first_on_line_ = true;
  }
  const std::size_t length = percent ? 1 : 2;
  const std::string sign(text_.substr(begin, length));
  report(diagnose(percent ? "E0110" : "E0210", span(begin, begin + length),
                  "`" + sign + "` does not begin a comment")
             .with_help("comments begin with `#` and reach to the end of the line"));
  return true;
}

bool Lexer::slip() {
  for (const Slip& slip : slips) {
    if (!starts_with(slip.wrong)) continue;
    const std::size_t begin = at_;
    at_ += slip.wrong.size();
    const std::string meant(info(slip.meant).spelling);
    report(diagnose(slip.code, span_from(begin), std::string(slip.message))
               .with_label("write `" + meant + "`"));
    emit(slip.meant, begin);
    return true;
  }
  return false;
}

// clarke-tail begins with "^0(", blanks allowed before "(". `x^0` and `x^0.5` are powers.
bool Lexer::clarke() {
  if (!starts_with("^0")) return false;
  std::size_t end = at_ + 2;
  while (end < text_.size() && is_blank(text_[end])) ++end;
  if (end >= text_.size() || text_[end] != '(') return false;
  const std::size_t begin = at_;
  at_ = end + 1;
  emit(TokenKind::clarke, begin);
  return true;
}

// name = letter { letter | digit | "_" } ;
void Lexer::word() {
  const std::size_t begin = at_;
  std::size_t foreign_at = text_.size();
  std::uint32_t foreign_length = 0;
  while (at_ < text_.size()) {
    if (is_word(peek())) {
      ++at_;
      continue;
    }
    if (static_cast<unsigned char>(peek()) < 0x80) break;
    const auto character = utf8::decode(text_, at_);
    if (!is_foreign_letter(character.code)) break;
    if (foreign_length == 0) foreign_at = at_, foreign_length = character.length;
    at_ += character.length;
  }
  const std::string_view text = text_.substr(begin, at_ - begin);
  // The same name again is the same mistake.
  if (foreign_length > 0 && in_unit()) {
    foreign_unit(begin);
  } else if (foreign_length > 0 && reported_words_.insert(text).second) {
    const Foreign* foreign = find_foreign(utf8::decode(text_, foreign_at).code);
    const std::string letter(text_.substr(foreign_at, foreign_length));
    report(diagnose("E0103", span(foreign_at, foreign_at + foreign_length),
                    "`" + letter + "` cannot be part of a name")
               .with_help(foreign != nullptr ? "write `" + std::string(foreign->instead) + "`"
                                             : "names consist of the letters a-z and A-Z, digits "
                                               "and `_`"));
  }
  emit(reserved_word(text).value_or(TokenKind::name), begin);
}

// um for \u00b5m, kOhm for k\u03a9
void Lexer::foreign_unit(std::size_t begin) {
  std::string plain;
  bool known = true;
  for (std::size_t i = begin; i < at_;) {
    const auto character = utf8::decode(text_, i);
    if (character.code < 0x80)
      plain += text_[i];
    else if (character.code == 0xB5 || character.code == 0x3BC)
      plain += 'u'; // micro, mu
    else if (character.code == 0x3A9 || character.code == 0x2126)
      plain += "Ohm";
    else
      known = false;
    i += character.length;
  }
  auto error = diagnose("E0330", span_from(begin), "units are written in the letters a-z and A-Z");
  if (known) error.help = "write `" + plain + "`";
  report(std::move(error));
}

// number = digit { digit } [ "." { digit } ] [ ( "e" | "E" ) [ "+" | "-" ] digit { digit } ] ;
void Lexer::number() {
  const std::size_t begin = at_;
  const auto digits = [this] {
    while (is_digit(peek())) ++at_;
  };
  digits();
  if (peek() == '.') ++at_, digits();
  if (peek() == 'e' || peek() == 'E') {
    const std::size_t sign = peek(1) == '+' || peek(1) == '-' ? 2 : 1;
    if (is_digit(peek(sign))) at_ += sign, digits();
  }
  check_number(begin);
  emit(TokenKind::number, begin);
}

void Lexer::check_number(std::size_t begin) {
  const std::size_t end = at_;
  const std::string written(text_.substr(begin, end - begin));
  if (is_word(peek()) || (peek() == '.' && is_digit(peek(1)))) {
    while (is_word(peek()) || (peek() == '.' && is_word(peek(1)))) ++at_;
    const std::string tail(text_.substr(end, at_ - end));
    report(diagnose("E0104", span_from(begin), "`" + written + tail + "` is not a number")
               .with_help(is_letter(tail[0]) && tail != "e" && tail != "E"
                              ? "a product is written `" + written + "*" + tail + "`"
                              : "numbers look like 2, 0.5 or 1.5e-3"));
    damage();
    return;
  }
  double value = 0;
  const auto parsed = std::from_chars(written.data(), written.data() + written.size(), value);
  if (parsed.ec == std::errc::result_out_of_range)
    report(diagnose("E0105", span(begin, end), "`" + written + "` is out of range")
               .with_help("numbers lie between about 1e-308 and 1e308"));
}

// string = '"' { any character but '"' and newline } '"' ;
void Lexer::string() {
  const std::size_t begin = at_++;
  while (at_ < text_.size() && peek() != '"' && peek() != '\n') ++at_;
  if (peek() == '"') {
    ++at_;
  } else {
    while (is_blank(text_[at_ - 1])) --at_;
    report(diagnose("E0106", span_from(begin), "this text has no closing quote")
               .with_help("texts end on the line on which they begin"));
    damage();
  }
  emit(TokenKind::string, begin);
}

void Lexer::sign() {
  // Longest match: two characters before one.
  for (const std::size_t length : {std::size_t{2}, std::size_t{1}}) {
    const std::string_view candidate = text_.substr(at_, length);
    for (const TokenInfo& entry : token_table()) {
      if (!entry.spelling.starts_with(candidate.front()) || entry.spelling != candidate) continue;
      const std::size_t begin = at_;
      at_ += candidate.size(); // at the end of the text less than was asked for
      return emit(entry.kind, begin);
    }
  }
  unknown_ascii();
}

void Lexer::report_control(const Span& place, char c) {
  std::array<char, 8> hex{};
  std::snprintf(hex.data(), hex.size(), "0x%02X", static_cast<unsigned>(c));
  auto error = diagnose("E0107", place,
                        "a control character (" + std::string(hex.data()) + ") in the script");
  if (c == '\r') error.help = "lines end with a line feed: save the script with such line ends";
  report(std::move(error));
}

void Lexer::unknown_ascii() {
  const std::size_t begin = at_;
  const char c = text_[at_++];
  if (c < 0x20 || c == 0x7F) {
    while (at_ < text_.size() && peek() == c) ++at_;
    report_control(span_from(begin), c);
    return damage();
  }
  const std::string sign(1, c);
  if (c == '!' || c == '&') {
    const TokenKind meant = c == '!' ? TokenKind::not_ : TokenKind::and_;
    const std::string word(info(meant).spelling);
    report(diagnose("E0110", span_from(begin),
                    "`" + word + "` is written as a word, not `" + sign + "`")
               .with_label("write `" + word + "`"));
    return emit(meant, begin);
  }
  // Braces come in pairs: one mistake.
  if (c == '{') ++open_braces_;
  if (c == '}' && open_braces_ > 0) {
    --open_braces_;
    return damage();
  }
  auto error = diagnose("E0101", span_from(begin), "`" + sign + "` has no meaning here");
  if (c == '{' || c == '}') error.help = "group with ( ), list with [ ]";
  if (c == '_') error.help = "names begin with a letter";
  if (c == '_')
    while (is_word(peek())) ++at_;
  report(std::move(error));
  damage();
}

void Lexer::unknown_character() {
  const auto character = utf8::decode(text_, at_);
  if (is_foreign_letter(character.code)) return word();
  const std::size_t begin = at_;
  if (!character.valid) {
    while (at_ < text_.size() && !utf8::decode(text_, at_).valid) ++at_;
    report(diagnose("E0108", span_from(begin), "these bytes are not UTF-8")
               .with_help("save the script as UTF-8"));
    return damage();
  }
  if (const Foreign* foreign = find_foreign(character.code))
    return typographic(*foreign, character.length);
  at_ += character.length;
  std::array<char, 16> number{}; // some cannot be seen
  std::snprintf(number.data(), number.size(), " (U+%04X)", static_cast<unsigned>(character.code));
  auto error = diagnose("E0101", span_from(begin),
                        "`" + std::string(text_.substr(begin, character.length)) + "`" +
                            number.data() + " has no meaning here");
  if (character.code == 0xB0) error.help = "angles are written `30 [deg]`, temperatures in `K`";
  report(std::move(error));
  damage();
}

// A sign that has an ASCII twin: reported, then read as the twin.
void Lexer::typographic(const Foreign& foreign, std::uint32_t length) {
  const std::size_t begin = at_;
  const bool blank = foreign.instead == " ";
  report(diagnose("E0102", span(begin, begin + length),
                  "this is " + std::string(foreign.name) + ", not a plain " +
                      (blank ? "space" : "`" + std::string(foreign.instead) + "`"))
             .with_help(blank ? "replace it by a plain space"
                              : "write `" + std::string(foreign.instead) + "`"));
  if (foreign.instead == "\"") return typographic_string(length);
  at_ += length;
  if (blank) return;
  for (const TokenInfo& entry : token_table())
    if (entry.spelling == foreign.instead) return emit(entry.kind, begin);
  damage();
}

// The closing quote is part of the same slip.
void Lexer::typographic_string(std::uint32_t opening) {
  const std::size_t begin = at_;
  at_ += opening;
  while (at_ < text_.size() && peek() != '\n') {
    const auto character = utf8::decode(text_, at_);
    at_ += character.length;
    const Foreign* foreign = find_foreign(character.code);
    if (character.code == U'"' || (foreign != nullptr && foreign->instead == "\"")) break;
  }
  emit(TokenKind::string, begin);
  damage();
}

} // namespace

TokenStream lex(const SourceFile& source, Diagnostics& diagnostics) {
  TokenStream out = Lexer(source, diagnostics).run();
  find_late_words(source, out.tokens);
  return out;
}

} // namespace hvi::lang
