#include "solver/linear/supernodes.hpp"

#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/supernode_kernels.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

using supernode_kernels::TriangularSolve, supernode_kernels::forward_any,
    supernode_kernels::backward_any;

template <class Entry>
HVI_AVX2 void forward_avx2(const TriangularSolve<Entry>& s, int stride, double* y) {
  forward_any<4>(s, stride, y);
}
template <class Entry>
HVI_AVX512 void forward_avx512(const TriangularSolve<Entry>& s, int stride, double* y) {
  forward_any<8>(s, stride, y);
}
template <class Entry>
HVI_AVX2 void backward_avx2(const TriangularSolve<Entry>& s, int stride, double* x) {
  backward_any<4>(s, stride, x);
}
template <class Entry>
HVI_AVX512 void backward_avx512(const TriangularSolve<Entry>& s, int stride, double* x) {
  backward_any<8>(s, stride, x);
}

} // namespace

Supernodes::Supernodes(const cholmod_factor& l, int interior) {
  const auto [super, row_start, value_start, row] = arrays_of(l);
  for (std::size_t s = 0; s < l.nsuper && super[s] < interior; ++s) {
    const int first = static_cast<int>(super[s]);
    const int last = static_cast<int>(std::min<Long>(super[s + 1], interior));
    const int rows = static_cast<int>(row_start[s + 1] - row_start[s]);
    panels_.push_back(
        {first, last - first, rows, rows, static_cast<std::size_t>(value_start[s]), below_.size()});
    for (Long at = row_start[s] + (last - first); at < row_start[s + 1]; ++at)
      below_.push_back(static_cast<int>(row[at]));
    tallest_ = std::max(tallest_, rows);
  }
}

double Supernodes::nonzeros() const {
  double sum = 0.0;
  for (const Panel& panel : panels_)
    sum += panel.columns * (panel.rows - 0.5 * (panel.columns - 1.0));
  return sum;
}

/// It stays for the next solve: a step makes two or more of them.
double* Supernodes::work_for(int stride) {
  const auto size = static_cast<std::size_t>(tallest_) * static_cast<std::size_t>(stride);
  if (work_.size() < size) work_.resize(size);
  return work_.data();
}

template <class Entry>
void Supernodes::forward(const Entry* values, const double* inverse_diagonal, RightHandSides y) {
  const TriangularSolve<Entry> solve{panels_, below_.data(), values, inverse_diagonal,
                                     work_for(y.stride)};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return forward_avx512(solve, y.stride, y.values);
  case InstructionSet::avx2:
    return forward_avx2(solve, y.stride, y.values);
  case InstructionSet::baseline:
    return forward_any<4>(solve, y.stride, y.values);
  }
}

template <class Entry>
void Supernodes::backward(const Entry* values, const double* inverse_diagonal, RightHandSides x) {
  const TriangularSolve<Entry> solve{panels_, below_.data(), values, inverse_diagonal,
                                     work_for(x.stride)};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return backward_avx512(solve, x.stride, x.values);
  case InstructionSet::avx2:
    return backward_avx2(solve, x.stride, x.values);
  case InstructionSet::baseline:
    return backward_any<4>(solve, x.stride, x.values);
  }
}

template void Supernodes::forward(const double*, const double*, RightHandSides);
template void Supernodes::forward(const float*, const double*, RightHandSides);
template void Supernodes::backward(const double*, const double*, RightHandSides);
template void Supernodes::backward(const float*, const double*, RightHandSides);

} // namespace hvi::solver
