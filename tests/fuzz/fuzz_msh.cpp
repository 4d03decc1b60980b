// libFuzzer target: any bytes either give a mesh or a Failure, nothing else.
#include "solver/common/failure.hpp"
#include "solver/mesh/read_msh.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto mesh =
        hvi::solver::parse_msh({reinterpret_cast<const char*>(data), size}, "fuzz.msh");
    hvi::solver::describe_mesh(mesh);
  } catch (const hvi::solver::Failure&) {
  }
  return 0;
}
