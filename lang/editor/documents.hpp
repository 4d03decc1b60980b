// The scripts that an editor has open.
#pragma once

#include "lang/editor/protocol.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace hvi::lang {

class Documents {
public:
  explicit Documents(CompileSettings settings) : settings_(std::move(settings)) {}

  void open(const std::string& uri, std::string text, const Json& version);
  /// The edits of a didChange, one after the other: a range and its text, or all of the text.
  void change(const std::string& uri, const Json& edits, const Json& version, CharacterUnit unit);
  void close(const std::string& uri) { open_.erase(uri); }

  /// The analysis of a script that is open, made anew if it has changed; null for others.
  const Analysis* analysis(const std::string& uri);
  [[nodiscard]] std::string text(const std::string& uri) const;
  [[nodiscard]] std::unique_ptr<Analysis> analyse(const std::string& uri, std::string text) const;

  /// There is more to tell of this script.
  void publish_again(const std::string& path);
  /// Of each script whose diagnostics the editor does not have yet.
  void for_each_unpublished(
      const std::function<void(const std::string& uri, const Json& version)>& publish);

private:
  struct Document {
    std::string text;
    Json version;
    std::unique_ptr<Analysis> analysis;
    bool published = false;
  };

  CompileSettings settings_;
  std::map<std::string, Document> open_; ///< by URI
};

} // namespace hvi::lang
