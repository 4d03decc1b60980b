// Opens libhvi_petsc.so where an iterative solver is asked for (iterative_solver.hpp).
#include "solver/common/clock.hpp"
#include "solver/common/failure.hpp"
#include "solver/common/open_module.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/iterative_solver.hpp"
#include "solver/linear/petsc/bridge.h"
#include "solver/linear/pieces.hpp"
#include "solver/linear/processes.hpp"

#include <cstdlib>
#include <exception>
#include <functional>
#include <new>
#include <optional>
#include <utility>

namespace hvi::solver {
namespace {

constexpr ModuleFile petsc_module{"libhvi_petsc.so", "HVI_PETSC_MODULE",
                                  "has the iterative solvers of PETSc",
                                  "install the package hvi-petsc beside hvi-run; where you build "
                                  "it, libpetsc-real-dev, and build again "
                                  "(`tools/run --with-petsc` does both); or take "
                                  "`using solver = direct`"};

/// The functions of the module.
struct Bridge {
  HviPetscOpen open = function<HviPetscOpen>("hvi_petsc_open");
  HviPetscChanged changed = function<HviPetscChanged>("hvi_petsc_changed");
  HviPetscFree free = function<HviPetscFree>("hvi_petsc_free");
  HviPetscLaws laws = function<HviPetscLaws>("hvi_petsc_laws");
  HviPetscSolve solve = function<HviPetscSolve>("hvi_petsc_solve");
  HviPetscCount count = function<HviPetscCount>("hvi_petsc_count");
  HviPetscClose close = function<HviPetscClose>("hvi_petsc_close");

private:
  template <class Function>
  static Function function(const char* name) {
    return module_function<Function>(petsc_module, name);
  }
};

HviPetscMatrix rows_of(const SparseMatrix& a) {
  return {static_cast<int>(a.rows()), a.outerIndexPtr(), a.innerIndexPtr(), a.valuePtr()};
}

/// For what a call of the module has to say, up to the first zero.
std::string room_for_message() { return std::string(2000, '\0'); }
std::string words_of(const std::string& message) { return message.substr(0, message.find('\0')); }

/// Throws what a call that ended with this status has to say.
void require(int status, const std::string& message) {
  if (status == 0) return;
  if (status == hvi_petsc_no_memory) throw OutOfMemory("no memory for the iterative solver");
  throw Failure(FailureKind::not_certified, {},
                "PETSc cannot solve for the unknowns of a step: " + words_of(message),
                "take `using solver = direct`");
}

/// The same of a call that only talks with the other processes.
void require_others(int status, const std::string& message) {
  if (status == 0) return;
  if (status == hvi_petsc_no_memory) throw OutOfMemory("no memory for the other processes");
  throw Failure(FailureKind::not_certified, {},
                "the other processes cannot be reached: " + words_of(message), "take one process");
}

HviPetscMatrix rows_of(const RowArrays& a) { return {a.rows, a.start, a.column, a.value}; }

/// A helper as the module calls it.
struct HelperBridge {
  Helper& helper;
  std::string said;

  static HviPetscBytes answer(void* context, int errand, HviPetscBytes message) {
    HelperBridge& bridge = *static_cast<HelperBridge*>(context);
    try {
      bridge.said =
          bridge.helper.answer(static_cast<Errand>(errand), {message.bytes, message.size});
      return {bridge.said.data(), bridge.said.size()};
    } catch (const std::bad_alloc&) {
      return {nullptr, 0};
    }
  }
  static HviPetscMatrix rows(void* context, unsigned long long set, int matrix) {
    return rows_of(static_cast<HelperBridge*>(context)->helper.rows(set, matrix));
  }
};

/// What is called between iterations, as the module calls it: no exception passes through that.
struct Watch {
  std::function<void()> called;
  std::exception_ptr thrown;

  static int stop(void* context) {
    Watch& watch = *static_cast<Watch*>(context);
    if (!watch.called) return 0;
    try {
      watch.called();
    } catch (...) {
      watch.thrown = std::current_exception();
    }
    return watch.thrown ? 1 : 0;
  }
};

class PetscSolver final : public IterativeSolver {
public:
  PetscSolver(const SparseMatrix& k, bool symmetric, const UnknownsOfNodes& unknowns) : pieces_(k) {
    open(rows_of(k), nullptr, symmetric, unknowns);
  }
  PetscSolver(DealtRows k, Pieces pieces, bool symmetric, const UnknownsOfNodes& unknowns)
      : pieces_(std::move(pieces)), dealt_(std::move(k)) {
    const HviPetscDealt dealt{dealt_->set, dealt_->matrix, rows_of(dealt_->place())};
    open({static_cast<int>(unknowns.node.size()), nullptr, nullptr, nullptr}, &dealt, symmetric,
         unknowns);
    dealt_->leave();
  }
  ~PetscSolver() override { bridge_.close(solver_); }
  PetscSolver(const PetscSolver&) = delete;
  PetscSolver& operator=(const PetscSolver&) = delete;

  void matrix_changed() override {
    const HviPetscMatrix mine = dealt_ ? rows_of(dealt_->place()) : HviPetscMatrix{};
    require(bridge_.changed(solver_, dealt_ ? &mine : nullptr, message_.data(), message_.size()),
            message_);
    if (dealt_) dealt_->leave();
  }

  void set_free_motions(const DenseMatrix& motions) override {
    require(bridge_.free(solver_, motions.data(), static_cast<int>(motions.cols()), message_.data(),
                         message_.size()),
            message_);
  }

  bool set_laws(const SparseMatrix& h, bool symmetric) override {
    laws_ = &h;
    pieces_.join(h);
    const HviPetscMatrix matrix = rows_of(h);
    const int status = bridge_.laws(solver_, &matrix, symmetric, message_.data(), message_.size());
    if (status == hvi_petsc_no_factor) return false;
    require(status, message_);
    count();
    return true;
  }

  void call_between_iterations(std::function<void()> what) override {
    watch_.called = std::move(what);
  }

  IterativeAnswer solve(const Vector& b, double reduction, Vector& x) override {
    x.resize(b.size());
    HviPetscAnswer answer{};
    const HviPetscWatch watch{&watch_, &Watch::stop};
    require(bridge_.solve(solver_, b.data(), reduction, &watch, x.data(), &answer, message_.data(),
                          message_.size()),
            message_);
    if (answer.outcome == hvi_petsc_stopped)
      std::rethrow_exception(std::exchange(watch_.thrown, nullptr));
    count();
    pieces_.leave_at_rest(b, x);
    ++statistics_.solves;
    statistics_.work.iterations += answer.iterations;
    using Outcome = IterativeAnswer::Outcome;
    const auto outcome = answer.outcome == hvi_petsc_solved       ? Outcome::solved
                         : answer.outcome == hvi_petsc_indefinite ? Outcome::indefinite
                                                                  : Outcome::stagnated;
    return {outcome, answer.iterations, answer.reduction, answer.reason};
  }

  const SparseMatrix* laws() const override { return laws_; }
  const IterativeStatistics& statistics() const override { return statistics_; }

private:
  void open(const HviPetscMatrix& k, const HviPetscDealt* dealt, bool symmetric,
            const UnknownsOfNodes& unknowns) {
    const bool placed = !unknowns.place.empty();
    const HviPetscUnknowns of{unknowns.node.data(),
                              unknowns.component.data(),
                              unknowns.nodes,
                              unknowns.components,
                              unknowns.first_component.data(),
                              static_cast<int>(unknowns.first_component.size()),
                              unknowns.motions.data(),
                              static_cast<int>(unknowns.motions.cols()),
                              placed ? unknowns.place.data() : nullptr,
                              placed ? unknowns.counts.data() : nullptr};
    require(bridge_.open(&k, dealt, symmetric, &of, &solver_, message_.data(), message_.size()),
            message_);
    count();
  }
  void count() {
    HviPetscCounts counts{};
    bridge_.count(solver_, &counts);
    statistics_.setups = counts.setups, statistics_.local_factors = counts.local_factors;
    statistics_.bytes = counts.bytes, statistics_.seconds_setup = counts.seconds_setup;
    IterationWork& work = statistics_.work;
    work.bytes_of_others = counts.bytes_of_others;
    work.messages = counts.messages, work.bytes_sent = counts.bytes_sent;
    work.reductions = counts.reductions;
    work.levels.clear();
    for (int l = 0; l < counts.levels; ++l)
      work.levels.push_back({counts.level[l].rows, counts.level[l].entries});
  }

  Bridge bridge_;
  HviPetscSolver* solver_ = nullptr;
  Watch watch_;
  Pieces pieces_;
  std::optional<DealtRows> dealt_;
  const SparseMatrix* laws_ = nullptr;
  std::string message_ = room_for_message();
  IterativeStatistics statistics_;
};

} // namespace

Processes started_processes() {
  const auto number = [](const char* name) {
    const char* text = std::getenv(name);
    return text == nullptr ? -1 : std::atoi(text);
  };
  for (const auto& [rank, count] : {std::pair("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
                                    std::pair("PMI_RANK", "PMI_SIZE")})
    if (number(rank) >= 0 && number(count) > number(rank)) return {number(rank), number(count)};
  return {};
}

void lead(const Processes& processes) {
  std::string message = room_for_message();
  const int status = module_function<HviPetscLead>(petsc_module, "hvi_petsc_lead")(
      processes.count, message.data(), message.size());
  if (status == hvi_petsc_no_memory) throw OutOfMemory("no memory for the iterative solver");
  if (status != 0)
    throw Failure(FailureKind::not_certified, {}, words_of(message),
                  "start hvi-run by the mpirun of the MPI that PETSc is built with");
}

int processes_led() {
  if (!started_processes().several()) return 1;
  try {
    return module_function<HviPetscProcesses>(petsc_module, "hvi_petsc_processes")();
  } catch (const Failure&) {
    return 1;
  }
}

int dismiss(int exit_code) {
  return module_function<HviPetscDismiss>(petsc_module, "hvi_petsc_dismiss")(exit_code);
}

int serve(const Processes& processes, Helper& helper) {
  try {
    HelperBridge bridge{helper, {}};
    const HviPetscHelper called{&bridge, &HelperBridge::answer, &HelperBridge::rows};
    return module_function<HviPetscServe>(petsc_module, "hvi_petsc_serve")(processes.count,
                                                                           &called);
  } catch (const Failure&) {
    return 0;
  }
}

std::vector<std::string> deal_out(Errand errand, std::span<const std::string> messages,
                                  const Task& task) {
  struct Own {
    const Task& task;
    const std::string& message;
    std::string answer;
    std::exception_ptr failed; // the others answer all the same
    static void work(void* context) {
      Own& own = *static_cast<Own*>(context);
      try {
        own.answer = own.task(own.message);
      } catch (...) {
        own.failed = std::current_exception();
      }
    }
  };
  Own own{task, messages.front(), {}, nullptr};
  std::vector<HviPetscBytes> bytes;
  for (const std::string& one : messages) bytes.push_back({one.data(), one.size()});
  std::string message = room_for_message();
  require_others(module_function<HviPetscDealOut>(petsc_module, "hvi_petsc_deal_out")(
                     static_cast<int>(errand), bytes.data() + 1, &Own::work, &own, bytes.data() + 1,
                     message.data(), message.size()),
                 message);
  if (own.failed) std::rethrow_exception(own.failed);
  std::vector<std::string> out{std::move(own.answer)};
  for (const HviPetscBytes& answer : std::span(bytes).subspan(1))
    out.emplace_back(answer.bytes, answer.size);
  return out;
}

bool petsc_is_there() {
  try {
    static_cast<void>(Bridge());
    return true;
  } catch (const Failure&) {
    return false;
  }
}

std::unique_ptr<IterativeSolver> petsc_solver(const SparseMatrix& k, bool symmetric,
                                              const UnknownsOfNodes& unknowns) {
  return std::make_unique<PetscSolver>(k, symmetric, unknowns);
}

std::unique_ptr<IterativeSolver> petsc_solver(DealtRows k, Pieces pieces, bool symmetric,
                                              const UnknownsOfNodes& unknowns) {
  return std::make_unique<PetscSolver>(std::move(k), std::move(pieces), symmetric, unknowns);
}

} // namespace hvi::solver
