// MUMPS behind the interface of bridge.h.
//
// P. R. Amestoy, I. S. Duff, J. Koster, J.-Y. L'Excellent, A fully asynchronous multifrontal solver
// using distributed dynamic scheduling, SIAM J. Matrix Anal. Appl. 23 (2001) 15-41.
#include "solver/linear/mumps/bridge.h"

#include <dmumps_c.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

namespace {

constexpr int start = -1, end = -2, analysis = 1, numbers = 2, solution = 3; // jobs
constexpr MUMPS_INT this_process = -987654;
constexpr MUMPS_INT general_symmetric = 2;
/// In per cent of what the analysis expects: pivots that are put off take more.
constexpr MUMPS_INT first_room = 50, most_room = 3200;

/// Which of the settings the manual numbers from 1.
MUMPS_INT& setting(DMUMPS_STRUC_C& mumps, int number) { return mumps.icntl[number - 1]; }

/// MUMPS keeps a table of its instances and some numbers for the whole process: one call at a time.
std::mutex& turn() {
  static std::mutex only;
  return only;
}

struct Solver {
  DMUMPS_STRUC_C mumps{};
  std::vector<MUMPS_INT> row, column, position, last;
  std::vector<double> value;

  Solver() {
    mumps.sym = general_symmetric, mumps.par = 1, mumps.comm_fortran = this_process;
    run(start);
  }
  ~Solver() { run(end); }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  int run(int job) {
    mumps.job = job;
    {
      const std::scoped_lock lock(turn());
      dmumps_c(&mumps);
    }
    const int info = mumps.infog[0];
    if (info >= 0) return hvi_mumps_ok;
    if (info == -10 || info == -6) return hvi_mumps_singular;
    if (info == -7 || info == -13) return hvi_mumps_no_memory;
    return hvi_mumps_failed;
  }
};

/// A count in units, or in millions where it is negative.
double large(MUMPS_INT count) { return count >= 0 ? count : -1e6 * count; }

std::vector<MUMPS_INT> from_one(const int* values, std::size_t n) {
  std::vector<MUMPS_INT> out(values, values + n);
  for (MUMPS_INT& v : out) ++v;
  return out;
}

void choose_settings(DMUMPS_STRUC_C& mumps) {
  constexpr int errors = 1, diagnostics = 2, information = 3, level = 4;
  for (const int stream : {errors, diagnostics, information}) setting(mumps, stream) = -1;
  setting(mumps, level) = 0;
  setting(mumps, 7) = 1;  // the caller has an order
  setting(mumps, 8) = 0;  // the caller has scaled it
  setting(mumps, 10) = 0; // and corrects
  setting(mumps, 13) = 1; // no ScaLAPACK
  setting(mumps, 14) = first_room;
  setting(mumps, 24) = 1; // pivots below CNTL(3) are listed
}

int open(const HviMumpsPattern& pattern, Solver& solver, HviMumpsCounts& expected) {
  DMUMPS_STRUC_C& mumps = solver.mumps;
  choose_settings(mumps);
  solver.row = from_one(pattern.row, pattern.entries);
  solver.column = from_one(pattern.column, pattern.entries);
  solver.position = from_one(pattern.position, static_cast<std::size_t>(pattern.n));
  solver.last = from_one(pattern.last, static_cast<std::size_t>(pattern.n_last));
  mumps.n = pattern.n;
  mumps.nnz = static_cast<MUMPS_INT8>(pattern.entries);
  mumps.irn = solver.row.data(), mumps.jcn = solver.column.data();
  mumps.perm_in = solver.position.data();
  if (pattern.n_last > 0) {
    setting(mumps, 19) = 3; // what elimination leaves, whole, by columns
    mumps.size_schur = pattern.n_last;
    mumps.listvar_schur = solver.last.data();
    mumps.nprow = mumps.npcol = 1;
    mumps.mblock = mumps.nblock = 100;
  }
  const int status = solver.run(analysis);
  expected = {large(mumps.infog[19]), mumps.rinfog[0], 1e6 * mumps.infog[16]};
  return status;
}

int factor(Solver& solver, const double* value, double least, double* schur,
           HviMumpsCounts& counts) {
  DMUMPS_STRUC_C& mumps = solver.mumps;
  solver.value.assign(value, value + solver.row.size());
  mumps.a = solver.value.data();
  mumps.cntl[2] = -least; // absolute
  mumps.schur_lld = mumps.size_schur;
  mumps.schur = schur;
  int status = solver.run(numbers);
  while ((mumps.infog[0] == -8 || mumps.infog[0] == -9) && setting(mumps, 14) < most_room) {
    setting(mumps, 14) *= 2;
    status = solver.run(numbers);
  }
  if (status != hvi_mumps_ok) return status;
  counts = {large(mumps.infog[28]), mumps.rinfog[2], 1e6 * mumps.infog[21]};
  return mumps.infog[27] > 0 ? hvi_mumps_singular : hvi_mumps_ok;
}

} // namespace

extern "C" {

int hvi_mumps_open(const HviMumpsPattern* pattern, void** solver, HviMumpsCounts* expected) {
  try {
    auto made = std::make_unique<Solver>();
    const int status = open(*pattern, *made, *expected);
    *solver = made.release();
    return status;
  } catch (const std::bad_alloc&) {
    return hvi_mumps_no_memory;
  }
}

int hvi_mumps_factor(void* solver, const double* value, double least, double* schur,
                     HviMumpsCounts* counts) {
  try {
    return factor(*static_cast<Solver*>(solver), value, least, schur, *counts);
  } catch (const std::bad_alloc&) {
    return hvi_mumps_no_memory;
  }
}

int hvi_mumps_solve(void* solver, double* x) {
  Solver& of = *static_cast<Solver*>(solver);
  of.mumps.rhs = x, of.mumps.nrhs = 1, of.mumps.lrhs = of.mumps.n;
  setting(of.mumps, 26) = 0; // of what is eliminated
  return of.run(solution);
}

void hvi_mumps_close(void* solver) { delete static_cast<Solver*>(solver); }
}
