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
  /* Where rows are dealt out already: of each node its place in the order of the processes, and of
     each process how many it has. Null: they are not. */
  const int *place, *counts;
};

/* Rows of K that each process has for itself, in the numbering of all components of all nodes, and
   those of the first one. Their arrays are read while a call lasts. */
struct HviPetscDealt {
  unsigned long long set;
  int matrix;
  HviPetscMatrix mine;
};

constexpr int hvi_petsc_solved = 0, hvi_petsc_indefinite = 1, hvi_petsc_stagnated = 2,
              hvi_petsc_stopped = 3;

/* Asked by the first process after iterations, where it is alone after every one; not 0: the solve ends, in all processes. */
struct HviPetscWatch {
  void* context;
  int (*stop)(void* context);
};

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

/* What a process does for the first one besides iterations. */
struct HviPetscHelper {
  void* context;
  /* The answer to a message, until the next call; no bytes: there is no memory. */
  HviPetscBytes (*answer)(void* context, int errand, HviPetscBytes message);
  /* Its rows of a matrix, until the next call. */
  HviPetscMatrix (*rows)(void* context, unsigned long long set, int matrix);
};

struct HviPetscSolver;

/* All return 0, or 1 after writing a message of at most `capacity` bytes to `message`, or one of
   these. */
constexpr int hvi_petsc_no_memory = 2, hvi_petsc_no_factor = 3;

/* K whole; or dealt out, where k has the number of its rows only. */
using HviPetscOpen = int (*)(const HviPetscMatrix* k, const HviPetscDealt* dealt, int symmetric,
                             const HviPetscUnknowns* unknowns, HviPetscSolver** solver,
                             char* message, std::size_t capacity);
/* `mine`: the rows of the first process, where K is dealt out; else null. */
using HviPetscChanged = int (*)(HviPetscSolver* solver, const HviPetscMatrix* mine, char* message,
                                std::size_t capacity);
/* A column for each motion that the laws alone hold; the matrix all but takes them to 0. */
using HviPetscFree = int (*)(HviPetscSolver* solver, const double* motions, int count,
                             char* message, std::size_t capacity);
using HviPetscLaws = int (*)(HviPetscSolver* solver, const HviPetscMatrix* h, int symmetric,
                             char* message, std::size_t capacity);
using HviPetscSolve = int (*)(HviPetscSolver* solver, const double* b, double reduction,
                              const HviPetscWatch* watch, double* x, HviPetscAnswer* answer,
                              char* message, std::size_t capacity);
using HviPetscCount = void (*)(const HviPetscSolver* solver, HviPetscCounts* counts);
using HviPetscClose = void (*)(HviPetscSolver* solver);

/* Several processes. The first of the `processes` that a launcher started leads, before it opens a
   solver, and dismisses the others at its end; each of them serves, and returns the exit code it
   was dismissed with. Where nobody leads, a process is alone. */
using HviPetscLead = int (*)(int processes, char* message, std::size_t capacity);
/* How many processes work together; 1 where nobody leads. */
using HviPetscProcesses = int (*)();
using HviPetscServe = int (*)(int processes, const HviPetscHelper* helper);
/* Of the first process: a message for each of the others, which their helpers answer, while `own`
   does the work of the first one. The answers live until the next call. */
using HviPetscDealOut = int (*)(int errand, const HviPetscBytes* messages, void (*own)(void*),
                                void* context, HviPetscBytes* answers, char* message,
                                std::size_t capacity);
/* Returns how many solvers were opened. */
using HviPetscDismiss = int (*)(int exit_code);
}
