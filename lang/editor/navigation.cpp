// See navigation.hpp.
#include "lang/editor/navigation.hpp"

#include "lang/check/builtins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace hvi::lang {

namespace {

/// The declared name at the place; null for none.
const Definition* declared_at(const EditorPlace& place) {
  const NameUse* const use = place.analysis.names.at(0, place.offset);
  return use ? &place.analysis.names.definitions[use->definition] : nullptr;
}

template <class Each>
void for_each_use(const EditorPlace& place, const Each& each) {
  const NameIndex& names = place.analysis.names;
  const NameUse* const here = names.at(0, place.offset);
  if (!here) return;
  for (const NameUse& use : names.uses)
    if (use.definition == here->definition) each(use);
}

bool is_name(const std::string& text) {
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  return !text.empty() && letter(text[0]) && std::ranges::all_of(text, [&](char c) {
    return letter(c) || c == '_' || std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
}

/// A name of a file that the user may change: not of the standard library.
bool is_own(const EditorPlace& place, const Definition& d) {
  const auto& programs = place.analysis.script().programs;
  return !programs[static_cast<std::size_t>(d.span.file)].library;
}

/// Where the name stands the other one has another meaning: null, or what it is there.
const Definition* in_the_way(const EditorPlace& place, const std::string& name) {
  const Definition* out = nullptr;
  for_each_use(place, [&](const NameUse& use) {
    if (!out) out = place.analysis.names.visible(name, use.span);
  });
  return out;
}

/// Why a name cannot be given; empty where it can.
std::string why_not(const EditorPlace& place, const Definition& d, const std::string& name) {
  if (!is_own(place, d)) return fmt::format("`{}` is a name of the standard library", d.name);
  if (!is_name(name))
    return fmt::format("`{}` is no name: letters, digits and _, the first a letter", name);
  if (reserved_word(name) || is_reserved_builtin(name))
    return fmt::format("`{}` is a word of the language", name);
  if (name == d.name) return {};
  if (const Definition* other = in_the_way(place, name))
    return other->kind == NameKind::argument
               ? fmt::format("`{}` is an argument of `{}`, where `{}` stands", name, other->owner,
                             d.name)
               : fmt::format("there is a `{}` already", name);
  if (d.kind != NameKind::column && place.analysis.names.words.contains(name))
    return fmt::format("`{}` stands in the script for something else", name);
  return {};
}

} // namespace

Json definition(const EditorPlace& place) {
  const Definition* const d = declared_at(place);
  return d ? place.location(d->span) : Json(nullptr);
}

Json references(const EditorPlace& place, bool with_declaration) {
  Json out = Json::array();
  const Definition* const d = declared_at(place);
  for_each_use(place, [&](const NameUse& use) {
    if (use.span == d->span && !with_declaration) return;
    if (Json location = place.location(use.span); !location.is_null()) out.push_back(location);
  });
  return out;
}

Json highlights(const EditorPlace& place) {
  Json out = Json::array();
  for_each_use(place, [&](const NameUse& use) {
    if (use.span.file == 0) out.push_back({{"range", place.range(use.span)}});
  });
  return out;
}

Json renamed_range(const EditorPlace& place) {
  const NameUse* const use = place.analysis.names.at(0, place.offset);
  if (!use || !is_own(place, place.analysis.names.definitions[use->definition])) return nullptr;
  return place.range(use->span);
}

Json rename(const EditorPlace& place, const std::string& name, std::string& error) {
  const Definition* const d = declared_at(place);
  error = d ? why_not(place, *d, name) : "there is no declared name here";
  if (!error.empty()) return nullptr;
  Json changes = Json::object();
  for_each_use(place, [&](const NameUse& use) {
    const auto path = path_of(place.analysis.script(), use.span.file);
    if (path)
      changes[uri_of(*path)].push_back({{"range", place.range(use.span)}, {"newText", name}});
  });
  return {{"changes", changes}};
}

} // namespace hvi::lang
