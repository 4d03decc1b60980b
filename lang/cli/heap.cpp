// See heap.hpp. Of the GNU C library; any other keeps its own ways.
#include "lang/cli/heap.hpp"

#include "solver/linear/large_pages.hpp"

#include <cstdlib> // says whether this is the GNU C library

#ifdef __GLIBC__
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace hvi::lang {

#ifdef __GLIBC__
namespace {

constexpr int usual_growth = 1 << 20; ///< bytes beyond those that are asked for
/// Addresses of the heap that are taken at once; pages of them are taken when they are touched.
constexpr int first_growth = 192 << 20;

bool unlimited(__rlimit_resource resource) {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
}

/// The first touch of a page costs the kernel a microsecond; a run of a tenth of a second touches
/// ten thousand of them. Only addresses that the heap has already can be given large pages, so it
/// grows first. Where addresses are limited, the run may need them for something else.
void ask_for_large_pages() {
  if (!unlimited(RLIMIT_AS) || !unlimited(RLIMIT_DATA)) return;
  auto* const start = static_cast<char*>(sbrk(0));
  mallopt(M_TOP_PAD, first_growth);
  void* volatile grown = std::malloc(usual_growth); // volatile: else the compiler leaves out both
  std::free(grown);
  mallopt(M_TOP_PAD, usual_growth);
  auto* const end = static_cast<char*>(sbrk(0));
  if (end > start) solver::advise_large_pages(start, static_cast<std::size_t>(end - start));
}

} // namespace

void prepare_heap() {
  mallopt(M_MMAP_THRESHOLD, 64 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, usual_growth);
  mallopt(M_MXFAST, 0); // else each of thousands of freed OpenMP teams joins all free blocks
  ask_for_large_pages();
}
#else
void prepare_heap() {}
#endif

} // namespace hvi::lang
