// Edits that follow from the words of a help alone; see edits.hpp.
#include "lang/editor/edits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace hvi::lang {

namespace {

/// Messages whose help shows an example of what is meant: it is not what to write at their place.
constexpr std::array with_examples{"E0309", "E0413", "E0415", "E0428",
                                   "E0432", "E0441", "E0447", "E0448"};

/// A text between backticks, to be taken as it is.
struct Quoted {
  std::string text;
  bool added = false; ///< "add `text`": what stands there stays
};

/// None with "...", unless it says what stands there already: `a = ... at [1, 0]`.
std::vector<Quoted> between_backticks(const std::string& said) {
  std::vector<Quoted> out;
  for (std::size_t open = said.find('`'); open != std::string::npos;) {
    const std::size_t close = said.find('`', open + 1);
    if (close == std::string::npos) break;
    const std::string text = said.substr(open + 1, close - open - 1);
    const std::size_t dots = text.find("... ");
    if (dots != std::string::npos)
      out.push_back({text.substr(dots + 4), true});
    else if (!text.empty() && text.find("...") == std::string::npos)
      out.push_back({text, said.substr(0, open).ends_with("add ")});
    open = said.find('`', close + 1);
  }
  return out;
}

/// The words behind "one of: ".
std::vector<std::string> one_of(const std::string& help) {
  constexpr std::string_view begin = "one of: ";
  std::vector<std::string> out;
  if (!help.starts_with(begin)) return out;
  for (std::size_t at = begin.size(); at < help.size();) {
    const std::size_t end = std::min(help.find(", ", at), help.size());
    out.push_back(help.substr(at, end - at));
    at = end + 2;
  }
  return out;
}

/// The end of the statement that holds a span, without the blanks behind it.
Span end_of_statement(const Analysis& a, const Span& span) {
  const auto statement = statement_at(a.tokens[0], span.begin);
  return statement.empty() ? after(span) : after(statement.back().span);
}

/// The lines of a statement that nothing uses, their ends included.
Span lines_of(const Analysis& a, const Definition& d) {
  const SourceFile& file = a.source();
  const int first = file.position(d.statement.begin).line;
  const int behind = file.position(d.statement.end).line + 1;
  const std::uint32_t end = behind <= file.n_lines()
                                ? file.line_begin(behind)
                                : static_cast<std::uint32_t>(file.text().size());
  return {0, file.line_begin(first), end};
}

/// Collects what one message lets one try.
class Proposals {
public:
  Proposals(const Analysis& analysis, const Diagnostic& diagnostic)
      : a_(analysis), d_(diagnostic), written_(analysis.text(diagnostic.primary)) {}

  std::vector<Edit> all() {
    if (d_.code == "W0101") unused();
    if (d_.help == "leave it out")
      add({d_.code == "W0109" ? setting() : d_.primary, ""}, fmt::format("remove `{}`", written_));
    for (const std::string& word : one_of(d_.help)) {
      in_place_of(d_.primary, word);
      out_.back().one_of_several = true;
    }
    if (std::ranges::find(with_examples, d_.code) != with_examples.end()) return std::move(out_);
    for (const Quoted& quoted : between_backticks(d_.help)) take(quoted);
    for (const Quoted& quoted : between_backticks(d_.label)) take({quoted.text, true});
    return std::move(out_);
  }

private:
  void add(Change change, std::string title) {
    out_.push_back({{std::move(change)}, std::move(title)});
  }
  void in_place_of(const Span& span, const std::string& text) {
    add({span, text}, fmt::format("write `{}` in place of `{}`", text, a_.text(span)));
  }
  void insert(const Span& at, const std::string& text, const std::string& shown) {
    add({{at.file, at.begin, at.begin}, text}, fmt::format("add `{}`", shown));
  }

  /// A setting of `using`, of whose name the message is, with the comma that goes with it.
  Span setting() const {
    const auto& tokens = a_.tokens[0].tokens;
    const auto name = std::ranges::find_if(
        tokens, [&](const Token& token) { return token.span.begin == d_.primary.begin; });
    int depth = 0;
    auto end = name;
    for (; end->kind != TokenKind::end && a_.text(end->span) != "such"; ++end) {
      const bool opens = end->kind == TokenKind::open_paren || end->kind == TokenKind::open_bracket;
      const bool closes =
          end->kind == TokenKind::close_paren || end->kind == TokenKind::close_bracket;
      depth += opens ? 1 : closes ? -1 : 0;
      if (depth == 0 && end->kind == TokenKind::comma)
        return {0, name->span.begin, std::next(end)->span.begin};
    }
    return {0, std::prev(name)->span.begin, std::prev(end)->span.end}; // with the comma, or `using`
  }

  void unused() {
    const NameUse* const use = a_.names.at(0, d_.primary.begin);
    if (!use) return;
    const Definition& definition = a_.names.definitions[use->definition];
    if (definition.kind == NameKind::argument) return; // it goes from every call, too
    add({lines_of(a_, definition), ""}, fmt::format("remove `{}`", definition.name));
  }

  void take(const Quoted& quoted) {
    const std::string& text = quoted.text;
    if (text.starts_with("import ") && (d_.code == "E0318" || d_.code == "E0601"))
      return in_place_of(d_.primary, text.substr(std::string_view("import ").size()));
    if (text.starts_with("import ")) return insert(start(), text + "\n", text);
    if (text.starts_with(", ")) return behind_spaces(text);
    if (text.starts_with("for t in ")) return; // by its shape
    if (!written_.empty()) {
      in_place_of(d_.primary, text);
      within_quotes(text);
      of_an_object(text);
      whole_statement(text);
    }
    const bool sign = text.find_first_not_of("*/:;,") == std::string::npos;
    if (!sign && !quoted.added) return;
    insert(d_.primary, text + (sign ? "" : " "), text);
    insert(after(d_.primary), " " + text, text);
    insert(end_of_statement(a_, d_.primary), " " + text, text);
  }

  Span start() const { return a_.tokens[0].tokens.front().span; }

  /// `, zero on left` belongs to a space, which stands elsewhere.
  void behind_spaces(const std::string& text) {
    for (const Definition& d : a_.names.definitions)
      if (d.kind == NameKind::space && d.statement.file == 0)
        insert(end_of_statement(a_, d.statement), text, text);
  }

  /// "roof" in a text, [GPa] in a unit, ".png" behind the name of a file.
  void within_quotes(const std::string& text) {
    const bool meant = d_.help.starts_with("did you mean");
    if (written_.front() == '"' && text.front() == '.') {
      if (const auto dot = written_.rfind('.'); dot != std::string::npos)
        in_place_of(d_.primary, written_.substr(0, dot) + text + "\"");
    } else if (written_.front() == '"' && meant) {
      in_place_of(d_.primary, "\"" + text + "\"");
    } else if (written_.front() == '[' && meant) {
      const auto wrong = between_backticks(d_.message);
      const std::size_t at = wrong.empty() ? std::string::npos : written_.find(wrong.front().text);
      if (at != std::string::npos)
        in_place_of(d_.primary, std::string(written_).replace(at, wrong.front().text.size(), text));
    }
  }

  /// `layer.xi` for the name behind `layer.`, `upper.left` for all of `both.left`.
  void of_an_object(const std::string& text) {
    const std::size_t token = token_at(a_, d_.primary.begin);
    const auto& tokens = a_.tokens[0].tokens;
    if (token < 2 || tokens[token - 1].kind != TokenKind::dot) return;
    in_place_of(join(tokens[token - 2].span, d_.primary), text);
  }

  /// `units mm, N, s` for a statement of the same word.
  void whole_statement(const std::string& text) {
    const auto statement = statement_at(a_.tokens[0], d_.primary.begin);
    if (statement.empty() || !text.starts_with(a_.text(statement.front().span) + " ")) return;
    const Span whole = join(statement.front().span, statement.back().span);
    in_place_of(whole, text);
  }

  const Analysis& a_;
  const Diagnostic& d_;
  std::string written_; ///< what the message underlines
  std::vector<Edit> out_;
};

} // namespace

std::vector<Edit> edits_for(const Analysis& analysis, const Diagnostic& diagnostic) {
  std::vector<Edit> out = Proposals(analysis, diagnostic).all();
  for (Edit& edit : edits_by_shape(analysis, diagnostic)) out.push_back(std::move(edit));
  return out;
}

} // namespace hvi::lang
