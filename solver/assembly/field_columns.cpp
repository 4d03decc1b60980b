// Values of finite element fields at blocks of points.
#include "solver/assembly/field_columns.hpp"

namespace hvi::solver {

FieldColumns::FieldColumns(const Space& space, std::span<const Slot> slots) : space_(space) {
  for (const Slot slot : slots) {
    if (!slot::is_field(slot)) {
      continue;
    }
    const int field = slot::field_of(slot), index = slot::derivative_of(slot);
    columns_.push_back({slot, field, decode(space, index, Origin{}), {}});
    gradients_ = gradients_ || !slot::is_value(index);
  }
}

void FieldColumns::fill(const PointBlock& block, const FieldValues& values) {
  vectors_.clear();
  for (Column& column : columns_) {
    const auto k = static_cast<std::size_t>(column.field);
    const Vector* vector = k < values.fields.size() ? values.fields[k] : nullptr;
    if (!vector || vector->size() != space_.n_dofs()) {
      throw Failure(FailureKind::bad_value, Origin{},
                    describe_slot(column.slot) + " has no value here");
    }
    vectors_.push_back(vector);
    column.values.resize(block.size());
  }
  if (columns_.empty()) {
    return;
  }
  ShapeTable shapes;
  CellGeometry geometry;
  int cell = -1;
  for (std::size_t p = 0; p < block.size(); ++p) {
    if (gradients_ && block.cell[p] != cell) {
      geometry = cell_geometry(*space_.mesh, block.cell[p]);
    }
    cell = block.cell[p];
    evaluate_shapes(space_, geometry, block.barycentric[p], gradients_, shapes);
    const auto nodes = space_.nodes_of_cell(cell);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Derivative d = columns_[c].derivative;
      const double* shape = shapes.row(d.row);
      const double* u = vectors_[c]->data() + d.component;
      double sum = 0.0;
      for (int i = 0; i < shapes.size; ++i) {
        sum += shape[i] * u[nodes[i] * space_.components];
      }
      columns_[c].values[p] = sum;
    }
  }
}

const double* FieldColumns::column(Slot slot) const {
  for (const Column& column : columns_) {
    if (column.slot == slot) {
      return column.values.data();
    }
  }
  return nullptr;
}

FieldTape::FieldTape(const Space& space, std::span<const Expr> expressions)
    : tape_(expressions), columns_(space, tape_.inputs()), outputs_(expressions.size()) {}

void FieldTape::evaluate(const PointBlock& block, const FieldValues& values,
                         std::vector<double>& out) {
  columns_.fill(block, values);
  out.resize(block.size() * outputs_);
  tape_.evaluate(block, values.t, Origin{}, out,
                 [this](Slot slot) { return columns_.column(slot); });
}

} // namespace hvi::solver
