// See session.hpp.
#include "solver/linear/petsc/session.hpp"

#include <sys/resource.h>

#include <cstdlib>
#include <new>

#if defined(HVI_SANITIZE)
#include <sanitizer/lsan_interface.h>
#endif

namespace hvi::petsc_module {
namespace {

/// MPI and PETSc keep what they take when they start, in libraries that are unloaded before leaks
/// are looked for: no suppression can name them.
#if defined(HVI_SANITIZE)
using LeaksAllowed = __lsan::ScopedDisabler;
#else
struct LeaksAllowed {
  LeaksAllowed() {}
};
#endif

std::string said; // by the last call that failed
MPI_Comm shared = MPI_COMM_SELF;
int own_rank = 0, all_processes = 1;
bool mpi_is_ours = false; ///< it was started here

/// Keeps the words of the innermost call.
PetscErrorCode note_error(MPI_Comm, int, const char*, const char*, PetscErrorCode error,
                          PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL && message != nullptr) said = message;
  return error;
}

/// Another library of the process may have started MPI, and ended it: mpi4py does.
void end() {
  const LeaksAllowed here;
  int ended = 0;
  MPI_Finalized(&ended);
  if (ended != 0) return;
  static_cast<void>(PetscFinalize());
  if (mpi_is_ours) MPI_Finalize();
}

bool is_started() {
  PetscBool started = PETSC_FALSE;
  static_cast<void>(PetscInitialized(&started));
  return started == PETSC_TRUE;
}

void start_petsc(MPI_Comm together) {
  const LeaksAllowed here;
  shared = PETSC_COMM_WORLD = together;
  MPI_Comm_rank(shared, &own_rank);
  MPI_Comm_size(shared, &all_processes);
  setenv("PETSC_OPTIONS", "", 1);
  const char* words[] = {"hvi-run", "-no_signal_handler", "-skip_petscrc", nullptr};
  int count = 3;
  char** given = const_cast<char**>(words);
  if (PetscInitialize(&count, &given, nullptr, nullptr) != 0)
    throw PetscFailure("PETSc does not start");
  check(PetscPushErrorHandler(note_error, nullptr));
  // L L^T of supernodes: L D L^T would hide that a matrix is not positive definite.
  check(PetscOptionsSetValue(nullptr, "-mat_cholmod_factor", "SUPERNODAL"));
  check(PetscOptionsSetValue(nullptr, "-mat_cholmod_print", "0"));
  std::atexit(end);
}

void start_mpi() {
  const LeaksAllowed here;
  int running = 0, given = 0;
  MPI_Initialized(&running);
  if (running != 0) return;
  // Threads of a Python program take turns (bridge.cpp).
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &given);
  mpi_is_ours = true;
}

} // namespace

void check(PetscErrorCode error) {
  if (error == 0) return;
  if (error == PETSC_ERR_MEM) throw std::bad_alloc();
  throw PetscFailure(said.empty() ? "error " + std::to_string(static_cast<int>(error)) : said);
}

void start() {
  if (is_started()) return;
  // One process, which starts no other one and looks for no network.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  setenv("OMPI_MCA_btl", "self", 0);
  setenv("OMPI_MCA_pml", "ob1", 0);
  setenv("OMPI_MCA_orte_create_session_dirs", "0",
         0); // another run may end and remove them meanwhile
  start_mpi();
  start_petsc(MPI_COMM_SELF);
}

void start_together() {
  start_mpi();
  start_petsc(MPI_COMM_WORLD);
  if (all_processes == 1) return;
  // The coarse matrices by sums in the order of the processes, not of their messages: as many
  // processes have the same bits each time.
  check(PetscOptionsSetValue(nullptr, "-matptap_via", "backend"));
}

MPI_Comm world() { return shared; }

int rank() { return own_rank; }

int processes() { return all_processes; }

double bytes_of(Mat a) {
  MatInfo info{};
  if (a == nullptr || MatGetInfo(a, MAT_LOCAL, &info) != 0) return 0.0;
  return info.nz_used * (sizeof(double) + sizeof(int));
}

void values_changed(Mat matrix) {
  double* values = nullptr;
  check(MatSeqAIJGetArray(matrix, &values));
  check(MatSeqAIJRestoreArray(matrix, &values));
}

double most_held() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return 1024.0 * static_cast<double>(used.ru_maxrss);
}

std::array<double, 3> sent() {
  return {petsc_send_ct + petsc_isend_ct, petsc_send_len + petsc_isend_len, petsc_allreduce_ct};
}

} // namespace hvi::petsc_module
