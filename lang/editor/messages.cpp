// See messages.hpp.
#include "lang/editor/messages.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>

namespace hvi::lang {

namespace {

constexpr std::size_t largest_message = std::size_t{64} << 20;
constexpr std::string_view length_field = "content-length:";

bool same_field(std::string_view line) {
  if (line.size() < length_field.size()) return false;
  for (std::size_t i = 0; i < length_field.size(); ++i)
    if (std::tolower(static_cast<unsigned char>(line[i])) != length_field[i]) return false;
  return true;
}

/// The length that a header states.
std::optional<std::size_t> length_in(std::string_view header) {
  while (!header.empty()) {
    const auto end = header.find("\r\n");
    std::string_view line = header.substr(0, end);
    header.remove_prefix(end == std::string_view::npos ? header.size() : end + 2);
    if (!same_field(line)) continue;
    line.remove_prefix(length_field.size());
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    std::size_t length = 0;
    const auto read = std::from_chars(line.data(), line.data() + line.size(), length);
    if (read.ec != std::errc{} || length > largest_message) return std::nullopt;
    return length;
  }
  return std::nullopt;
}

} // namespace

bool MessageReader::fill() {
  std::array<char, 65536> part{};
  while (true) {
    const auto n = ::read(input_, part.data(), part.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    buffer_.append(part.data(), static_cast<std::size_t>(n));
    return true;
  }
}

std::optional<std::size_t> MessageReader::take_header() {
  constexpr std::string_view end_of_header = "\r\n\r\n";
  std::size_t end = buffer_.find(end_of_header);
  while (end == std::string::npos) {
    if (buffer_.size() > 4096 || !fill()) return std::nullopt;
    end = buffer_.find(end_of_header);
  }
  const auto length = length_in(std::string_view(buffer_).substr(0, end));
  buffer_.erase(0, end + end_of_header.size());
  return length;
}

std::optional<std::string> MessageReader::next() {
  const auto length = take_header();
  if (!length) return std::nullopt;
  while (buffer_.size() < *length)
    if (!fill()) return std::nullopt;
  std::string content = buffer_.substr(0, *length);
  buffer_.erase(0, *length);
  return content;
}

bool MessageReader::more_waits() const {
  if (!buffer_.empty()) return true;
  pollfd one{input_, POLLIN, 0};
  return ::poll(&one, 1, 0) > 0 && (one.revents & POLLIN) != 0;
}

bool MessageReader::comes_before(const Bell& bell) const {
  if (!buffer_.empty()) return true;
  std::array<pollfd, 2> both{{{input_, POLLIN, 0}, {bell.to_wait_for(), POLLIN, 0}}};
  while (::poll(both.data(), both.size(), -1) < 0 && errno == EINTR) {
  }
  return both[0].revents != 0 || both[1].revents == 0;
}

Bell::Bell() {
  if (::pipe2(ends_.data(), O_CLOEXEC | O_NONBLOCK) != 0) ends_ = {-1, -1}; // poll passes over it
}

Bell::~Bell() {
  for (const int end : ends_)
    if (end >= 0) ::close(end);
}

void Bell::ring() const {
  const char one = 0;
  [[maybe_unused]] const auto n = ::write(ends_[1], &one, 1); // full: it rings
}

void Bell::silence() const {
  std::array<char, 64> rung{};
  while (::read(ends_[0], rung.data(), rung.size()) > 0) {
  }
}

bool write_message(int output, const nlohmann::json& message) {
  // Texts may be cut within a character by an editor that is wrong: such bytes are replaced.
  const std::string content =
      message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const std::string all = fmt::format("Content-Length: {}\r\n\r\n{}", content.size(), content);
  for (std::size_t sent = 0; sent < all.size();) {
    const auto n = ::write(output, all.data() + sent, all.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

} // namespace hvi::lang
