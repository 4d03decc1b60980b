// OpenMP with one thread, for hvi-run alone. Nothing in it runs OpenMP but CHOLMOD's numerical
// factorisation, which opens a parallel region for every few columns and is held to one thread
// anyway (solver/linear/cholmod_session.hpp); libgomp makes a team of one for each, a thousand
// system calls in a small run. A program that links hvi_solver keeps its own OpenMP.
extern "C" {

void GOMP_parallel(void (*body)(void*), void* data, unsigned /*threads*/, unsigned /*flags*/) {
  body(data);
}
int omp_get_num_threads(void) { return 1; }
int omp_get_thread_num(void) { return 0; }
int omp_get_max_active_levels(void) { return 0; }
void omp_set_max_active_levels(int /*levels*/) {}
}
