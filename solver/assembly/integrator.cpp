// Integrals of expressions of fields, prepared once and evaluated at every step.
//
// An integrand affine in the fields, a . D(u) + b with a and b independent of time (forces and
// reactions are), becomes a sparse weight vector: one dot product per step. Everything else runs
// through the tape over the quadrature points.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/degree.hpp"
#include "solver/assembly/field_columns.hpp"

#include <algorithm>
#include <map>

namespace hvi::solver {
namespace {

bool has_fields(const Expr& e) {
  return e.depends_on_any(slot::first_field, slot::first_multiplier);
}

/// Affine in the fields by structure (a derivative alone would take sign(u) for affine).
bool is_affine(const Expr& e) {
  if (!has_fields(e) || e.op() == Op::slot) {
    return true;
  }
  const auto args = e.args();
  switch (e.op()) {
  case Op::add:
    return is_affine(args[0]) && is_affine(args[1]);
  case Op::neg:
    return is_affine(args[0]);
  case Op::mul:
    return (!has_fields(args[0]) && is_affine(args[1])) ||
           (!has_fields(args[1]) && is_affine(args[0]));
  case Op::div:
    return !has_fields(args[1]) && is_affine(args[0]);
  case Op::select:
    return !has_fields(args[0]) && is_affine(args[1]) && is_affine(args[2]);
  default:
    return false;
  }
}

/// e = sum_s coefficient_s D_s + rest.
struct AffineParts {
  std::vector<Slot> slots;
  std::vector<Expr> coefficients; ///< of the slots, then the rest as the last one
};

bool split_affine(const Expr& e, AffineParts& parts) {
  if (!is_affine(e)) {
    return false;
  }
  std::vector<std::pair<Slot, Expr>> zero;
  for (const Slot slot : slots_of(e)) {
    if (!slot::is_field(slot)) {
      continue;
    }
    parts.slots.push_back(slot);
    parts.coefficients.push_back(derivative(e, slot));
    zero.emplace_back(slot, Expr(0.0));
  }
  parts.coefficients.push_back(substitute(e, zero));
  return std::none_of(parts.coefficients.begin(), parts.coefficients.end(),
                      [](const Expr& c) { return c.depends_on(slot::t) || has_fields(c); });
}

/// constant + sum over fields k of weights_k . u_k
struct LinearIntegral {
  double constant = 0.0;
  std::map<int, Eigen::SparseVector<double>> weights;

  double value(const FieldValues& values) const {
    double sum = constant;
    for (const auto& [field, weight] : weights) {
      const auto k = static_cast<std::size_t>(field);
      const Vector* vector = k < values.fields.size() ? values.fields[k] : nullptr;
      if (!vector || vector->size() != weight.size()) {
        throw Failure(FailureKind::bad_value, Origin{},
                      describe_slot(slot::field(field, 0)) + " has no value here");
      }
      sum += weight.dot(*vector);
    }
    return sum;
  }
};

LinearIntegral assemble_linear(const Space& space, const RegionPoints& points,
                               const AffineParts& parts) {
  LinearIntegral out;
  std::map<int, Vector> dense;
  std::vector<Derivative> derivatives;
  for (const Slot slot : parts.slots) {
    derivatives.push_back(decode(space, slot::derivative_of(slot), Origin{}));
    dense.try_emplace(slot::field_of(slot), Vector::Zero(space.n_dofs()));
  }
  Pointwise tape(parts.coefficients);
  std::vector<double> a;
  ShapeTable shapes;
  points.for_blocks([&](const PointBlock& block) {
    const std::size_t n = block.size();
    a.resize(n * parts.coefficients.size());
    tape.evaluate(block, 0.0, Origin{}, a);
    for (std::size_t p = 0; p < n; ++p) {
      out.constant += block.weight[p] * a[parts.slots.size() * n + p];
      const auto nodes = space.nodes_of_cell(block.cell[p]);
      evaluate_shapes(space, cell_geometry(*space.mesh, block.cell[p]), block.barycentric[p], true,
                      shapes);
      for (std::size_t s = 0; s < parts.slots.size(); ++s) {
        Vector& to = dense[slot::field_of(parts.slots[s])];
        const double w = block.weight[p] * a[s * n + p];
        for (int i = 0; i < shapes.size; ++i) {
          to[space.dof(nodes[i], derivatives[s].component)] += w * shapes.at(derivatives[s].row, i);
        }
      }
    }
  });
  for (const auto& [field, vector] : dense) {
    out.weights[field] = vector.sparseView();
  }
  return out;
}

} // namespace

struct Integrator::Impl {
  struct Batch {
    RegionPoints points;
    FieldTape tape;
    std::vector<std::size_t> outputs; ///< which integrand each output is
  };
  std::vector<std::pair<std::size_t, LinearIntegral>> linear;
  std::vector<Batch> batch; ///< at most one
  std::vector<double> values;
};

Integrator::Integrator(const Space& space, const Region& region, Rule rule,
                       std::vector<Expr> integrands)
    : impl_(std::make_unique<Impl>()) {
  std::vector<Expr> rest;
  std::vector<std::size_t> outputs;
  int rest_degree = 0;
  for (std::size_t k = 0; k < integrands.size(); ++k) {
    const Expr& e = integrands[k];
    const int degree = exact_degree(e, 0, space.order);
    AffineParts parts;
    if (split_affine(e, parts)) {
      const RegionPoints points(space, region, rule, degree);
      impl_->linear.emplace_back(k, assemble_linear(space, points, parts));
    } else {
      rest.push_back(e);
      outputs.push_back(k);
      rest_degree = std::max(rest_degree, degree);
    }
  }
  if (!rest.empty()) {
    impl_->batch.push_back(
        {RegionPoints(space, region, rule, rest_degree), FieldTape(space, rest), outputs});
  }
}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;

void Integrator::integrate(const FieldValues& values, std::span<double> out) const {
  std::fill(out.begin(), out.end(), 0.0);
  for (const auto& [k, integral] : impl_->linear) {
    out[k] = integral.value(values);
  }
  for (auto& batch : impl_->batch) {
    batch.points.for_blocks([&](const PointBlock& block) {
      batch.tape.evaluate(block, values, impl_->values);
      for (std::size_t o = 0; o < batch.outputs.size(); ++o) {
        double sum = 0.0;
        for (std::size_t p = 0; p < block.size(); ++p) {
          sum += block.weight[p] * impl_->values[o * block.size() + p];
        }
        out[batch.outputs[o]] += sum;
      }
    });
  }
}

} // namespace hvi::solver
