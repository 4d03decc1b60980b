#include "lang/check/parameters.hpp"

#include "lang/check/builtins.hpp"
#include "lang/diag/suggest.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

namespace hvi::lang {

void Parameters::check_defines() {
  std::vector<std::string> known;
  for (const Declaration& d : names_.all())
    if (std::holds_alternative<ast::Param>(*d.statement)) known.push_back(d.name);
  for (const auto& [name, text] : options_.defines) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string near = did_you_mean(name, known);
    mistakes_.error("E0320", Span{},
                    fmt::format("{}{}={}: the script has no parameter `{}`", options_.words.define,
                                name, text, name),
                    known.empty()  ? "the script declares no `param`"
                    : near.empty() ? fmt::format("its parameters: {}", solver::joined(known))
                                   : near);
  }
}

Value Parameters::value(const ast::Param& param) {
  Scope scope;
  scope.what = "a parameter";
  ModelParam entry;
  entry.name = param.name.text;
  entry.span = param.name.span;
  if (param.doc) entry.doc = param.doc->text;
  Value value = evaluator_.expr(param.value, scope);
  if (options_.defines.contains(param.name.text)) {
    entry.overridden = true;
    value = defined_value(param);
    if (is_poison(value)) return value;
  }
  if (const auto* w = std::get_if<Word>(&value)) {
    if (param.range) return refuse_range(param, *w, entry);
    entry.value = w->text;
    model_.params.push_back(entry);
    return value;
  }
  const auto* number = std::get_if<Field>(&value);
  if (!number) {
    if (!is_poison(value))
      mistakes_.error("E0306", param.value.span,
                      fmt::format("a parameter is a number or a word, not {}", describe(value)));
    return Poison{};
  }
  if (number->rank != 0 || !is_constant(*number)) {
    if (number->rank != 0)
      mistakes_.error("E0306", param.value.span,
                      fmt::format("a parameter is a number, not {}", describe(*number)));
    else
      operators_.check_finite(param.value.span, *number);
    return Poison{};
  }
  entry.value = number->scalar().value();
  if (!is_in_range(param, number->scalar().value(), entry)) return Poison{};
  model_.params.push_back(entry);
  return value;
}

namespace {

/// Of a value that is neither a number nor a word: `7 MPa` lacks the brackets.
std::string help_for_value(const std::string& text) {
  char* rest = nullptr;
  const double number = std::strtod(text.c_str(), &rest);
  const std::string first = text.substr(0, static_cast<std::size_t>(rest - text.c_str()));
  while (*rest == ' ') ++rest;
  if (!first.empty() && std::isfinite(number) && std::isalpha(static_cast<unsigned char>(*rest)))
    return fmt::format("a unit stands in brackets: {}[{}]", first, rest);
  return "write a number or one of the words P1, P2, ...";
}

} // namespace

/// What a parameter is set to from outside.
Value Parameters::defined_value(const ast::Param& param) {
  const std::string& text = options_.defines.at(param.name.text);
  if (is_word(text)) return Word{text};
  if (const auto number = parse_number(text)) return scalar_field(*number);
  mistakes_.error(
      "E0321", Span{},
      fmt::format("{}{}={}: `{}` is no number", options_.words.define, param.name.text, text, text),
      help_for_value(text));
  return Poison{};
}

/// Words are in no range.
Value Parameters::refuse_range(const ast::Param& param, const Word& word, const ModelParam& entry) {
  const std::string what =
      fmt::format("`{}` is the word `{}`: a range is of numbers", param.name.text, word.text);
  if (entry.overridden)
    mistakes_.error(
        "E0306", param.name.span, what, "",
        fmt::format("set by {}{}={}", options_.words.define, param.name.text, word.text));
  else
    mistakes_.error("E0306", param.range->span, what, "leave the range out");
  return Poison{};
}

/// Does the value lie where the script says (else reported)? A wrong range is reported, and none.
bool Parameters::is_in_range(const ast::Param& param, double v, ModelParam& entry) {
  if (!param.range) return true;
  const auto bounds = evaluator_.constant_list(*param.range, "the range of a parameter");
  if (!bounds || mistakes_.has_error_in(param.range->span)) return true;
  if (bounds->size() != 2 || (*bounds)[0] > (*bounds)[1]) {
    mistakes_.error("E0408", param.range->span, "the range of a parameter is `[least, greatest]`");
    return true;
  }
  const double least = (*bounds)[0], greatest = (*bounds)[1];
  entry.range = fmt::format("[{}, {}]", least, greatest);
  if (v >= least && v <= greatest) return true;
  // As they stand in the script: in the parameter's unit.
  const auto* own = std::get_if<ast::Quantity>(&param.value.node);
  const auto known = own ? options_.units.find(own->unit.text) : options_.units.end();
  const UnitFactor factor = known == options_.units.end() ? UnitFactor{} : known->second;
  const auto shown = [&](double x) { return x * factor.over / factor.times; };
  mistakes_.error(
      "E0408", entry.overridden ? param.name.span : param.value.span,
      fmt::format("`{}` = {} is outside its range [{}, {}]{}", param.name.text, shown(v),
                  shown(least), shown(greatest), own ? " [" + own->unit.text + "]" : ""),
      "",
      entry.overridden
          ? fmt::format("set by {}{}={}", options_.words.define, param.name.text,
                        own ? fmt::to_string(shown(v)) : options_.defines.at(param.name.text))
          : "");
  return false;
}

} // namespace hvi::lang
