// See vector_stream.hpp.
#include "solver/linear/vector_stream.hpp"

namespace hvi::solver {

void put_vector(StateWriter& w, const Vector& v) {
  w.put(std::vector<double>(v.data(), v.data() + v.size()));
}

void get_vector(StateReader& r, Vector& v) {
  const auto values = r.get_vector<double>();
  v = Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void get_vector(StateReader& r, Vector& v, Eigen::Index size) {
  get_vector(r, v);
  if (v.size() != size || !v.allFinite()) r.fail("is inconsistent");
}

} // namespace hvi::solver
