// Kernels of triangular solves and products are compiled once per instruction set and chosen at run
// time, so that one program runs on any processor.
#pragma once

#include <cstring>

#if !defined(__x86_64__) // other processors have the baseline only, in packs as wide as they are
#define HVI_HAS(small, large) false
#elif !defined(__clang__) && __has_include(<sys/platform/x86.h>)
#include <sys/platform/x86.h>
// The C library has asked the processor already; asking again traps in a virtual machine.
#define HVI_HAS(small, large) CPU_FEATURE_ACTIVE(large)
#else
#define HVI_HAS(small, large) __builtin_cpu_supports(small)
#endif

namespace hvi::solver {

enum class InstructionSet { baseline, avx2, avx512 };

/// The largest one that this processor has.
inline InstructionSet instruction_set() {
  if (HVI_HAS("avx512f", AVX512F)) return InstructionSet::avx512;
  if (HVI_HAS("avx2", AVX2) && HVI_HAS("fma", FMA)) return InstructionSet::avx2;
  return InstructionSet::baseline;
}
#undef HVI_HAS

// A kernel is inlined into functions that name the set it is compiled for.
#define HVI_INLINE __attribute__((always_inline)) inline
#if !defined(__x86_64__)
#define HVI_AVX2
#define HVI_AVX512
#elif defined(__clang__)
#define HVI_AVX2 __attribute__((target("avx2,fma")))
#define HVI_AVX512 __attribute__((target("avx512f,avx2,fma")))
#else // by itself GCC takes vectors of half the width
#define HVI_AVX2 __attribute__((target("avx2,fma")))
#define HVI_AVX512 __attribute__((target("avx512f,avx2,fma,prefer-vector-width=512")))
#endif

template <int Lanes>
struct PackOf {
  typedef double Double __attribute__((vector_size(Lanes * sizeof(double))));
  typedef float Single __attribute__((vector_size(Lanes * sizeof(float))));
};
/// So many doubles, added and multiplied at once.
template <int Lanes>
using Pack = typename PackOf<Lanes>::Double;

// By reference: packs by value would tie callers to one instruction set's calling convention.
template <int Lanes>
HVI_INLINE void load(const double* from, Pack<Lanes>& to) {
  std::memcpy(&to, from, sizeof to);
}
template <int Lanes>
HVI_INLINE void load(const float* from, Pack<Lanes>& to) {
  typename PackOf<Lanes>::Single single;
  std::memcpy(&single, from, sizeof single);
  to = __builtin_convertvector(single, Pack<Lanes>);
}

} // namespace hvi::solver
