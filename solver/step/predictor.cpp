// Extrapolation over steps of one length; see predictor.hpp.
#include "solver/step/predictor.hpp"

#include "solver/linear/vector_stream.hpp"

#include <algorithm>

namespace hvi::solver {

void Predictor::note(const Vector& gamma, const Vector& d, Vector& kd, const Vector& xi) {
  gamma_ = gamma;
  newest_ = (newest_ + depth - 1) % depth;
  d_[newest_] = d;
  kd_[newest_].swap(kd);
  xi_[newest_] = xi;
  known_ = std::min(known_ + 1, depth);
}

void Predictor::predict(Vector& d) const { d = 3.0 * (back(d_, 0) - back(d_, 1)) + back(d_, 2); }

void Predictor::predict_gap(const Vector& rhs, Vector& gap) const {
  gap = rhs - 3.0 * (back(kd_, 0) - back(kd_, 1)) - back(kd_, 2);
}

void Predictor::predict_multipliers(Vector& xi) const { xi = 2.0 * back(xi_, 0) - back(xi_, 1); }

void Predictor::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(newest_);
  w.put(known_);
  put_vector(w, gamma_);
  for (const auto* of : {&d_, &kd_, &xi_})
    for (const Vector& v : *of) w.put(std::vector<double>(v.data(), v.data() + v.size()));
}

void Predictor::restore(std::istream& in, Eigen::Index n_unknowns, Eigen::Index n_rows) {
  StateReader r(in, {});
  newest_ = r.get_between(0, depth - 1);
  known_ = r.get_between(0, depth);
  get_vector(r, gamma_);
  for (auto* of : {&d_, &kd_, &xi_}) {
    for (Vector& v : *of) {
      const auto values = r.get_numbers();
      v = Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
    }
    for (int j = 0; j < known_; ++j)
      if (back(*of, j).size() != (of == &xi_ ? n_rows : n_unknowns)) r.fail("is inconsistent");
  }
}

} // namespace hvi::solver
