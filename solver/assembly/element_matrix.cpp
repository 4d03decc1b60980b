// Element matrices of bilinear forms.
#include "solver/assembly/element_matrix.hpp"

#include "solver/assembly/degree.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

int rows_of(const Derivative& derivative) { return derivative.row < linear_rows ? 0 : linear_rows; }

int block_of(std::vector<FormEntries::Block>& blocks, const Derivative& test,
             const Derivative& trial) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].test_component == test.component &&
        blocks[b].trial_component == trial.component) {
      return static_cast<int>(b);
    }
  }
  blocks.push_back({test.component, trial.component, rows_of(test), rows_of(trial), {}});
  return static_cast<int>(blocks.size()) - 1;
}

/// The rows of S that take part, gathered for the shape functions that take part.
struct Picked {
  double row[2 * linear_rows][max_cell_nodes];
};

/// data += weight S^T T S over rows [first, past) and `size` shape functions; `mixed`: behind those
/// at which the rows of a block begin. Inlined into callers that pass constants, which fixes all
/// loop bounds but the number of blocks.
inline __attribute__((always_inline)) void add_blocks(ElementMatrix& element,
                                                      const FormEntries& entries, const Picked& s,
                                                      double weight, int first, int past, int size,
                                                      bool mixed) {
  const int m = element.components, width = size * m;
  for (const auto& block : entries.blocks) {
    double ts[4][max_cell_nodes];
    const auto* const tests = s.row + (mixed ? block.test_rows : 0);
    const auto* const trials = s.row + (mixed ? block.trial_rows : 0);
    for (int r = first; r < past; ++r) {
      for (int j = 0; j < size; ++j) {
        double sum = 0.0;
        for (int k = first; k < past; ++k) {
          sum += block.t[r][k] * trials[k][j];
        }
        ts[r][j] = weight * sum;
      }
    }
    for (int i = 0; i < size; ++i) {
      double* to = element.data.data() + (i * m + block.test_component) * width;
      double line[max_cell_nodes];
      for (int j = 0; j < size; ++j) {
        double sum = 0.0;
        for (int r = first; r < past; ++r) {
          sum += tests[r][i] * ts[r][j];
        }
        line[j] = sum;
      }
      for (int j = 0; j < size; ++j) {
        to[j * m + block.trial_component] += line[j];
      }
    }
  }
}

template <int first, int past, int size>
void fixed_kernel(ElementMatrix& element, const FormEntries& entries, const ShapeTable& shapes,
                  double weight) {
  Picked s;
  for (int r = first; r < past; ++r) {
    std::copy_n(shapes.row(r), size, s.row[r]);
  }
  add_blocks(element, entries, s, weight, first, past, size, false);
}

template <int first, int past>
ElementKernel fixed_kernel_of_size(int size) {
  switch (size) {
  case 2:
    return fixed_kernel<first, past, 2>;
  case 3:
    return fixed_kernel<first, past, 3>;
  case 4:
    return fixed_kernel<first, past, 4>;
  case 6:
    return fixed_kernel<first, past, 6>;
  case 10:
    return fixed_kernel<first, past, 10>;
  default:
    return general_kernel;
  }
}

} // namespace

FormEntries sort_entries(const Space& space, const FormTerm& term) {
  FormEntries out;
  for (const auto& entry : term.entries) {
    const Expr& coefficient = entry.coefficient;
    if (coefficient.is(0.0)) {
      continue;
    }
    if (coefficient.is_constant() && !std::isfinite(coefficient.value())) {
      throw Failure(FailureKind::bad_value, term.origin, "a coefficient of the form is not finite");
    }
    const Derivative test = decode(space, entry.test, term.origin);
    const Derivative trial = decode(space, entry.trial, term.origin);
    out.places.push_back(
        {block_of(out.blocks, test, trial), test.row % linear_rows, trial.row % linear_rows});
    out.mixed = out.mixed || rows_of(test) > 0 || rows_of(trial) > 0;
    out.coefficients.push_back(coefficient);
    out.constant = out.constant && coefficient.is_constant();
    const bool values[] = {slot::is_value(entry.test), slot::is_value(entry.trial)};
    out.gradients = out.gradients || !values[0] || !values[1];
    out.values = out.values || values[0] || values[1];
    const int shapes =
        shape_degree(entry.test, space.order) + shape_degree(entry.trial, space.order);
    out.degree = std::max(out.degree, exact_degree(coefficient, shapes, space.order));
  }
  return out;
}

void FormEntries::set(const double* at_point, std::size_t stride) {
  for (auto& block : blocks) {
    block.t = {};
  }
  for (std::size_t e = 0; e < places.size(); ++e) {
    const Place& place = places[e];
    blocks[place.block].t[place.row][place.column] += at_point[e * stride];
  }
}

void ElementMatrix::clear() {
  const std::size_t width = nodes.size() * components;
  data.assign(width * width, 0.0);
}

ElementKernel whole_cell_kernel(const Space& space, const FormEntries& entries) {
  const int size = space.nodes_per_cell;
  if (entries.mixed) {
    return general_kernel;
  }
  if (!entries.gradients) {
    return fixed_kernel_of_size<0, 1>(size);
  }
  if (entries.values) {
    return general_kernel;
  }
  switch (has_hoop(space) ? hoop_row : space.mesh->dim) {
  case 1:
    return fixed_kernel_of_size<1, 2>(size);
  case 2:
    return fixed_kernel_of_size<1, 3>(size);
  default:
    return fixed_kernel_of_size<1, 4>(size);
  }
}

void general_kernel(ElementMatrix& element, const FormEntries& entries, const ShapeTable& shapes,
                    double weight) {
  const int size = static_cast<int>(element.local.size());
  Picked s;
  const auto pick = [&](int first) {
    for (int r = first; r < first + shapes.rows; ++r) {
      for (int i = 0; i < size; ++i) {
        s.row[r][i] = shapes.row(r)[element.local[i]];
      }
    }
  };
  pick(0);
  if (entries.mixed) pick(linear_rows);
  add_blocks(element, entries, s, weight, 0, shapes.rows, size, entries.mixed);
}

} // namespace hvi::solver
