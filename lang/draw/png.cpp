// See png.hpp.
#include "lang/draw/png.hpp"

#include "solver/common/out_of_memory.hpp"

#include <zlib.h>

#include <string_view>

namespace hvi::lang::draw {
namespace {

void put(std::string& out, std::uint32_t x, int bytes = 4) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
    out += static_cast<char>((x >> shift) & 0xff);
}

void chunk(std::string& out, std::string_view name, std::string_view data) {
  put(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  out += name;
  out += data;
  const auto* const bytes = reinterpret_cast<const Bytef*>(out.data() + begin);
  put(out, static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(out.size() - begin))));
}

/// What PNG's filter 2 leaves of a row: the difference to the one above. Smooth pictures shrink by
/// it.
std::string filtered(const Image& image) {
  const std::size_t row = 4 * static_cast<std::size_t>(image.width);
  std::string out;
  out.reserve((row + 1) * static_cast<std::size_t>(image.height));
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) {
    out += '\2';
    for (std::size_t i = 0; i < row; ++i) {
      const int above = y == 0 ? 0 : image.rgba[(y - 1) * row + i];
      out += static_cast<char>(image.rgba[y * row + i] - above);
    }
  }
  return out;
}

std::string compressed(const std::string& raw) {
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                reinterpret_cast<const Bytef*>(raw.data()), static_cast<uLong>(raw.size()),
                Z_DEFAULT_COMPRESSION) != Z_OK)
    throw solver::OutOfMemory("no memory to compress a picture");
  out.resize(size);
  return out;
}

std::string opened(const Image& image) {
  std::string out = "\x89PNG\r\n\x1a\n", head;
  put(head, static_cast<std::uint32_t>(image.width));
  put(head, static_cast<std::uint32_t>(image.height));
  head += std::string("\x08\x06\0\0\0", 5); // eight bits; red, green, blue, opacity
  chunk(out, "IHDR", head);
  return out;
}

/// The frame control chunk: size, place, how long, and that it covers all.
std::string control(std::uint32_t number, const Image& image, int milliseconds) {
  std::string out;
  put(out, number);
  put(out, static_cast<std::uint32_t>(image.width));
  put(out, static_cast<std::uint32_t>(image.height));
  put(out, 0);
  put(out, 0);
  put(out, static_cast<std::uint32_t>(milliseconds), 2);
  put(out, 1000, 2);
  put(out, 0, 2);
  return out;
}

} // namespace

std::string png_bytes(const Image& image) {
  std::string out = opened(image);
  chunk(out, "IDAT", compressed(filtered(image)));
  chunk(out, "IEND", {});
  return out;
}

std::string apng_bytes(std::size_t count, const std::function<Image(std::size_t)>& frame,
                       int milliseconds) {
  std::string out, animation;
  put(animation, static_cast<std::uint32_t>(count));
  put(animation, 0); // without end
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Image image = frame(i);
    if (i == 0) {
      out = opened(image);
      chunk(out, "acTL", animation);
    }
    chunk(out, "fcTL", control(number++, image, milliseconds));
    const std::string pixels = compressed(filtered(image));
    if (i == 0) {
      chunk(out, "IDAT", pixels);
      continue;
    }
    std::string numbered;
    put(numbered, number++);
    chunk(out, "fdAT", numbered + pixels);
  }
  chunk(out, "IEND", {});
  return out;
}

} // namespace hvi::lang::draw
