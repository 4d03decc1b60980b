// A run that Python takes step by step.
#pragma once

#include "lang/python/model.hpp"
#include "solver/time/stepped_run.hpp"

#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace hvi::python {

class Stepping {
public:
  Stepping(Model model, const Defines& defines)
      : model_(std::move(model)), session_(model_.session(defines)) {}

  /// Mesh, space and the first matrices.
  Answer start();
  /// The next step, and whether there was one.
  std::pair<Answer, bool> advance();
  /// The steps from the next one on have these values of parameters; refused, nothing changes.
  Answer set(const Defines& defines);
  /// What is known after the steps so far; once only.
  Answer conclude();

  Watch& watch() { return watch_; }
  int step() const { return run_->step(); }
  int steps() const { return run_->steps(); }
  double t() const { return run_->t(); }
  /// Columns of the tables at this step.
  std::vector<std::pair<std::string, double>> values() const;
  std::vector<Array> unknowns() const;
  Grid grid() const;

private:
  Model model_;
  std::shared_ptr<lang::Session> session_;
  Watch watch_;
  std::size_t own_pictures_ = 0;
  std::optional<solver::SteppedRun> run_;
};

} // namespace hvi::python
