// The entry points of libhvi_petsc.so.
#include "solver/linear/petsc/bridge.h"

#include "solver/linear/petsc/krylov.hpp"

#include <algorithm>
#include <cstring>
#include <new>

struct HviPetscSolver : hvi::petsc_module::Krylov {
  using Krylov::Krylov;
};

namespace hvi::petsc_module {
namespace {

int report(const char* text, char* message, std::size_t capacity) {
  if (capacity == 0) return 1;
  const std::size_t n = std::min(std::strlen(text), capacity - 1);
  std::memcpy(message, text, n);
  message[n] = '\0';
  return 1;
}

/// No exception leaves the module.
template <class F>
int guarded(F&& f, char* message, std::size_t capacity) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    return hvi_petsc_no_memory;
  } catch (const std::exception& e) {
    return report(e.what(), message, capacity);
  } catch (...) {
    return report("an unknown error in PETSc", message, capacity);
  }
}

} // namespace
} // namespace hvi::petsc_module

extern "C" {
int hvi_petsc_open(const HviPetscMatrix* k, int symmetric, const HviPetscUnknowns* unknowns,
                   HviPetscSolver** solver, char* message, std::size_t capacity) {
  return hvi::petsc_module::guarded(
      [&] {
        hvi::petsc_module::start();
        *solver = new HviPetscSolver(*k, symmetric != 0, *unknowns);
        return 0;
      },
      message, capacity);
}

int hvi_petsc_changed(HviPetscSolver* solver, char* message, std::size_t capacity) {
  return hvi::petsc_module::guarded([&] { return solver->matrix_changed(), 0; }, message, capacity);
}

int hvi_petsc_free(HviPetscSolver* solver, const double* motions, int count, char* message,
                   std::size_t capacity) {
  return hvi::petsc_module::guarded([&] { return solver->set_free_motions(motions, count), 0; },
                                    message, capacity);
}

int hvi_petsc_laws(HviPetscSolver* solver, const HviPetscMatrix* h, int symmetric, char* message,
                   std::size_t capacity) {
  return hvi::petsc_module::guarded(
      [&] { return solver->set_laws(*h, symmetric != 0) ? 0 : hvi_petsc_no_factor; }, message,
      capacity);
}

int hvi_petsc_solve(HviPetscSolver* solver, const double* b, double reduction, double* x,
                    HviPetscAnswer* answer, char* message, std::size_t capacity) {
  return hvi::petsc_module::guarded([&] { return *answer = solver->solve(b, reduction, x), 0; },
                                    message, capacity);
}

void hvi_petsc_count(const HviPetscSolver* solver, HviPetscCounts* counts) {
  *counts = solver->counts();
}

void hvi_petsc_close(HviPetscSolver* solver) { delete solver; }
}
