// See hover.hpp.
#include "lang/editor/hover.hpp"

#include "lang/check/builtins.hpp"
#include "lang/editor/words_of_statements.hpp"
#include "lang/units/units.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace hvi::lang {

namespace {

Json shown(const EditorPlace& place, const Span& span, const std::string& text) {
  return {{"contents", markdown(text)}, {"range", place.range(span)}};
}

std::string describe(const BuiltIn& built_in) {
  return code_block(built_in.usage) + "\n" + std::string(built_in.doc);
}

constexpr std::array<std::pair<std::string_view, std::string_view>, 8> quantities = {
    {{"t", "the time"},
     {"x", "the first coordinate of the place; the distance from the axis of a body of revolution"},
     {"y", "the second coordinate of the place"},
     {"z", "the third coordinate of the place"},
     {"pi", "3.14159..."},
     {"lag", "t - s, the time that has passed, in a kernel"},
     {"normal", "the outward unit normal"},
     {"sigma", "the stress: what stands before `: eps(v)` in the forms, memories included"}}};

/// Where each argument stands in "f(a, b = 1)": between the first bracket and the last one, at
/// commas that lie in no other bracket.
std::vector<std::pair<int, int>> arguments_in(std::string_view usage) {
  std::vector<std::pair<int, int>> out;
  const auto open = usage.find('('), close = usage.rfind(')');
  if (open == std::string_view::npos || close == std::string_view::npos) return out;
  int depth = 0;
  std::size_t begin = open + 1;
  for (std::size_t i = begin; i <= close; ++i) {
    if (usage[i] == '(' || usage[i] == '[') ++depth;
    if (i < close && (usage[i] == ')' || usage[i] == ']')) --depth;
    if (i < close && (usage[i] != ',' || depth > 0)) continue;
    while (begin < i && usage[begin] == ' ') ++begin;
    if (begin < i) out.emplace_back(static_cast<int>(begin), static_cast<int>(i));
    begin = i + 1;
  }
  return out;
}

/// Which of the arguments is being written: by its name, else by the commas before it.
int active_argument(std::string_view usage, const std::vector<std::pair<int, int>>& arguments,
                    const OpenCall& call) {
  if (!call.named) return call.argument;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view text = usage.substr(static_cast<std::size_t>(arguments[i].first));
    const auto end = text.find_first_of(" =,)");
    if (text.substr(0, end) == *call.named) return static_cast<int>(i);
  }
  return call.argument;
}

} // namespace

std::string heading_of(const Analysis& analysis, const Definition& d) {
  if (d.kind == NameKind::argument) return fmt::format("{} of {}", d.name, d.owner);
  // Up to where the declared value begins, on one line.
  const std::string statement = analysis.text(d.statement);
  const auto behind = static_cast<std::size_t>(d.span.end - d.statement.begin);
  std::size_t end = behind;
  const bool called = d.kind == NameKind::kernel || d.kind == NameKind::superpotential ||
                      d.kind == NameKind::function;
  for (int depth = 0; called && end < statement.size(); ++end) {
    if (statement[end] == '(') ++depth;
    if (statement[end] == ')' && --depth == 0) {
      ++end;
      break;
    }
  }
  return fmt::format("{} {}", word(d.kind),
                     called ? analysis.text({d.span.file, d.span.begin,
                                             d.statement.begin + static_cast<std::uint32_t>(end)})
                            : d.name);
}

namespace {

std::string in_brackets(const std::string& unit) {
  return unit.empty() || unit == "1" ? "" : " [" + unit + "]";
}

std::string found_in(const std::map<std::string, std::string>& units, const std::string& name) {
  const auto found = units.find(name);
  return found == units.end() ? "" : in_brackets(found->second);
}

/// `grow(a [a]) [a/s]` of a function or a law, in the dimensions of its arguments; or nothing.
std::string signature_in_units(const Analysis& analysis, const std::string& name) {
  const Script& script = analysis.script();
  if (!script.model || !script.model->units.used()) return {};
  for (std::string& one : units::signatures(script.programs, *script.model))
    if (one.starts_with(name + "(")) return std::move(one);
  return {};
}

/// " [p/r]" of an argument in such a signature.
std::string unit_in_signature(const std::string& signature, const std::string& argument) {
  for (const char* before : {"(", ", "}) {
    const auto found = signature.find(before + argument + " [");
    if (found == std::string::npos) continue;
    const auto begin = signature.find(" [", found + 1);
    return signature.substr(begin, signature.find(']', begin) + 1 - begin);
  }
  return {};
}

std::string unit_of_quantity(const std::optional<Model>& model, const std::string& name) {
  if (!model || !model->units.used()) return {};
  if (name == "x" || name == "y" || name == "z") return in_brackets(model->report.unit_of_length);
  return found_in(model->units.of, name == "lag" ? "t" : name);
}

std::string unit_of_parameter(const Model& model, const std::string& name) {
  const auto p = std::ranges::find(model.params, name, &ModelParam::name);
  if (p == model.params.end()) return {};
  return p->times == p->over || !std::holds_alternative<double>(p->value)
             ? in_brackets(p->unit)
             : fmt::format(" in units of {}: {}{}", model.units.system,
                           p->as_declared(std::get<double>(p->value)), in_brackets(p->unit));
}

/// What an argument is called with: its own where the inequality or the kernel tells, else in the
/// dimensions of the others.
std::string unit_of_argument(const Analysis& analysis, const Definition& d) {
  const Model& model = *analysis.script().model;
  const auto owner = std::ranges::find_if(analysis.names.definitions, [&](const Definition& one) {
    return one.name == d.owner && one.kind != NameKind::argument;
  });
  if (owner == analysis.names.definitions.end()) return {};
  if (owner->kind == NameKind::kernel) return found_in(model.units.of, "t");
  const std::string signature = signature_in_units(analysis, d.owner);
  const auto seen = model.units.of_arguments.find(d.owner);
  if (seen != model.units.of_arguments.end() && signature.starts_with(d.owner + "(" + d.name + " "))
    return in_brackets(seen->second);
  return unit_in_signature(signature, d.name);
}

} // namespace

/// " [GPa]" of what a script with units declares; empty where there is none to tell.
std::string unit_of(const Analysis& analysis, const Definition& d) {
  const auto& model = analysis.script().model;
  if (!model || !model->units.used()) return {};
  const ModelUnits& units = model->units;
  const auto behind = [](const std::string& word, const std::string& unit) {
    return unit.empty() ? "" : fmt::format(" {}{}", word, unit);
  };
  switch (d.kind) {
  case NameKind::parameter:
    return unit_of_parameter(*model, d.name);
  case NameKind::argument:
    return unit_of_argument(analysis, d);
  case NameKind::mesh:
    return behind("with lengths in", in_brackets(model->report.unit_of_length));
  case NameKind::tensor:
    return found_in(units.of_tensors, d.name);
  case NameKind::kernel:
    return behind("with values in", units.of_kernel(d.name));
  case NameKind::superpotential:
    return behind("of an argument in", units.of_argument(d.name)) +
           behind("with its multiplier in", units.of_multiplier(d.name));
  case NameKind::test_function:
    return found_in(units.of_tests, d.name);
  case NameKind::column:
    return found_in(units.of_columns, d.name);
  default:
    return found_in(units.of, d.name);
  }
}

std::string describe(const Analysis& analysis, const Definition& d) {
  const bool whole = d.kind != NameKind::unknown && d.kind != NameKind::test_function &&
                     d.kind != NameKind::column && d.kind != NameKind::argument;
  std::string out = code_block(whole ? analysis.text(d.statement) : heading_of(analysis, d));
  if (const NameFacts* facts = analysis.facts_of(d)) {
    out += "\n" + facts->what + unit_of(analysis, d);
    if (!facts->groups.empty())
      out += fmt::format("; its parts: {}", solver::joined(facts->groups));
  } else if (d.kind == NameKind::argument) {
    out += fmt::format("\nan argument of `{}`{}", d.owner, unit_of(analysis, d));
  } else {
    out += fmt::format("\n{}{}", word(d.kind), unit_of(analysis, d));
  }
  const bool called = d.kind == NameKind::function || d.kind == NameKind::superpotential;
  if (const auto signature = called ? signature_in_units(analysis, d.name) : ""; !signature.empty())
    out += fmt::format("\n\nunits: `{}`", signature);
  const std::string comment = comment_of(analysis, d);
  if (whole && !comment.empty()) out += "\n\n" + comment;
  const std::string& file = analysis.script().sources.file(d.span.file).path();
  if (d.span.file != 0) out += fmt::format("\n\n*{}*", file);
  return out;
}

Json hover(const EditorPlace& place) {
  const Analysis& a = place.analysis;
  if (const NameUse* use = a.names.at(0, place.offset))
    return shown(place, use->span, describe(a, a.names.definitions[use->definition]));
  const Token& token = a.tokens[0].tokens[token_at(a, place.offset)];
  if (token.kind == TokenKind::end || token.span.begin > place.offset) return nullptr;
  const std::string text = a.text(token.span);
  if (token.kind == TokenKind::name) {
    if (const BuiltIn* built_in = find_built_in(text))
      return shown(place, token.span, describe(*built_in));
  }
  for (const auto& [name, what] : quantities)
    if (token.kind == TokenKind::name && name == text)
      return shown(place, token.span,
                   fmt::format("{}{}", what, unit_of_quantity(a.script().model, text)));
  const std::string_view said = word_of_statement(text);
  return said.empty() ? Json(nullptr) : shown(place, token.span, std::string(said));
}

Json signature(const EditorPlace& place) {
  const auto call = call_at(place.analysis, place.offset);
  if (!call) return nullptr;
  std::string usage, doc;
  const auto& bracket = place.analysis.tokens[0].tokens[call->open];
  if (const BuiltIn* built_in = find_built_in(call->callee)) {
    usage = built_in->usage, doc = built_in->doc;
  } else if (const auto* d = place.analysis.names.visible(call->callee, bracket.span)) {
    usage = heading_of(place.analysis, *d), doc = comment_of(place.analysis, *d);
    const std::string in_units = signature_in_units(place.analysis, d->name);
    if (!in_units.empty()) doc += fmt::format("{}units: `{}`", doc.empty() ? "" : "\n\n", in_units);
  }
  const auto arguments = arguments_in(usage);
  if (arguments.empty()) return nullptr;
  Json parameters = Json::array();
  for (const auto& [begin, end] : arguments) {
    const auto before = static_cast<std::size_t>(begin), behind = static_cast<std::size_t>(end);
    parameters.push_back({{"label",
                           {units_of(std::string_view(usage).substr(0, before), place.unit),
                            units_of(std::string_view(usage).substr(0, behind), place.unit)}}});
  }
  const int active =
      std::min(active_argument(usage, arguments, *call), static_cast<int>(arguments.size()) - 1);
  return {{"signatures",
           {{{"label", usage}, {"documentation", markdown(doc)}, {"parameters", parameters}}}},
          {"activeSignature", 0},
          {"activeParameter", active}};
}

} // namespace hvi::lang
