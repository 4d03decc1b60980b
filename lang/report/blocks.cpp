// See blocks.hpp.
#include "lang/report/blocks.hpp"

#include "solver/common/out_of_memory.hpp"
#include "solver/output/encode.hpp"

#include <fmt/format.h>

#include <zlib.h>

#include <bit>
#include <vector>

namespace hvi::lang {

static_assert(std::endian::native == std::endian::little);

std::string Blocks::add(std::span<const double> values) {
  const std::vector<float> shorter(values.begin(), values.end());
  return put(std::as_bytes(std::span(shorter)));
}

std::string Blocks::add_integers(std::span<const std::uint32_t> values) {
  return put(std::as_bytes(values));
}

std::string Blocks::put(std::span<const std::byte> bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::byte> packed(size);
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()),
                Z_BEST_SPEED) != Z_OK)
    throw solver::OutOfMemory("no memory to compress a block of a report");
  packed.resize(size);
  std::string id = fmt::format("b{}", count_++);
  html_ += fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", id,
                       solver::base64(packed));
  return id;
}

} // namespace hvi::lang
