// One function for each kind of place; see completion.hpp.
#include "lang/editor/completion.hpp"

#include "lang/check/builtins.hpp"
#include "lang/editor/hover.hpp"
#include "lang/editor/words_of_statements.hpp"
#include "lang/stdlib.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

/// Numbers of the protocol, CompletionItemKind.
enum class Item {
  function = 3,
  field = 5,
  variable = 6,
  type = 7,
  module = 9,
  property = 10,
  value = 12,
  keyword = 14,
  file = 17,
  constant = 21
};

Item item_of(NameKind kind) {
  switch (kind) {
  case NameKind::kernel:
  case NameKind::superpotential:
  case NameKind::function:
    return Item::function;
  case NameKind::mesh:
  case NameKind::part:
  case NameKind::space:
    return Item::type;
  case NameKind::parameter:
  case NameKind::tensor:
    return Item::constant;
  default:
    return Item::variable;
  }
}

/// Collects items for one place.
class Completion {
public:
  explicit Completion(const EditorPlace& place)
      : place_(place), a_(place.analysis), token_(first_token()),
        statement_(statement_at(a_.tokens[0], place.offset)) {}

  Json run() {
    if (in_comment()) return items_;
    if (in_text()) {
      files();
    } else if (behind(TokenKind::dot)) {
      members();
    } else if (previous_text() == "import") {
      for (const Module& module : standard_library())
        add(std::string(module.name), Item::module, "module of the standard library");
    } else if (previous_text() == "on") {
      names({NameKind::part, NameKind::mesh});
    } else if (previous_text() == "in" && behind_unknown()) {
      names({NameKind::space});
    } else {
      expressions();
    }
    return items_;
  }

private:
  // --- where the place is
  const std::vector<Token>& tokens() const { return a_.tokens[0].tokens; }
  /// The index of the token that is being written, or of the one behind the place.
  std::size_t first_token() const {
    const auto& all = a_.tokens[0].tokens;
    const auto found = std::ranges::find_if(all, [&](const Token& t) {
      const bool written = t.kind == TokenKind::name || is_reserved(t.kind);
      return written ? t.span.end >= place_.offset : t.span.end > place_.offset;
    });
    return static_cast<std::size_t>(std::min(found, all.end() - 1) - all.begin());
  }
  bool behind(TokenKind kind) const { return token_ > 0 && tokens()[token_ - 1].kind == kind; }
  std::string previous_text() const {
    return token_ > 0 ? a_.text(tokens()[token_ - 1].span) : std::string();
  }
  bool in_comment() const {
    return std::ranges::any_of(a_.tokens[0].comments, [&](const Span& c) {
      return c.begin < place_.offset && place_.offset <= c.end;
    });
  }
  bool in_text() const {
    const Token& token = tokens()[token_];
    return token.kind == TokenKind::string && token.span.begin < place_.offset;
  }
  /// find u in |, for all v in |
  bool behind_unknown() const {
    if (statement_.empty() || statement_.front().kind != TokenKind::find || token_ < 2)
      return false;
    const std::string name = a_.text(tokens()[token_ - 2].span);
    return std::ranges::any_of(a_.names.definitions, [&](const Definition& d) {
      return d.name == name && (d.kind == NameKind::unknown || d.kind == NameKind::test_function);
    });
  }
  bool first_on_line() const {
    const auto end = std::min(place_.offset, tokens()[token_].span.begin);
    const int line = a_.source().position(place_.offset).line;
    const std::uint32_t begin = a_.source().line_begin(line);
    return end <= begin ||
           a_.source().text({0, begin, end}).find_first_not_of(" \t") == std::string_view::npos;
  }

  // --- items
  Json& add(const std::string& label, Item kind, const std::string& detail) {
    items_.push_back({{"label", label}, {"kind", static_cast<int>(kind)}, {"detail", detail}});
    return items_.back();
  }
  void names(const std::set<NameKind>& kinds) {
    for (const Definition& d : a_.names.definitions)
      if (kinds.contains(d.kind)) add_name(d);
  }
  void add_name(const Definition& d) { add(d.name, item_of(d.kind), heading_of(a_, d)); }
  /// Arguments are so within their own statement only.
  bool visible(const Definition& d) const {
    return !d.scope.valid() || (d.scope.file == 0 && !statement_.empty() &&
                                d.scope.begin == statement_.front().span.begin);
  }

  void files() {
    const auto call = call_at(a_, place_.offset);
    const std::string wanted = !call                     ? ".hvi" // import "file.hvi"
                               : call->callee == "table" ? ".csv"
                               : call->callee == "gmsh"  ? ".msh"
                                                         : "";
    if (wanted.empty()) return groups(*call);
    std::error_code none;
    fs::path folder = fs::path(a_.script().path).parent_path();
    for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, none))
      if (entry.path().extension() == wanted ||
          (wanted == ".msh" && entry.path().extension() == ".geo"))
        add(entry.path().filename().string(), Item::file, "beside the script");
  }
  /// slab.group("|")
  void groups(const OpenCall& call) {
    if (call.callee != "group" || call.open < 3) return;
    const Definition* mesh = a_.names.visible(a_.text(tokens()[call.open - 3].span), Span{0, 0, 0});
    if (const NameFacts* facts = mesh ? a_.facts_of(*mesh) : nullptr)
      for (const std::string& group : facts->groups) add(group, Item::value, "group");
  }

  void members() {
    const Token& object = tokens()[token_ >= 2 ? token_ - 2 : 0];
    const std::string name = a_.text(object.span);
    const Definition* d = a_.names.visible(name, object.span);
    const bool rate = object.kind == TokenKind::prime; // u'.nu
    if (d && d->kind == NameKind::mesh) {
      if (const NameFacts* facts = a_.facts_of(*d))
        for (const std::string& group : facts->groups) add(group, Item::field, "part of " + name);
      add("boundary", Item::field, "the whole boundary");
      add("group", Item::field, "group(\"name\")");
    } else if (d && d->kind == NameKind::superpotential) {
      add("xi", Item::field, "the multiplier of the law");
    } else if (name == "sigma" || name == ")") {
      for (const char* c : {"xx", "yy", "zz", "xy", "xz", "yz", "nu", "tau", "x", "y", "z"})
        add(c, Item::field, "component");
    } else if (rate || !d || d->kind == NameKind::unknown || d->kind == NameKind::test_function) {
      add("nu", Item::field, "along the outward normal");
      add("tau", Item::field, "tangential part");
      for (const char* c : {"x", "y", "z"}) add(c, Item::field, "component");
    }
  }

  void expressions() {
    if (first_on_line() && statement_.size() < 2) return statements();
    if (const auto call = call_at(a_, place_.offset)) arguments(*call);
    if (first_on_line()) statements();
    const bool in_find = !statement_.empty() && statement_.front().kind == TokenKind::find;
    if (in_find && previous_text() == "using")
      for (const std::string_view name : setting_names())
        add(std::string(name), Item::property, "setting")["insertText"] =
            fmt::format("{} = ", name);
    for (const Definition& d : a_.names.definitions)
      if (d.kind != NameKind::column && visible(d)) add_name(d);
    for (const BuiltIn& b : built_ins()) {
      Json& item = add(std::string(b.name), Item::function, std::string(b.usage));
      item["documentation"] = markdown(std::string(b.doc));
    }
    for (const std::string_view one : words())
      add(std::string(one), Item::constant, "a word of the language");
  }

  void statements() {
    for (const std::string_view one : statement_words()) {
      Json& item = add(std::string(one), Item::keyword, "statement");
      item["insertText"] = pattern_of_statement(one);
      item["insertTextFormat"] = 2; // with places to fill in
      item["documentation"] = markdown(std::string(word_of_statement(one)));
    }
  }

  /// `young = ` of isotropic(|), `static = ` of a law.
  void arguments(const OpenCall& call) {
    const auto argument = [&](const std::string& name) {
      Json& item = add(name, Item::property, "argument of " + call.callee);
      item["insertText"] = name + " = ";
      item["sortText"] = " " + name; // first
    };
    for (const Definition& d : a_.names.definitions)
      if (d.kind == NameKind::argument && d.owner == call.callee) argument(d.name);
    const BuiltIn* const built_in = find_built_in(call.callee);
    if (!built_in) return;
    const std::string usage(built_in->usage);
    std::set<std::string> seen;
    for (auto equal = usage.find(" = "); equal != std::string::npos;
         equal = usage.find(" = ", equal + 1)) {
      auto begin = equal;
      while (begin > 0 && (std::isalnum(static_cast<unsigned char>(usage[begin - 1])) != 0 ||
                           usage[begin - 1] == '_'))
        --begin;
      const std::string name = usage.substr(begin, equal - begin);
      if (!name.empty() && seen.insert(name).second) argument(name);
    }
  }

  const EditorPlace& place_;
  const Analysis& a_;
  std::size_t token_;
  std::span<const Token> statement_;
  Json items_ = Json::array();
};

} // namespace

Json completion(const EditorPlace& place) { return Completion(place).run(); }

} // namespace hvi::lang
