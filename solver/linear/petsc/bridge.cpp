// The entry points of libhvi_petsc.so.
#include "solver/linear/petsc/bridge.h"

#include "solver/linear/petsc/commands.hpp"
#include "solver/linear/petsc/krylov.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <string>
#include <vector>

struct HviPetscSolver {
  HviPetscSolver(int number_of_it, const HviPetscMatrix& k, const HviPetscMatrix* mine,
                 bool symmetric, const HviPetscUnknowns& unknowns)
      : number(number_of_it), krylov(k, mine, symmetric, unknowns) {}
  int number; ///< by which the other processes know it
  hvi::petsc_module::Krylov krylov;
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

/// PETSc and MPI keep things of the whole process: of several threads one calls at a time.
std::mutex& turn() {
  static std::mutex only;
  return only;
}

/// No exception leaves the module.
template <class F>
int guarded(F&& f, char* message, std::size_t capacity) {
  const std::scoped_lock lock(turn());
  try {
    return f();
  } catch (const std::bad_alloc&) {
    give_up();
    return hvi_petsc_no_memory;
  } catch (const std::exception& e) {
    give_up();
    return report(e.what(), message, capacity);
  } catch (...) {
    give_up();
    return report("an unknown error in PETSc", message, capacity);
  }
}

/// Have all the processes that the launcher started found each other?
bool complete(int expected) { return processes() == expected; }

int solvers = 0; // so far
std::vector<std::string> taken_in;

} // namespace
} // namespace hvi::petsc_module

using namespace hvi::petsc_module;

extern "C" {
int hvi_petsc_open(const HviPetscMatrix* k, const HviPetscDealt* dealt, int symmetric,
                   const HviPetscUnknowns* unknowns, HviPetscSolver** solver, char* message,
                   std::size_t capacity) {
  return guarded(
      [&] {
        start();
        const int number = ++solvers;
        Command command{Command::open, number, symmetric};
        if (dealt != nullptr) command.set = dealt->set, command.matrix = dealt->matrix;
        announce(command);
        *solver = new HviPetscSolver(number, *k, dealt != nullptr ? &dealt->mine : nullptr,
                                     symmetric != 0, *unknowns);
        return 0;
      },
      message, capacity);
}

int hvi_petsc_changed(HviPetscSolver* solver, const HviPetscMatrix* mine, char* message,
                      std::size_t capacity) {
  return guarded(
      [&] {
        announce({Command::changed, solver->number});
        solver->krylov.matrix_changed(mine);
        return 0;
      },
      message, capacity);
}

int hvi_petsc_free(HviPetscSolver* solver, const double* motions, int count, char* message,
                   std::size_t capacity) {
  return guarded(
      [&] {
        announce({Command::free, solver->number, count});
        solver->krylov.set_free_motions(motions, count);
        return 0;
      },
      message, capacity);
}

int hvi_petsc_laws(HviPetscSolver* solver, const HviPetscMatrix* h, int symmetric, char* message,
                   std::size_t capacity) {
  return guarded(
      [&] {
        announce({Command::laws, solver->number, symmetric});
        return solver->krylov.set_laws(*h, symmetric != 0) ? 0 : hvi_petsc_no_factor;
      },
      message, capacity);
}

int hvi_petsc_solve(HviPetscSolver* solver, const double* b, double reduction,
                    const HviPetscWatch* watch, double* x, HviPetscAnswer* answer, char* message,
                    std::size_t capacity) {
  return guarded(
      [&] {
        announce({Command::solve, solver->number, 0, reduction});
        *answer = solver->krylov.solve(b, reduction, watch, x);
        return 0;
      },
      message, capacity);
}

void hvi_petsc_count(const HviPetscSolver* solver, HviPetscCounts* counts) {
  const std::scoped_lock lock(turn());
  *counts = solver->krylov.counts();
}

void hvi_petsc_close(HviPetscSolver* solver) {
  if (solver == nullptr) return;
  const std::scoped_lock lock(turn());
  // Where the others wait in a call that failed, nothing that belongs to all can be freed.
  if (announced({Command::close, solver->number})) delete solver;
}

int hvi_petsc_lead(int expected, char* message, std::size_t capacity) {
  return guarded(
      [&] {
        start_together();
        std::atexit([] { dismiss(1); }); // where the program ends in another way
        if (complete(expected)) return 0;
        throw PetscFailure("the launcher has started " + std::to_string(expected) +
                           " processes, and MPI finds " + std::to_string(processes()));
      },
      message, capacity);
}

int hvi_petsc_processes() { return processes(); }

int hvi_petsc_serve(int expected, const HviPetscHelper* helper) {
  start_together();
  return complete(expected) ? serve(*helper) : 0; // the first one says what is wrong
}

int hvi_petsc_deal_out(int errand, const HviPetscBytes* messages, void (*own)(void*), void* context,
                       HviPetscBytes* answers, char* message, std::size_t capacity) {
  return guarded(
      [&] {
        announce({Command::task, 0, errand});
        hand_out(messages);
        own(context);
        taken_in = take_in();
        for (const std::string& answer : taken_in) *answers++ = {answer.data(), answer.size()};
        return 0;
      },
      message, capacity);
}

int hvi_petsc_dismiss(int exit_code) { return dismiss(exit_code); }
}
