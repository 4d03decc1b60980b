// See dealt_forms.hpp.
#include "solver/discrete/dealt_forms.hpp"

#include "solver/kernel/expr_stream.hpp"
#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

/// Of a form what its assembly reads.
void put_form(StateWriter& w, const FormTerm& form, std::vector<Expr>& coefficients) {
  w.put(form.origin);
  w.put(form.part);
  w.put(form.field);
  w.put(form.rule);
  w.put(static_cast<int>(form.entries.size()));
  for (const FormTerm::Entry& entry : form.entries) {
    w.put(entry.test);
    w.put(entry.trial);
    coefficients.push_back(entry.coefficient);
  }
}

FormTerm get_form(StateReader& r) {
  FormTerm out;
  out.origin = r.get<Origin>();
  out.part = r.get<int>();
  out.field = r.get<int>();
  out.rule = r.get<Rule>();
  out.entries.resize(static_cast<std::size_t>(r.get<int>()));
  for (FormTerm::Entry& entry : out.entries) {
    entry.test = r.get<int>();
    entry.trial = r.get<int>();
  }
  return out;
}

void put_reading(StateWriter& w, const StateReading& reading) {
  w.put(reading.uniform);
  w.put(reading.rule);
  w.put(reading.states);
  w.put(reading.time);
}

StateReading get_reading(StateReader& r) {
  StateReading out;
  out.uniform = r.get<bool>();
  out.rule = r.get<Rule>();
  out.states = r.get_vector<Slot>();
  out.time = r.get<int>();
  return out;
}

} // namespace

void put_forms(StateWriter& w, const DealtForms& forms) {
  std::vector<Expr> coefficients;
  w.put(forms.couplings);
  w.put(forms.n_fields);
  w.put(static_cast<int>(forms.terms.size()));
  for (std::size_t f = 0; f < forms.terms.size(); ++f) {
    put_form(w, forms.terms[f], coefficients);
    put_vector(w, forms.weights[f]);
  }
  w.put(static_cast<int>(forms.inertia.size()));
  for (const FormTerm& form : forms.inertia) put_form(w, form, coefficients);
  w.put(static_cast<int>(forms.changing.size()));
  for (std::size_t f = 0; f < forms.changing.size(); ++f) {
    put_form(w, forms.changing[f].form, coefficients);
    put_form(w, forms.changing[f].initial, coefficients);
    put_reading(w, forms.changing[f].reading);
    put_vector(w, forms.weights_of_changing[f]);
  }
  put_expressions(w, coefficients);
}

/// The coefficients follow all forms, for they have nodes in common.
DealtForms get_forms(StateReader& r) {
  DealtForms out;
  out.couplings = r.get<Couplings>();
  out.n_fields = r.get<int>();
  for (int left = r.get<int>(); left > 0; --left) {
    out.terms.push_back(get_form(r));
    get_vector(r, out.weights.emplace_back());
  }
  for (int left = r.get<int>(); left > 0; --left) out.inertia.push_back(get_form(r));
  for (int left = r.get<int>(); left > 0; --left) {
    ChangingTerm& term = out.changing.emplace_back();
    term.form = get_form(r);
    term.initial = get_form(r);
    term.reading = get_reading(r);
    get_vector(r, out.weights_of_changing.emplace_back());
  }
  const std::vector<Expr> coefficients = get_expressions(r);
  std::size_t next = 0;
  const auto take = [&](FormTerm& form) {
    for (FormTerm::Entry& entry : form.entries) entry.coefficient = coefficients.at(next++);
  };
  std::ranges::for_each(out.terms, take);
  std::ranges::for_each(out.inertia, take);
  for (ChangingTerm& term : out.changing) take(term.form), take(term.initial);
  return out;
}

void put_moved(StateWriter& w, const MovedMass& moved, const OwnEntries& entries, int n_state) {
  std::vector<std::int32_t> here(static_cast<std::size_t>(n_state), -1);
  for (std::size_t k = 0; k < entries.state.size(); ++k)
    here[entries.state[k]] = static_cast<std::int32_t>(k);
  std::vector<std::int32_t> rows, row, column;
  std::vector<double> value;
  for (const auto whole : moved.rows) {
    if (here[whole] < 0 || here[whole] >= entries.unknowns) continue;
    rows.push_back(here[whole]);
    for (SparseMatrix::InnerIterator it(moved.matrix, whole); it; ++it) {
      row.push_back(here[whole]);
      column.push_back(here[it.col()]);
      value.push_back(it.value());
    }
  }
  w.put(rows);
  w.put(row);
  w.put(column);
  w.put(value);
}

MovedMass get_moved(StateReader& r, const StateLayout& layout) {
  MovedMass out{r.get_vector<std::int32_t>(), SparseMatrix(layout.n_unknowns, layout.n_state)};
  const auto row = r.get_vector<std::int32_t>();
  const auto column = r.get_vector<std::int32_t>(row.size());
  const auto value = r.get_vector<double>(row.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < row.size(); ++k) entries.emplace_back(row[k], column[k], value[k]);
  out.matrix.setFromTriplets(entries.begin(), entries.end());
  return out;
}

std::vector<std::int32_t> columns_of_moved(const MovedMass& moved, const Space& space,
                                           const StateLayout& layout,
                                           std::span<const std::int32_t> part_of_node, int p) {
  std::vector<std::int32_t> out;
  for (const auto row : moved.rows) {
    if (part_of_node[layout.dof_of[row] / space.components] != p) continue;
    for (SparseMatrix::InnerIterator it(moved.matrix, row); it; ++it)
      out.push_back(static_cast<std::int32_t>(it.col()));
  }
  return out;
}

} // namespace hvi::solver
