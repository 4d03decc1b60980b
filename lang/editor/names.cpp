// Declarations first, then uses; see names.hpp.
#include "lang/editor/names.hpp"

#include "lang/syntax/lexer.hpp"
#include "lang/syntax/tree_names.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace hvi::lang {

namespace {

bool covers(const Span& outer, const Span& inner) {
  return outer.file == inner.file && outer.begin <= inner.begin && inner.end <= outer.end;
}

/// Words that begin a declaration of one name.
std::optional<NameKind> declares(TokenKind kind) {
  using enum TokenKind;
  switch (kind) {
  case param:
    return NameKind::parameter;
  case mesh:
    return NameKind::mesh;
  case part:
    return NameKind::part;
  case tensor:
    return NameKind::tensor;
  case kernel:
    return NameKind::kernel;
  case superpotential:
    return NameKind::superpotential;
  case state:
    return NameKind::state;
  case fn:
    return NameKind::function;
  case space:
    return NameKind::space;
  default:
    return std::nullopt;
  }
}

/// Makes the index of a script.
class Indexer {
public:
  Indexer(const Script& script, const Tokens& tokens) : script_(script), tokens_(tokens) {}

  NameIndex run() {
    for (const ast::Program& program : script_.programs) declare_all(program);
    sort_declarations();
    for (const ast::Program& program : script_.programs) use_all(program);
    const auto place = [](const NameUse& a) { return std::pair(a.span.file, a.span.begin); };
    std::ranges::sort(index_.uses, {}, place);
    const auto same = [&](const NameUse& a, const NameUse& b) { return place(a) == place(b); };
    index_.uses.erase(std::unique(index_.uses.begin(), index_.uses.end(), same), index_.uses.end());
    return std::move(index_);
  }

private:
  using Statement = std::span<const Token>;

  std::string text(const Token& token) const {
    return std::string(script_.sources.text(token.span));
  }

  template <class Use>
  void for_each_statement(const ast::Program& program, const Use& use) const {
    const auto& all = tokens_[static_cast<std::size_t>(program.file)].tokens;
    std::size_t begin = 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
      const bool ends = all[i].kind == TokenKind::end;
      if (!ends && !(is_statement_word(all[i].kind) && all[i - 1].kind != TokenKind::dot)) continue;
      use(Statement(all).subspan(begin, i - begin));
      begin = i;
    }
  }

  void add(const Token& name, NameKind kind, const Statement& s, Span scope = {},
           std::string owner = {}) {
    const Span whole = join(s.front().span, s.back().span);
    index_.definitions.push_back({text(name), kind, name.span, whole, scope, std::move(owner)});
  }

  void declare_all(const ast::Program& program) {
    for_each_statement(program, [&](const Statement& s) {
      if (const auto kind = declares(s.front().kind); kind && s.size() > 1) {
        if (s[1].kind != TokenKind::name) return;
        add(s[1], *kind, s);
        declare_arguments(s);
      } else if (s.front().kind == TokenKind::find) {
        declare_unknowns(s);
      } else if (s.front().kind == TokenKind::report) {
        declare_columns(s);
      }
    });
  }

  /// fn f(a, b), superpotential j(r, k = 1): names behind the bracket and behind its commas.
  void declare_arguments(const Statement& s) {
    using enum TokenKind;
    const auto word = s.front().kind;
    if (word != fn && word != kernel && word != superpotential) return;
    if (s.size() < 3 || s[2].kind != open_paren) return;
    const Span scope = join(s.front().span, s.back().span);
    int depth = 0;
    for (std::size_t i = 2; i < s.size(); ++i) {
      if (s[i].kind == open_paren || s[i].kind == open_bracket || s[i].kind == clarke) ++depth;
      if (s[i].kind == close_paren || s[i].kind == close_bracket) --depth;
      if (depth == 0) return;
      const bool first = i == 3 || (depth == 1 && s[i - 1].kind == comma);
      if (first && s[i].kind == name) add(s[i], NameKind::argument, s, scope, text(s[1]));
    }
  }

  /// find u in V, theta in W ... for all v in V, eta in W
  void declare_unknowns(const Statement& s) {
    using enum TokenKind;
    NameKind kind = NameKind::unknown;
    for (std::size_t i = 1; i + 1 < s.size(); ++i) {
      const bool in = s[i].kind == name && s[i + 1].kind == name && text(s[i + 1]) == "in";
      const bool first = s[i - 1].kind == TokenKind::find || s[i - 1].kind == comma ||
                         (s[i - 1].kind == name && text(s[i - 1]) == "all");
      if (s[i].kind == name && text(s[i]) == "all") kind = NameKind::test_function;
      if (in && first) add(s[i], kind, s);
      if (kind == NameKind::test_function && text(s[i]) == "integral") return;
    }
  }

  /// table a = ..., b = ...: names before a single "=" outside of brackets.
  void declare_columns(const Statement& s) {
    using enum TokenKind;
    int depth = 0;
    for (std::size_t i = 1; i + 1 < s.size(); ++i) {
      if (s[i].kind == open_paren || s[i].kind == open_bracket || s[i].kind == clarke) ++depth;
      if (s[i].kind == close_paren || s[i].kind == close_bracket) --depth;
      const bool binding = s[i].kind == name && s[i + 1].kind == equal && depth == 0;
      const bool time = text(s[i]) == "t" && text(s[i - 1]) == "at";
      if (binding && !time) add(s[i], NameKind::column, s);
    }
  }

  void sort_declarations() {
    for (std::size_t i = 0; i < index_.definitions.size(); ++i) {
      const Definition& d = index_.definitions[i];
      if (d.kind == NameKind::argument)
        arguments_[d.owner + "(" + d.name].push_back(i);
      else if (d.kind == NameKind::column)
        columns_.try_emplace(d.name, i);
      else
        globals_.try_emplace(d.name, i);
      index_.uses.push_back({d.span, i});
    }
  }

  std::optional<std::size_t> argument_of(const std::string& owner, const std::string& name) const {
    const auto found = arguments_.find(owner + "(" + name);
    if (found == arguments_.end()) return std::nullopt;
    return found->second.front();
  }

  /// What a name in a statement of this declared name stands for.
  std::optional<std::size_t> meaning(const std::string& name, const std::string& inside) const {
    if (const auto argument = argument_of(inside, name)) return argument;
    const auto found = globals_.find(name);
    if (found == globals_.end()) return std::nullopt;
    return found->second;
  }

  /// The name within parentheses that lie in its span.
  Span bare(const std::string& name, Span span) const {
    const auto& all = tokens_[static_cast<std::size_t>(span.file)].tokens;
    auto token =
        std::ranges::lower_bound(all, span.begin, {}, [](const Token& t) { return t.span.begin; });
    while (token != all.end() && token->kind == TokenKind::open_paren) ++token;
    return token != all.end() && text(*token) == name ? token->span : Span{};
  }

  void use(const std::string& name, const Span& span, const std::string& inside) {
    const auto found = meaning(name, inside);
    const Span place = bare(name, span);
    if (found && place.valid()) index_.uses.push_back({place, *found});
    if (!found) index_.words.insert(name);
  }

  /// Of a vector each component is a column: `force_x`.
  void use_column(const std::string& name, const Span& span) {
    Span place = bare(name, span);
    auto found = columns_.find(name);
    const bool component = name.ends_with("_x") || name.ends_with("_y") || name.ends_with("_z");
    if (found == columns_.end() && component) {
      found = columns_.find(name.substr(0, name.size() - 2));
      place.end -= 2;
    }
    if (found != columns_.end() && place.valid()) index_.uses.push_back({place, found->second});
  }

  void use_all(const ast::Program& program) {
    std::unordered_map<std::uint32_t, const ast::Statement*> tree; // by where it begins
    for (const ast::Statement& statement : program.statements)
      std::visit([&](const auto& s) { tree[s.span.begin] = &statement; }, statement);
    for_each_statement(program, [&](const Statement& s) {
      const bool named = s.size() > 1 && declares(s.front().kind);
      const std::string inside = named ? text(s[1]) : "";
      const auto found = tree.find(s.front().span.begin);
      found == tree.end() ? use_tokens(s, inside) : use_tree(*found->second, inside);
    });
  }

  void use_tree(const ast::Statement& statement, const std::string& inside) {
    visit_names(statement,
                {[&](const std::string& name, const Span& span) { use(name, span, inside); },
                 [&](const std::string& name, const Span& span) { use_column(name, span); },
                 [&](const std::string& callee, const ast::Name& argument) {
                   if (const auto found = argument_of(callee, argument.text))
                     index_.uses.push_back({argument.span, *found});
                 }});
  }

  void use_tokens(const Statement& s, const std::string& inside) {
    for (std::size_t i = 1; i < s.size(); ++i) {
      if (s[i].kind != TokenKind::name || s[i - 1].kind == TokenKind::dot) continue;
      if (const auto found = meaning(text(s[i]), inside))
        index_.uses.push_back({s[i].span, *found});
      else
        use_column(text(s[i]), s[i].span);
    }
  }

  const Script& script_;
  const Tokens& tokens_;
  NameIndex index_;
  std::unordered_map<std::string, std::size_t> globals_, columns_;
  std::unordered_map<std::string, std::vector<std::size_t>> arguments_; ///< "owner(name"
};

} // namespace

std::string_view word(NameKind kind) {
  constexpr std::array<std::string_view, 13> words{
      "parameter", "mesh",     "part",  "tensor",  "kernel",        "superpotential",
      "state",     "function", "space", "unknown", "test function", "column of the table",
      "argument"};
  return words[static_cast<std::size_t>(kind)];
}

const NameUse* NameIndex::at(int file, std::uint32_t offset) const {
  for (const NameUse& use : uses)
    if (use.span.file == file && use.span.begin <= offset && offset <= use.span.end) return &use;
  return nullptr;
}

const Definition* NameIndex::visible(std::string_view name, const Span& place) const {
  const Definition* found = nullptr;
  for (const Definition& d : definitions) {
    if (d.name != name) continue;
    if (d.scope.valid() && covers(d.scope, place)) return &d;
    if (!d.scope.valid() && !found) found = &d;
  }
  return found;
}

Tokens tokens_of(const SourceMap& sources) {
  Tokens out;
  for (int file = 0; file < sources.n_files(); ++file) {
    Diagnostics reported_by_the_parser;
    out.push_back(lex(sources.file(file), reported_by_the_parser));
  }
  return out;
}

NameIndex index_names(const Script& script, const Tokens& tokens) {
  return Indexer(script, tokens).run();
}

std::span<const Token> statement_at(const TokenStream& stream, std::uint32_t offset) {
  const auto& all = stream.tokens;
  std::size_t begin = 0, end = all.size() - 1;
  bool inside = false;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (!is_statement_word(all[i].kind) || (i > 0 && all[i - 1].kind == TokenKind::dot)) continue;
    if (all[i].span.begin > offset) {
      end = i;
      break;
    }
    begin = i, inside = true;
  }
  return inside ? std::span(all).subspan(begin, end - begin) : std::span<const Token>{};
}

} // namespace hvi::lang
