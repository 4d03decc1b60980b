// See commands.hpp.
#include "solver/linear/petsc/commands.hpp"

#include "solver/linear/petsc/krylov.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <utility>

namespace hvi::petsc_module {
namespace {

bool given_up = false, dismissed = false;
int opened = 0;

MPI_Request broadcast(Command& command) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&command, sizeof command, MPI_BYTE, 0, world(), &request);
  return request;
}

/// Waits without taking a processor from who works: looks again after an eighth of the time that it
/// waited already, after a millisecond at the latest.
Command next_command() {
  using namespace std::chrono;
  Command command;
  MPI_Request request = broadcast(command);
  const auto begin = steady_clock::now();
  for (;;) {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return command;
    const auto waited = duration_cast<microseconds>(steady_clock::now() - begin).count();
    ::usleep(static_cast<useconds_t>(std::clamp<long>(waited / 8, 0, 1000)));
  }
}

class Worker {
public:
  explicit Worker(const HviPetscHelper& helper) : helper_(helper) {}

  void obey(const Command& command) {
    if (command.what == Command::open)
      open(command);
    else if (command.what == Command::close)
      solvers_.erase(command.solver), dealt_.erase(command.solver);
    else if (command.what == Command::task)
      answer(helper_, command.number);
    else
      call(*solvers_.at(command.solver), command);
  }

private:
  void open(const Command& command) {
    if (command.set != 0) dealt_[command.solver] = {command.set, command.matrix};
    const auto mine = rows_of(command.solver);
    solvers_[command.solver] =
        std::make_unique<Krylov>(HviPetscMatrix{0, &none_, nullptr, nullptr},
                                 mine ? &*mine : nullptr, command.number != 0, HviPetscUnknowns{});
  }

  /// Of K, where it is dealt out.
  std::optional<HviPetscMatrix> rows_of(int solver) const {
    const auto at = dealt_.find(solver);
    if (at == dealt_.end()) return std::nullopt;
    return helper_.rows(helper_.context, at->second.first, at->second.second);
  }

  void call(Krylov& solver, const Command& command) {
    if (command.what == Command::changed) {
      const auto mine = rows_of(command.solver);
      solver.matrix_changed(mine ? &*mine : nullptr);
    }
    if (command.what == Command::free) solver.set_free_motions(nullptr, command.number);
    if (command.what == Command::laws)
      solver.set_laws(HviPetscMatrix{0, &none_, nullptr, nullptr}, command.number != 0);
    if (command.what == Command::solve) solver.solve(nullptr, command.reduction, nullptr, nullptr);
  }

  const HviPetscHelper& helper_;
  int none_ = 0;                                            ///< where rows of no matrix start
  std::map<int, std::pair<unsigned long long, int>> dealt_; ///< by solver: set and matrix
  std::map<int, std::unique_ptr<Krylov>> solvers_;
};

/// The first process may wait for this one, so all of them end.
[[noreturn]] void abandon(const char* why) {
  std::fprintf(stderr,
               "hvi-run: process %d of %d cannot go on: %s; take fewer processes, or the direct "
               "solver with one\n",
               rank() + 1, processes(), why);
  constexpr int solve_failed = 3; // as hvi-run ends without memory, or where PETSc fails
  MPI_Abort(world(), solve_failed);
  std::_Exit(solve_failed);
}

} // namespace

void announce(const Command& command) {
  if (!announced(command)) throw PetscFailure("the other processes cannot go on");
}

bool announced(const Command& command) {
  if (given_up) return false;
  if (command.what == Command::open) ++opened;
  if (processes() == 1) return true;
  Command sent = command;
  MPI_Request request = broadcast(sent);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  return true;
}

void give_up() { given_up = processes() > 1; }

int dismiss(int exit_code) {
  if (dismissed) return opened;
  dismissed = true;
  if (given_up) MPI_Abort(world(), exit_code);
  announce({Command::end, 0, exit_code});
  return opened;
}

int serve(const HviPetscHelper& helper) {
  // What asks the run to stop is for the first process, which ends the others.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_IGN);
  try {
    Worker worker(helper);
    for (;;) {
      const Command command = next_command();
      if (command.what == Command::end) return command.number;
      worker.obey(command);
    }
  } catch (const std::bad_alloc&) {
    abandon("no memory");
  } catch (const std::exception& error) {
    abandon(error.what());
  }
}

} // namespace hvi::petsc_module
