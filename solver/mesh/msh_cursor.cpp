// Numbers out of the bytes of an MSH file.
#include "solver/mesh/msh_cursor.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace hvi::solver {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Bytes of the file made fit for a message.
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
  return text.empty() ? "the end of the file" : "`" + out + "`";
}

} // namespace

std::string MshCursor::where() const {
  if (binary_) return fmt::format("{}: byte {}", name_, pos_);
  const auto lines =
      std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(pos_), '\n');
  return fmt::format("{}: line {}", name_, lines + 1);
}

void MshCursor::fail(const std::string& what) const {
  throw Failure(FailureKind::broken_file, {}, fmt::format("{}: {}", where(), what));
}

void MshCursor::skip_space() {
  while (pos_ < bytes_.size() && is_space(bytes_[pos_])) ++pos_;
}

bool MshCursor::at_end() {
  skip_space();
  return pos_ == bytes_.size();
}

std::string_view MshCursor::word() {
  skip_space();
  std::size_t end = pos_;
  while (end < bytes_.size() && !is_space(bytes_[end])) ++end;
  const auto found = bytes_.substr(pos_, end - pos_);
  pos_ = end;
  return found;
}

std::string_view MshCursor::quoted(const char* what) {
  skip_space();
  const auto end = pos_ < bytes_.size() ? bytes_.find_first_of("\"\n", pos_ + 1) : bytes_.npos;
  if (end == bytes_.npos || bytes_[pos_] != '"' || bytes_[end] != '"')
    fail(fmt::format("expected {} in quotes", what));
  const auto found = bytes_.substr(pos_ + 1, end - pos_ - 1);
  pos_ = end + 1;
  return found;
}

void MshCursor::expect(std::string_view wanted) {
  skip_space();
  const std::size_t before = pos_;
  const auto found = word();
  if (found == wanted) return;
  pos_ = before;
  fail(fmt::format("expected {}, found {}", wanted, shown(found)));
}

void MshCursor::end_line() {
  while (pos_ < bytes_.size() && bytes_[pos_] != '\n' && is_space(bytes_[pos_])) ++pos_;
  if (pos_ == bytes_.size() || bytes_[pos_] != '\n') fail("expected the end of the line");
  ++pos_;
}

void MshCursor::skip_to(std::string_view wanted) {
  const auto at = bytes_.find(wanted, pos_);
  if (at == bytes_.npos) fail(fmt::format("expected {} somewhere below", wanted));
  pos_ = at + wanted.size();
}

template <typename T>
T MshCursor::raw(const char* what) {
  if (bytes_.size() - pos_ < sizeof(T)) fail(fmt::format("the file ends where {} should be", what));
  std::array<char, sizeof(T)> b;
  std::memcpy(b.data(), bytes_.data() + pos_, sizeof(T));
  if (swap_) std::reverse(b.begin(), b.end());
  T value;
  std::memcpy(&value, b.data(), sizeof(T));
  pos_ += sizeof(T);
  return value;
}

template <typename T>
T MshCursor::parsed(const char* what, const char* kind) {
  skip_space();
  T value{};
  const char* const end = bytes_.data() + bytes_.size();
  const auto [stop, error] = std::from_chars(bytes_.data() + pos_, end, value);
  if (error != std::errc{} || (stop != end && !is_space(*stop))) {
    const std::size_t before = pos_;
    const auto found = word();
    pos_ = before;
    fail(fmt::format("expected {} ({}), found {}", what, kind, shown(found)));
  }
  pos_ = static_cast<std::size_t>(stop - bytes_.data());
  return value;
}

std::int64_t MshCursor::text_integer(const char* what) {
  return parsed<std::int64_t>(what, "an integer");
}

double MshCursor::text_real(const char* what) { return parsed<double>(what, "a number"); }

std::int32_t MshCursor::binary_integer(const char* what) { return raw<std::int32_t>(what); }

std::int64_t MshCursor::integer(const char* what) {
  if (binary_) return raw<std::int32_t>(what);
  const std::int64_t value = text_integer(what);
  if (value != static_cast<std::int32_t>(value))
    fail(fmt::format("{} is {}, which is too large", what, value));
  return value;
}

std::int64_t MshCursor::size(const char* what) {
  return binary_ ? raw<std::int64_t>(what) : text_integer(what);
}

double MshCursor::real(const char* what) {
  const double value = binary_ ? raw<double>(what) : text_real(what);
  if (!std::isfinite(value)) fail(fmt::format("{} is {}, not a finite number", what, value));
  return value;
}

std::size_t MshCursor::count(std::int64_t value, std::size_t ascii, std::size_t binary,
                             const char* what) const {
  const std::size_t room = (bytes_.size() - pos_) / (binary_ ? binary : ascii);
  if (value < 0 || static_cast<std::uint64_t>(value) > room)
    fail(fmt::format("{} is {}, but there is room for at most {} in the rest of the file", what,
                     value, room));
  return static_cast<std::size_t>(value);
}

} // namespace hvi::solver
