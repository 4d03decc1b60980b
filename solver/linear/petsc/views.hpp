// Entries of a vector of all processes where one of them needs those of others. A process that is
// alone sees the vector itself. All calls are made by all processes together.
#pragma once

#include "solver/linear/petsc/distribution.hpp"

#include <vector>

namespace hvi::petsc_module {

/// From these entries of vectors like this one to those of `here`, one after the other.
void connect(Vec like, const std::vector<int>& from, Vec here, Owned<VecScatter>& scatter);

/// The whole vector, as the first process sees it, and may write it. The others see nothing.
class View {
public:
  View(const Distribution& distribution, Vec like);
  PetscErrorCode read(Vec x, const double** values) const;
  PetscErrorCode done(Vec x, const double** values) const;
  PetscErrorCode write(Vec x, double** values) const; ///< whatever they were
  PetscErrorCode put(Vec x, double** values) const;   ///< ends `write`

private:
  Owned<Vec> whole_; ///< null: alone
  Owned<VecScatter> scatter_;
};

/// What each process reads: the entries that columns of its rows stand for.
class Halo {
public:
  /// Changes columns of the whole to places in what `read` gives.
  void want(const Distribution& distribution, Vec like, std::vector<int>& columns);
  PetscErrorCode read(Vec x, const double** values) const;
  PetscErrorCode done(Vec x, const double** values) const;

private:
  std::vector<int> wanted_; ///< increasing
  Owned<Vec> here_;         ///< null: alone
  Owned<VecScatter> scatter_;
};

} // namespace hvi::petsc_module
