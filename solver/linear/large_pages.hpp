// Memory for the streams of triangular solves: in large pages where the system has them, so that
// neither the first touch of a hundred megabytes nor their address translation takes longer than
// reading them.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace hvi::solver {

constexpr std::size_t large_page = std::size_t{2} << 20;

/// Asks for large pages where [start, start + bytes) spans whole ones; what they hold stays. Does
/// nothing on systems that know no such advice.
inline void advise_large_pages([[maybe_unused]] void* start, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  auto* const first = static_cast<char*>(start);
  const std::size_t skip = -reinterpret_cast<std::size_t>(first) % large_page;
  if (bytes < skip + large_page) return;
  madvise(first + skip, (bytes - skip) / large_page * large_page, MADV_HUGEPAGE);
#endif
}

/// The system takes the whole large pages of [start, start + bytes) back; what they hold is lost,
/// and they can be written again. Does nothing on systems that know no such advice.
inline void give_back_pages([[maybe_unused]] void* start, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  auto* const first = static_cast<char*>(start);
  const std::size_t skip = -reinterpret_cast<std::size_t>(first) % large_page;
  if (bytes < skip + large_page) return;
  madvise(first + skip, (bytes - skip) / large_page * large_page, MADV_DONTNEED);
#endif
}

/// Large allocations begin at a large page, small ones at a cache line. Elements are left as they
/// are by `resize`: what is written once need not be cleared first.
template <class T>
struct LargePages {
  using value_type = T;
  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) {}

  T* allocate(std::size_t count) {
    constexpr auto most = static_cast<std::size_t>(std::numeric_limits<std::ptrdiff_t>::max());
    if (count > (most - large_page) / sizeof(T)) throw std::bad_alloc();
    const std::size_t unit = count * sizeof(T) < large_page ? 64 : large_page;
    const std::size_t bytes = (count * sizeof(T) + unit - 1) / unit * unit;
    void* const out = std::aligned_alloc(unit, bytes);
    if (out == nullptr) throw std::bad_alloc();
    if (unit == large_page) advise_large_pages(out, bytes);
    return static_cast<T*>(out);
  }
  void deallocate(T* p, std::size_t) { std::free(p); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U; // no value
  }
  template <class U, class... Arguments>
  void construct(U* p, Arguments&&... arguments) {
    ::new (static_cast<void*>(p)) U(std::forward<Arguments>(arguments)...);
  }
  friend bool operator==(const LargePages&, const LargePages&) { return true; }
};

template <class T>
using LargeVector = std::vector<T, LargePages<T>>;

} // namespace hvi::solver
