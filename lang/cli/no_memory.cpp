// malloc and its relatives for hvi-run, by those of libc; where there is no memory left, the run
// ends with one message and the exit code that main.cpp has for it.
//
// An exception would not do. Eigen 3.4 frees a dense matrix before it asks for memory of another
// size and leaves the old address where that fails, so that the matrix is freed twice on the way
// out; JSON trees allocate as they are destroyed; functions of CLI11 that allocate are noexcept;
// libc aborts where it cannot note the destructor of a thread's variable; static objects allocate
// before `main`. What a run has written before is whole, and the next run removes the rest, as
// after a kill.
#include "lang/cli/no_memory.hpp"

#include "lang/diag/failures.hpp"

#include <unistd.h>

#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cstddef>

#ifdef __GLIBC__

extern "C" { // what libc's own functions of memory are called beside their standard names
void* __libc_malloc(std::size_t size);                          // NOLINT: not our name
void* __libc_calloc(std::size_t count, std::size_t size);       // NOLINT
void* __libc_realloc(void* old, std::size_t size);              // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size); // NOLINT
}

namespace {

std::atomic_flag told = ATOMIC_FLAG_INIT;

[[noreturn]] void end(double bytes) {
  if (told.test_and_set()) // another thread is at it
    for (;;) ::pause();
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "out of memory: %.3g bytes more are not available",
                bytes);
  hvi::lang::tell_no_memory(text.data());
  std::fflush(stdout); // what was printed before is a result
  ::_exit(hvi::lang::ending_of(hvi::solver::FailureKind::too_large).exit);
}

void* had(void* memory, double bytes) {
  if (memory == nullptr) [[unlikely]]
    end(bytes);
  return memory;
}

} // namespace

extern "C" {

void* malloc(std::size_t size) noexcept {
  return had(__libc_malloc(size), static_cast<double>(size));
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  return had(__libc_calloc(count, size), static_cast<double>(count) * static_cast<double>(size));
}
void* realloc(void* old, std::size_t size) noexcept {
  void* const out = __libc_realloc(old, size);
  return size == 0 ? out : had(out, static_cast<double>(size));
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  return had(__libc_memalign(alignment, size), static_cast<double>(size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  if (!std::has_single_bit(alignment) || alignment % sizeof(void*) != 0) return EINVAL;
  *out = memalign(alignment, size);
  return 0;
}
}

#endif
