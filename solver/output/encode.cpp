// Base64 and zlib blocks as VTK writes them inside XML. Used by vtu.cpp only.
#include "solver/output/encode.hpp"

#include "solver/common/failure.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace hvi::solver {
namespace {

constexpr char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t block_size = 1 << 18;
// Doubles of a smooth field hardly shrink further at higher levels, which cost three times as much.
constexpr int level = 3;

std::vector<std::byte> compressed(std::span<const std::byte> bytes) {
  auto size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::byte> out(size);
  const int status = compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()),
                               static_cast<uLong>(bytes.size()), level);
  if (status != Z_OK)
    throw Failure(FailureKind::output, {}, "zlib could not compress an array of the output");
  out.resize(size);
  return out;
}

} // namespace

std::string base64(std::span<const std::byte> bytes) {
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t j = 0; j < 3; ++j)
      word = word << 8 | (j < count ? std::to_integer<std::uint32_t>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j)
      out += j <= count ? alphabet[word >> (18 - 6 * j) & 63u] : '=';
  }
  return out;
}

std::string vtk_compressed(std::span<const std::byte> bytes) {
  const std::size_t blocks = (bytes.size() + block_size - 1) / block_size;
  std::vector<std::uint64_t> header{blocks, block_size, bytes.size() % block_size};
  std::vector<std::byte> content;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto first = b * block_size;
    const auto block = compressed(bytes.subspan(first, std::min(block_size, bytes.size() - first)));
    header.push_back(block.size());
    content.insert(content.end(), block.begin(), block.end());
  }
  return base64(std::as_bytes(std::span(header))) + base64(content);
}

} // namespace hvi::solver
