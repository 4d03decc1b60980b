// Numbers inside an HTML file: deflated, base64, each block an element with an id.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace hvi::lang {

class Blocks {
public:
  /// Adds numbers as 32-bit floats or integers, little-endian; the id of their element.
  std::string add(std::span<const double> values);
  std::string add_integers(std::span<const std::uint32_t> values);
  const std::string& html() const { return html_; }

private:
  std::string put(std::span<const std::byte> bytes);

  std::string html_;
  int count_ = 0;
};

} // namespace hvi::lang
