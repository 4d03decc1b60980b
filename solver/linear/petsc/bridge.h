/* The C interface between hvi-run and the module libhvi_petsc.so, which is the only code that links
   PETSc and MPI. Arrays belong to the caller, and stay where they are while a solver lives. */
#pragma once

#include <cstddef>

extern "C" {

/* Rows of entries in ascending columns. */
struct HviPetscMatrix {
  int rows;
  const int* start;
  const int* column;
  const double* value;
};

struct HviPetscUnknowns {
  const int* node;
  const int* component;
  int nodes, components;
  const int* first_component; /* of each of several unknowns u, theta, ... */
  int unknowns;
  const double* motions; /* rows numbers for each, one after the other */
  int n_motions;
};

constexpr int hvi_petsc_solved = 0, hvi_petsc_indefinite = 1, hvi_petsc_stagnated = 2;

struct HviPetscAnswer {
  int outcome, iterations;
  double reduction;
  const char* reason; /* words that live as long as the module */
};

struct HviPetscLevel {
  double rows, entries;
};

struct HviPetscCounts {
  int setups, local_factors;
  double bytes, seconds_setup;
  double bytes_of_others; /* the most that another process has held */
  /* Of the iterations, by the process that sent most. */
  double messages, bytes_sent, reductions;
  int levels; /* of the multigrid, the finest one first; of several unknowns, the sum at each */
  const HviPetscLevel* level; /* until the next call */
};

struct HviPetscBytes {
  const char* bytes;
  std::size_t size;
};

/* The answer to a message, until the next call; no bytes: there is no memory. */
using HviPetscTask = HviPetscBytes (*)(void* context, HviPetscBytes message);

struct HviPetscSolver;

/* All return 0, or 1 after writing a message of at most `capacity` bytes to `message`, or one of
   these. */
constexpr int hvi_petsc_no_memory = 2, hvi_petsc_no_factor = 3;

using HviPetscOpen = int (*)(const HviPetscMatrix* k, int symmetric,
                             const HviPetscUnknowns* unknowns, HviPetscSolver** solver,
                             char* message, std::size_t capacity);
using HviPetscChanged = int (*)(HviPetscSolver* solver, char* message, std::size_t capacity);
/* A column for each motion that the laws alone hold; the matrix all but takes them to 0. */
using HviPetscFree = int (*)(HviPetscSolver* solver, const double* motions, int count,
                             char* message, std::size_t capacity);
using HviPetscLaws = int (*)(HviPetscSolver* solver, const HviPetscMatrix* h, int symmetric,
                             char* message, std::size_t capacity);
using HviPetscSolve = int (*)(HviPetscSolver* solver, const double* b, double reduction, double* x,
                              HviPetscAnswer* answer, char* message, std::size_t capacity);
using HviPetscCount = void (*)(const HviPetscSolver* solver, HviPetscCounts* counts);
using HviPetscClose = void (*)(HviPetscSolver* solver);

/* Several processes. The first of the `processes` that a launcher started leads, before it opens a
   solver, and dismisses the others at its end; each of them serves, and returns the exit code it
   was dismissed with. Where nobody leads, a process is alone. */
using HviPetscLead = int (*)(int processes, char* message, std::size_t capacity);
using HviPetscServe = int (*)(int processes, HviPetscTask task, void* context);
/* Of the first process: a message for each of the others, which they answer by `task`. The answers
   are taken in before any other call; they live until the next ones. */
using HviPetscHandOut = int (*)(const HviPetscBytes* messages, char* message,
                                std::size_t capacity);
using HviPetscTakeIn = int (*)(HviPetscBytes* answers, char* message, std::size_t capacity);
/* Returns how many solvers were opened. */
using HviPetscDismiss = int (*)(int exit_code);
}
