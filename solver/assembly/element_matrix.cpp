// Element matrices of bilinear forms.
#include "solver/assembly/element_matrix.hpp"

#include "solver/assembly/degree.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

int block_of(std::vector<FormEntries::Block>& blocks, int test, int trial) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].test_component == test && blocks[b].trial_component == trial) {
      return static_cast<int>(b);
    }
  }
  blocks.push_back({test, trial, {}});
  return static_cast<int>(blocks.size()) - 1;
}

/// The rows of S that take part, gathered for the shape functions that take part.
struct Picked {
  double row[4][max_cell_nodes];
};

/// data += weight S^T T S over rows [first, past) and `size` shape functions. Inlined into callers
/// that pass constants, which fixes all loop bounds but the number of blocks.
inline __attribute__((always_inline)) void add_blocks(ElementMatrix& element,
                                                      const FormEntries& entries, const Picked& s,
                                                      double weight, int first, int past,
                                                      int size) {
  const int m = element.components, width = size * m;
  for (const auto& block : entries.blocks) {
    double ts[4][max_cell_nodes];
    for (int r = first; r < past; ++r) {
      for (int j = 0; j < size; ++j) {
        double sum = 0.0;
        for (int k = first; k < past; ++k) {
          sum += block.t[r][k] * s.row[k][j];
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
          sum += s.row[r][i] * ts[r][j];
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
  add_blocks(element, entries, s, weight, first, past, size);
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
        {block_of(out.blocks, test.component, trial.component), test.row, trial.row});
    out.coefficients.push_back(coefficient);
    out.constant = out.constant && coefficient.is_constant();
    out.gradients = out.gradients || test.row > 0 || trial.row > 0;
    out.values = out.values || test.row == 0 || trial.row == 0;
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
  std::fill_n(data.begin(), width * width, 0.0);
}

ElementKernel whole_cell_kernel(const Space& space, const FormEntries& entries) {
  const int size = space.nodes_per_cell;
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
  for (int r = 0; r < shapes.rows; ++r) {
    for (int i = 0; i < size; ++i) {
      s.row[r][i] = shapes.row(r)[element.local[i]];
    }
  }
  add_blocks(element, entries, s, weight, 0, shapes.rows, size);
}

} // namespace hvi::solver
