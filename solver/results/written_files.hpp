// The files a run writes: their names, and the first one that could not be written.
#pragma once

#include "solver/common/failure.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

class WrittenFiles {
public:
  explicit WrittenFiles(std::function<void(const std::string&)> warn) : warn_(std::move(warn)) {}

  /// Writes something. What cannot be written is told once, and the run goes on. Is it written?
  bool attempt(const std::function<void()>& write);
  void add(const std::vector<std::string>& files) {
    names_.insert(names_.end(), files.begin(), files.end());
  }
  std::vector<std::string>& names() { return names_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Of the first file that could not be written.
  const std::optional<Failure>& unwritten() const { return unwritten_; }

private:
  std::vector<std::string> names_;
  std::function<void(const std::string&)> warn_;
  std::optional<Failure> unwritten_;
};

} // namespace hvi::solver
