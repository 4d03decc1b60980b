// What another process does for the first one besides iterations.
#pragma once

#include "solver/discrete/own_matrices.hpp"
#include "solver/linear/processes.hpp"

namespace hvi::solver {

class HelperOfRun final : public Helper {
public:
  std::string answer(Errand errand, std::string_view message) override;
  RowArrays rows(std::uint64_t set, int matrix) const override {
    return matrices_.placed(set, matrix);
  }

private:
  OwnMatrices matrices_;
};

} // namespace hvi::solver
