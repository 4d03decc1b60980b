/* The C interface between hvi-run and the module libhvi_mumps.so, which is the only code that links MUMPS. */
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {

/* The lower triangle of a symmetric matrix by its entries, each once, numbered from 0. */
struct HviMumpsPattern {
  int n;
  std::size_t entries;
  const int* row;
  const int* column;
  const int* position; /* of each unknown in the order of elimination, from 0; the last ones behind */
  int n_last; /* so many unknowns are not eliminated */
  const int* last;
};
struct HviMumpsCounts {
  double nonzeros, flops, bytes;
};

constexpr int hvi_mumps_ok = 0, hvi_mumps_singular = 1, hvi_mumps_no_memory = 2, hvi_mumps_failed = 3;

/* All but `close` return one of these. `solver` is closed by the caller whatever was returned. */
using HviMumpsOpen = int (*)(const HviMumpsPattern* pattern, void** solver, HviMumpsCounts* expected);
/* L D L^T with pivots of one or two rows; a pivot below `least` makes the matrix singular. `schur`:
   n_last x n_last numbers, what elimination leaves. */
using HviMumpsFactor = int (*)(void* solver, const double* value, double least, double* schur,
                               HviMumpsCounts* counts);
/* In place, of n numbers: the unknowns that are eliminated, for the others 0. */
using HviMumpsSolve = int (*)(void* solver, double* x);
using HviMumpsClose = void (*)(void* solver);
}
