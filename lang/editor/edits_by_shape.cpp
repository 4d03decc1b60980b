// One function for each shape that a help shows; see edits.hpp.
#include "lang/editor/edits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

namespace hvi::lang {

namespace {

constexpr std::array quotes{"\u201c", "\u201d", "\u201e", "\u201f", "\u00ab",
                            "\u00bb", "\u2018", "\u2019", "\u201a", "'"};

bool opens(TokenKind kind) {
  return kind == TokenKind::open_paren || kind == TokenKind::open_bracket ||
         kind == TokenKind::clarke;
}
bool closes(TokenKind kind) {
  return kind == TokenKind::close_paren || kind == TokenKind::close_bracket;
}

/// What stands around the place of a message, by its tokens: the statement may have no tree.
class Shapes {
public:
  Shapes(const Analysis& analysis, const Diagnostic& diagnostic)
      : a_(analysis), d_(diagnostic), tokens_(analysis.tokens[0].tokens),
        at_(token_at(analysis, diagnostic.primary.begin)) {}

  std::vector<Edit> all() {
    using Shape = void (Shapes::*)();
    static constexpr std::pair<std::string_view, Shape> shapes[] = {
        {"E0102", &Shapes::quoted},     {"E0207", &Shapes::chain},
        {"E0214", &Shapes::clarke},     {"E0222", &Shapes::factor},
        {"E0225", &Shapes::quoted},     {"E0226", &Shapes::absolute},
        {"E0230", &Shapes::joined},     {"E0303", &Shapes::rate},
        {"E0306", &Shapes::derivative}, {"E0309", &Shapes::multiplier},
        {"E0308", &Shapes::product},    {"E0401", &Shapes::direction},
        {"E0412", &Shapes::time},       {"E0414", &Shapes::direction},
        {"E0446", &Shapes::order},      {"E0503", &Shapes::past},
        {"W0104", &Shapes::order}};
    for (const auto& [code, shape] : shapes)
      if (code == d_.code) (this->*shape)();
    return std::move(out_);
  }

private:
  // --- tokens
  std::string text(std::size_t first, std::size_t last) const {
    return a_.text(join(tokens_[first].span, tokens_[last].span));
  }
  bool is(std::size_t i, TokenKind kind) const {
    return i < tokens_.size() && tokens_[i].kind == kind;
  }
  /// The bracket that a closing one belongs to, or the one that closes an opening one.
  std::optional<std::size_t> partner(std::size_t i) const {
    const bool back = closes(tokens_[i].kind);
    int depth = 0;
    for (; i < tokens_.size(); back ? --i : ++i) {
      depth += opens(tokens_[i].kind) - closes(tokens_[i].kind);
      if (depth == 0) return i;
      if (back && i == 0) break;
    }
    return std::nullopt;
  }
  /// The first token of the operand that ends with this one: `u.nu`, `exp(-t)`, `[1, 0]`, `u'`.
  std::size_t operand_begin(std::size_t i) const {
    while (i > 0 && is(i, TokenKind::prime)) --i;
    if (closes(tokens_[i].kind)) {
      const auto open = partner(i);
      if (!open) return i;
      i = *open;
      if (i > 0 && is(i, TokenKind::open_paren) && is(i - 1, TokenKind::name)) --i;
    }
    return i > 1 && is(i - 1, TokenKind::dot) ? operand_begin(i - 2) : i;
  }
  /// The last token of the operand that begins with this one.
  std::size_t operand_end(std::size_t i) const {
    if (is(i, TokenKind::minus)) ++i;
    if (i < tokens_.size() && opens(tokens_[i].kind)) i = partner(i).value_or(i);
    while (i + 1 < tokens_.size()) {
      if (is(i + 1, TokenKind::prime)) {
        ++i;
      } else if (is(i + 1, TokenKind::dot)) {
        i += 2;
      } else if (is(i, TokenKind::name) && is(i + 1, TokenKind::open_paren) && partner(i + 1)) {
        i = *partner(i + 1);
      } else {
        break;
      }
    }
    return std::min(i, tokens_.size() - 1);
  }

  // --- edits
  static Span before(const Span& span) { return {span.file, span.begin, span.begin}; }
  void add(std::vector<Change> changes, std::string title) {
    out_.push_back({std::move(changes), std::move(title)});
  }
  void write(const Span& span, const std::string& text) {
    add({{span, text}}, fmt::format("write `{}` in place of `{}`", text, a_.text(span)));
  }

  /// The rest of the line of the place, with where it begins.
  std::pair<std::uint32_t, std::string_view> rest_of_line() const {
    const SourceFile& file = a_.source();
    const int line = file.position(d_.primary.begin).line;
    const std::uint32_t end =
        file.line_begin(line) + static_cast<std::uint32_t>(file.line(line).size());
    return {d_.primary.begin, file.text({0, d_.primary.begin, end})};
  }

  /// “a text” and 'a text': the quotes on both sides.
  void quoted() {
    const auto [begin, line] = rest_of_line();
    std::vector<Change> changes;
    for (std::size_t i = 0; i < line.size(); ++i)
      for (const std::string_view quote : quotes)
        if (line.substr(i).starts_with(quote)) {
          const auto at = begin + static_cast<std::uint32_t>(i);
          changes.push_back({{0, at, at + static_cast<std::uint32_t>(quote.size())}, "\""});
          break;
        }
    if (changes.size() == 2) add(std::move(changes), "write `\"` on both sides of the text");
  }

  /// a < b < c
  void chain() {
    if (d_.secondary.empty()) return;
    std::string middle = a_.text({0, d_.secondary.front().span.end, d_.primary.begin});
    middle.erase(0, middle.find_first_not_of(' '));
    middle.erase(middle.find_last_not_of(' ') + 1);
    add({{before(d_.primary), fmt::format("and {} ", middle)}},
        fmt::format("add `and {}`", middle));
  }

  /// layer^o(u; v), layer(u; v)
  void clarke() {
    const auto call = call_at(a_, d_.primary.begin);
    if (!call || call->open < 2) return;
    if (is(call->open - 2, TokenKind::caret)) return write(tokens_[call->open - 1].span, "0");
    add({{before(tokens_[call->open].span), "^0"}}, "add `^0`");
  }

  /// integral(...) * 2 and 1/2 * integral(...)
  void factor() {
    if (at_ == 0) return;
    const std::size_t end = operand_end(at_ + 1);
    if (d_.message.starts_with("a quotient")) {
      const std::size_t begin = operand_begin(at_ - 1);
      return add({{before(tokens_[begin].span), "("}, {after(tokens_[end].span), ")"}},
                 fmt::format("write `({})`", text(begin, end)));
    }
    const std::size_t integral = operand_begin(at_ - 1);
    const std::string by = text(at_ + 1, end);
    const std::string factor = is(at_, TokenKind::star) ? by + "*" : fmt::format("(1/{})*", by);
    add({{before(tokens_[integral].span), factor},
         {join(after(tokens_[at_ - 1].span), tokens_[end].span), ""}},
        fmt::format("write `{}` before the integral", factor));
  }

  /// |r|
  void absolute() {
    const auto [begin, line] = rest_of_line();
    const std::size_t behind = line.find('|', 1);
    if (behind == std::string_view::npos) return;
    const auto end = begin + static_cast<std::uint32_t>(behind);
    for (const std::string name : {"abs", "norm"})
      add({{d_.primary, name + "("}, {{0, end, end + 1}, ")"}},
          fmt::format("write `{}({})`", name, line.substr(1, behind - 1)));
  }

  /// [N m]
  void joined() {
    if (at_ == 0 || !d_.message.starts_with("units are joined")) return;
    const Span blank{0, tokens_[at_ - 1].span.end, d_.primary.begin};
    for (const char* sign : {"*", "/"}) {
      add({{blank, sign}}, fmt::format("write `[{}{}{}]`", a_.text(tokens_[at_ - 1].span), sign,
                                       a_.text(d_.primary)));
      out_.back().one_of_several = true;
    }
  }

  /// eps(u)' is eps(u').
  void rate() {
    if (!is(at_, TokenKind::prime) || at_ == 0 || !is(at_ - 1, TokenKind::close_paren)) return;
    const std::size_t begin = operand_begin(at_ - 1);
    std::string call = text(begin, at_ - 1);
    write(join(tokens_[begin].span, d_.primary), call.insert(call.size() - 1, "'"));
  }

  /// What a help tells to write behind "write `".
  std::string told() const {
    constexpr std::string_view begin = "write `";
    if (!d_.help.starts_with(begin)) return {};
    return d_.help.substr(begin.size(), d_.help.find('`', begin.size()) - begin.size());
  }

  /// layer(u.nu)*v.nu is layer^0(u.nu; v.nu).
  void derivative() {
    const std::size_t star = token_at(a_, d_.primary.end);
    if (told().find("^0(") != std::string::npos && is(star, TokenKind::star))
      write(join(d_.primary, tokens_[operand_end(star + 1)].span), told());
  }

  /// layer^0(u.nu; v.nu) in a report
  void multiplier() {
    constexpr std::string_view begin = "the multiplier is `";
    if (d_.help.starts_with(begin))
      write(d_.primary, d_.help.substr(begin.size(), d_.help.size() - begin.size() - 1));
  }

  /// a * b of vectors is dot(a, b); dot(a, b) of numbers is a*b.
  void product() {
    if (d_.help.find("`dot(a, b)`") != std::string::npos && at_ > 0) {
      const std::size_t begin = operand_begin(at_ - 1), end = operand_end(at_ + 1);
      write(join(tokens_[begin].span, tokens_[end].span),
            fmt::format("dot({}, {})", text(begin, at_ - 1), text(at_ + 1, end)));
    }
    const auto call = call_at(a_, d_.primary.end - 1);
    const auto comma = std::ranges::find(tokens_, TokenKind::comma, &Token::kind);
    if (d_.help != "use `*` to multiply by a scalar" || !call || call->callee != "dot") return;
    const auto end = partner(call->open);
    for (auto i = static_cast<std::size_t>(comma - tokens_.begin()); end && i < *end; ++i)
      if (is(i, TokenKind::comma) && i > call->open + 1)
        write(d_.primary, fmt::format("{}*{}", text(call->open + 1, i - 1), text(i + 1, *end - 1)));
  }

  /// The direction of a law is its argument with the test function in place of the unknown.
  void direction() {
    std::size_t clarke = at_;
    while (clarke > 0 && !is(clarke, TokenKind::clarke)) --clarke;
    const auto end = partner(clarke);
    std::size_t semicolon = clarke;
    while (semicolon < tokens_.size() && !is(semicolon, TokenKind::semicolon)) ++semicolon;
    if (!end || semicolon >= *end || clarke == 0) return;
    if (!told().empty()) write(join(tokens_[clarke - 1].span, tokens_[*end].span), told());
    write(join(tokens_[semicolon + 1].span, tokens_[*end - 1].span), tested(clarke + 1, semicolon));
  }
  /// These tokens, as a test function has them.
  std::string tested(std::size_t begin, std::size_t end) const {
    std::vector<std::pair<std::string, std::string>> pairs; // unknown, its test function
    std::size_t tests = 0;
    for (const Definition& d : a_.names.definitions)
      if (d.kind == NameKind::unknown) pairs.emplace_back(d.name, "");
    for (const Definition& d : a_.names.definitions)
      if (d.kind == NameKind::test_function && tests < pairs.size()) pairs[tests++].second = d.name;
    std::string out;
    std::uint32_t behind = tokens_[begin].span.begin;
    for (std::size_t i = begin; i < end; ++i) {
      const Span& span = tokens_[i].span;
      out += a_.text({0, behind, span.begin});
      behind = span.end;
      const std::string word = a_.text(span);
      const auto pair = std::ranges::find(pairs, word, &std::pair<std::string, std::string>::first);
      if (is(i, TokenKind::prime)) continue;
      out += pair == pairs.end() ? word : pair->second;
    }
    return out;
  }

  /// `for t in [0, T] by N steps` stands before `using` and `such that`.
  void time() {
    std::string starts;
    std::uint32_t behind = 0;
    for (const Definition& d : a_.names.definitions)
      if (d.kind == NameKind::unknown)
        starts += fmt::format("{}{} = 0", starts.empty() ? "" : ", ", d.name), behind = d.span.end;
    const auto next = std::ranges::find_if(tokens_, [&](const Token& token) {
      const std::string word = a_.text(token.span);
      return token.span.begin > behind && (word == "using" || word == "such");
    });
    if (starts.empty() || next == tokens_.end() || d_.help.find("for t in") == std::string::npos)
      return;
    const std::string text = fmt::format("for t in [0, 1] by 10 steps from {}", starts);
    add({{before(next->span), text + "\n"}}, fmt::format("add `{}`", text));
  }

  /// kernel q(s, t)
  void past() { write(d_.primary, "t, s"); }

  /// P2 in place of P1, in the space that needs it, or the other way round.
  void order() {
    for (const auto& [old, other] : {std::pair{"P1", "P2"}, std::pair{"P2", "P1"}})
      for (const Token& token : tokens_)
        if (token.kind == TokenKind::name && a_.text(token.span) == old) write(token.span, other);
  }

  const Analysis& a_;
  const Diagnostic& d_;
  const std::vector<Token>& tokens_;
  std::size_t at_; ///< the token of the place
  std::vector<Edit> out_;
};

} // namespace

std::vector<Edit> edits_by_shape(const Analysis& analysis, const Diagnostic& diagnostic) {
  return Shapes(analysis, diagnostic).all();
}

} // namespace hvi::lang
