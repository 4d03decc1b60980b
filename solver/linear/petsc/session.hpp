// PETSc in this process: its start, its errors as exceptions, and its objects.
#pragma once

#include <petscksp.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace hvi::petsc_module {

/// What PETSc said when a call of it failed.
struct PetscFailure : std::runtime_error {
  explicit PetscFailure(const std::string& said) : std::runtime_error(said) {}
};

/// Throws bad_alloc, or PetscFailure with what PETSc said, where a call returned an error.
void check(PetscErrorCode error);

/// Starts MPI and PETSc at the first call: quiet, without the options of the user's environment,
/// without handlers of signals. They end with the program. The process is alone, whoever started
/// it.
void start();

/// The same with all processes that mpirun started.
void start_together();

/// The processes that share the work.
MPI_Comm world();
int rank();
int processes();

/// Tells PETSc that the arrays which a matrix was made of have other values.
void values_changed(Mat matrix);

/// Of the entries that this process has.
double bytes_of(Mat a);

/// Bytes of memory at the highest.
double most_held();

/// What this process has sent to others, as PETSc counts it: messages, their bytes, reductions.
std::array<double, 3> sent();

template <class T>
PetscErrorCode destroy(T* object);
template <>
inline PetscErrorCode destroy(Mat* object) {
  return MatDestroy(object);
}
template <>
inline PetscErrorCode destroy(Vec* object) {
  return VecDestroy(object);
}
template <>
inline PetscErrorCode destroy(PC* object) {
  return PCDestroy(object);
}
template <>
inline PetscErrorCode destroy(KSP* object) {
  return KSPDestroy(object);
}
template <>
inline PetscErrorCode destroy(IS* object) {
  return ISDestroy(object);
}
template <>
inline PetscErrorCode destroy(VecScatter* object) {
  return VecScatterDestroy(object);
}
/// An object of PETSc that ends with its owner.
template <class T>
class Owned {
public:
  Owned() = default;
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  ~Owned() { reset(); }
  void reset() {
    if (object_ != nullptr) static_cast<void>(destroy(&object_));
    object_ = nullptr;
  }
  T* put() { ///< for a call that makes it anew
    reset();
    return &object_;
  }
  T get() const { return object_; }
  explicit operator bool() const { return object_ != nullptr; }

private:
  T object_ = nullptr;
};

} // namespace hvi::petsc_module
