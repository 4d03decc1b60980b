// One run at a time in an output folder.
#pragma once

#include "solver/common/failure.hpp"

#include <filesystem>

namespace hvi::solver {

/// Makes the folder and holds it until the end of its life, or of the program, however that ends:
/// the lock is the kernel's (flock) on a file `.hvi-run.lock`, in which stands who holds it. A
/// folder that was made and stays empty is removed again.
class FolderLock {
public:
  /// Throws Failure(busy_folder) with process, host and start of the run that has it,
  /// Failure(output_folder) where the folder cannot be made or written to.
  explicit FolderLock(std::filesystem::path folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

private:
  void hold();
  bool take();
  void leave() const;

  std::filesystem::path folder_, name_;
  bool made_ = false;
  int descriptor_ = -1;
};

} // namespace hvi::solver
