// See documents.hpp.
#include "lang/editor/documents.hpp"

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace {

EditorPosition position_in(const Json& json) {
  return {json.at("line").get<int>(), json.at("character").get<int>()};
}

void apply(std::string& text, const Json& edit, CharacterUnit unit) {
  std::string replacement = edit.at("text").get<std::string>();
  if (!edit.contains("range")) {
    text = std::move(replacement);
    return;
  }
  const SourceFile file(0, "", text);
  const Json& range = edit.at("range");
  const auto begin = offset_of(file, position_in(range.at("start")), unit);
  const auto end = std::max(begin, offset_of(file, position_in(range.at("end")), unit));
  text = std::string(file.text()).replace(begin, end - begin, replacement);
}

} // namespace

void Documents::open(const std::string& uri, std::string text, const Json& version) {
  open_[uri] = {std::move(text), version, nullptr, false};
}

void Documents::change(const std::string& uri, const Json& edits, const Json& version,
                       CharacterUnit unit) {
  const auto found = open_.find(uri);
  if (found == open_.end()) return;
  Document& document = found->second;
  for (const Json& edit : edits) apply(document.text, edit, unit);
  document.version = version;
  document.analysis.reset();
  document.published = false;
}

const Analysis* Documents::analysis(const std::string& uri) {
  const auto found = open_.find(uri);
  if (found == open_.end()) return nullptr;
  Document& document = found->second;
  if (!document.analysis) document.analysis = analyse(uri, document.text);
  return document.analysis->script().programs.empty() ? nullptr : document.analysis.get();
}

std::string Documents::text(const std::string& uri) const {
  const auto found = open_.find(uri);
  return found == open_.end() ? std::string() : found->second.text;
}

std::unique_ptr<Analysis> Documents::analyse(const std::string& uri, std::string text) const {
  return std::make_unique<Analysis>(path_of(uri).value_or("untitled.hvi"), settings_,
                                    std::move(text));
}

void Documents::publish_again(const std::string& path) {
  for (auto& [uri, document] : open_)
    if (path_of(uri) == path) document.published = false;
}

void Documents::for_each_unpublished(
    const std::function<void(const std::string& uri, const Json& version)>& publish) {
  for (auto& [uri, document] : open_)
    if (!std::exchange(document.published, true)) publish(uri, document.version);
}

} // namespace hvi::lang
