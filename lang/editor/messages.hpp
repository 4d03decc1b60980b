// Messages of the Language Server Protocol over a pair of streams: a header with the length, then
// JSON (Microsoft, Language Server Protocol 3.17, "Base Protocol").
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <optional>
#include <string>

namespace hvi::lang {

/// What one thread rings and another one waits for.
class Bell {
public:
  Bell();
  ~Bell();
  Bell(const Bell&) = delete;
  Bell& operator=(const Bell&) = delete;

  void ring() const;
  void silence() const;
  [[nodiscard]] int to_wait_for() const { return ends_[0]; }

private:
  std::array<int, 2> ends_{-1, -1}; ///< of a pipe
};

/// Reads from a file descriptor.
class MessageReader {
public:
  explicit MessageReader(int input) : input_(input) {}

  /// The content of the next message; waits for it. Nothing at the end of the input, and where the
  /// header is none or announces more than 64 MiB.
  std::optional<std::string> next();
  /// Whether a part of another message has arrived: what is asked may be out of date.
  [[nodiscard]] bool more_waits() const;
  /// Waits for a message, or its end, unless `bell` rings first: false.
  [[nodiscard]] bool comes_before(const Bell& bell) const;

private:
  bool fill();
  std::optional<std::size_t> take_header();

  int input_;
  std::string buffer_;
};

/// Writes one message to a file descriptor; false when nobody reads any more.
bool write_message(int output, const nlohmann::json& message);

} // namespace hvi::lang
