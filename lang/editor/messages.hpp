// Messages of the Language Server Protocol over a pair of streams: a header with the length, then
// JSON (Microsoft, Language Server Protocol 3.17, "Base Protocol").
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>

namespace hvi::lang {

/// Reads from a file descriptor.
class MessageReader {
public:
  explicit MessageReader(int input) : input_(input) {}

  /// The content of the next message; waits for it. Nothing at the end of the input, and where the
  /// header is none or announces more than 64 MiB.
  std::optional<std::string> next();
  /// Whether a part of another message has arrived: what is asked may be out of date.
  [[nodiscard]] bool more_waits() const;

private:
  bool fill();
  std::optional<std::size_t> take_header();

  int input_;
  std::string buffer_;
};

/// Writes one message to a file descriptor; false when nobody reads any more.
bool write_message(int output, const nlohmann::json& message);

} // namespace hvi::lang
