// See own_matrices.hpp.
#include "solver/discrete/own_matrices.hpp"

#include "solver/discrete/distinct_forms.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <sstream>
#include <utility>

namespace hvi::solver {
namespace {

std::vector<SparseMatrix> assemble_all(const OwnCells& cells, std::span<const FormTerm> forms) {
  std::vector<const FormTerm*> terms;
  for (const FormTerm& form : forms) terms.push_back(&form);
  return assemble_terms(cells.discretisation, cells.layout, terms, 1);
}

/// The sum of the forms in u'', with the rows of moved mass in the places of its own.
SparseMatrix own_inertia(const OwnCells& cells, const DealtForms& forms) {
  SparseMatrix out(cells.layout.n_unknowns, cells.layout.n_state);
  for (const SparseMatrix& one : assemble_all(cells, forms.inertia)) out = SparseMatrix(out + one);
  std::vector<char> is_moved(static_cast<std::size_t>(out.rows()), 0);
  for (const auto row : forms.moved.rows) is_moved[row] = 1;
  out.prune([&](Eigen::Index row, Eigen::Index, double) { return is_moved[row] == 0; });
  return SparseMatrix(out + forms.moved.matrix);
}

void put_placed(StateWriter& w, const OwnEntries& entries, std::span<const std::int32_t> place,
                int first, int end, const Space& space, const StateLayout& layout) {
  PlacedRows placed{first, end - first, {}};
  for (const auto entry : entries.state) {
    placed.column.push_back(place[entry]);
    if (space.is_product())
      placed.of_unknown.push_back(
          static_cast<std::uint8_t>(space.block_of(layout.dof_of[entry] % space.components)));
  }
  w.put(placed.first);
  w.put(placed.count);
  w.put(placed.column);
  w.put(placed.of_unknown);
}

PlacedRows get_placed(StateReader& r) {
  PlacedRows out;
  out.first = r.get<int>();
  out.count = r.get<int>();
  out.column = r.get_vector<std::int32_t>();
  out.of_unknown = r.get_vector<std::uint8_t>();
  return out;
}

/// Of the forms that no states change; `forms` gets the weights of these matrices.
std::vector<SparseMatrix> constant_matrices(const OwnCells& cells, DealtForms& forms) {
  auto out = assemble_all(cells, forms.terms);
  if (!forms.inertia.empty()) {
    out.push_back(own_inertia(cells, forms));
    forms.weights.push_back(Vector::Unit(forms.n_fields, field_of_u(2)));
  }
  take_apart(forms.couplings, cells.discretisation.space, cells.layout, out);
  merge_equal_weights(out, forms.weights);
  return out;
}

/// Appends the matrices of the forms that states change, and their weights; null: there are none.
std::unique_ptr<OwnChangingForms> changing_forms(std::unique_ptr<const OwnCells> cells,
                                                 DealtForms& forms,
                                                 std::vector<SparseMatrix>& matrices) {
  if (forms.changing.empty()) return nullptr;
  const auto first = static_cast<int>(matrices.size());
  std::vector<FormTerm> initial;
  for (const ChangingTerm& term : forms.changing) initial.push_back(term.initial);
  auto made = assemble_all(*cells, initial);
  matrices.insert(matrices.end(), made.begin(), made.end());
  forms.weights.insert(forms.weights.end(), forms.weights_of_changing.begin(),
                       forms.weights_of_changing.end());
  return std::make_unique<OwnChangingForms>(std::move(cells), std::move(forms.changing),
                                            std::move(made), first);
}

/// Room for so many numbers, as an answer.
std::string room_for(std::size_t numbers) { return std::string(numbers * sizeof(double), '\0'); }

std::span<double> numbers_of(std::string& answer) {
  return {reinterpret_cast<double*>(answer.data()), answer.size() / sizeof(double)};
}

std::string failed(const Failure& failure) {
  std::ostringstream out;
  StateWriter w(out);
  w.put(true);
  w.put(failure.kind);
  w.put(failure.origin);
  put_text(w, failure.what());
  put_text(w, failure.help);
  return std::move(out).str();
}

std::string made(const std::vector<Vector>& weights) {
  std::ostringstream out;
  StateWriter w(out);
  w.put(false);
  w.put(static_cast<int>(weights.size()));
  for (const Vector& of : weights) put_vector(w, of);
  return std::move(out).str();
}

/// What these rows make of an errand's numbers.
std::string answer_of(OwnRows& rows, const MatrixErrand& errand, std::span<const double> numbers) {
  const auto n = static_cast<std::size_t>(rows.rows());
  std::string out;
  switch (errand.what) {
  case MatrixErrand::products:
    out = room_for(2 * n);
    rows.products(errand.matrix, numbers, numbers_of(out));
    break;
  case MatrixErrand::precisely:
    out = room_for(3 * n);
    rows.precisely(errand.matrix, numbers, numbers_of(out));
    break;
  case MatrixErrand::magnitudes:
    out = room_for(n);
    rows.magnitudes(errand.matrix, numbers, numbers_of(out));
    break;
  case MatrixErrand::diagonal:
    out = room_for(n);
    rows.diagonal(errand.matrix, numbers_of(out));
    break;
  case MatrixErrand::transposed:
    out = room_for(2 * static_cast<std::size_t>(rows.columns()));
    rows.transposed(errand.matrix, numbers, numbers_of(out));
    break;
  case MatrixErrand::asymmetry: {
    const std::vector<double> found = rows.asymmetry(errand.matrix);
    out = room_for(found.size());
    std::ranges::copy(found, numbers_of(out).begin());
    break;
  }
  case MatrixErrand::sum:
    rows.combine(errand.matrix, numbers);
    break;
  case MatrixErrand::stiffen:
    rows.stiffen(errand.matrix, numbers);
    break;
  case MatrixErrand::place:
    rows.place(errand.matrix, errand.number);
    break;
  case MatrixErrand::leave:
    rows.leave(errand.matrix);
    break;
  case MatrixErrand::rounding: {
    out = room_for((n_samples + 1) * n);
    const auto columns = static_cast<std::size_t>(rows.columns());
    rounding_of_rows(rows, errand.matrix, numbers.first(columns), numbers.subspan(columns),
                     errand.number, numbers_of(out));
    break;
  }
  case MatrixErrand::forget:
    rows.forget(errand.matrix);
    break;
  case MatrixErrand::assemble:
  case MatrixErrand::states:
  case MatrixErrand::end: // of sets
    break;
  }
  return out;
}

} // namespace

std::string message_of(const MatrixErrand& errand, std::string_view bytes) {
  std::string out;
  out.reserve(sizeof errand + bytes.size());
  out.append(reinterpret_cast<const char*>(&errand), sizeof errand).append(bytes);
  return out;
}

std::string message_of(const MatrixErrand& errand, std::span<const double> numbers) {
  return message_of(errand, std::string_view(reinterpret_cast<const char*>(numbers.data()),
                                             numbers.size_bytes()));
}

std::span<const double> numbers_in(std::string_view answer) {
  return {reinterpret_cast<const double*>(answer.data()), answer.size() / sizeof(double)};
}

std::vector<Vector> assembled(std::string_view answer) {
  std::istringstream in{std::string(answer)};
  StateReader r(in, {});
  if (r.get<bool>()) {
    const auto kind = r.get<FailureKind>();
    const auto origin = r.get<Origin>();
    const std::string what = get_text(r), help = get_text(r);
    throw Failure(kind, origin, what, help);
  }
  std::vector<Vector> out(static_cast<std::size_t>(r.get<int>()));
  for (Vector& of : out) get_vector(r, of);
  return out;
}

OwnEntries put_assembly(StateWriter& w, const Discretisation& discretisation,
                        const StateLayout& layout, std::span<const std::int32_t> part_of_node,
                        int p, std::span<const std::int32_t> place, std::span<const int> first_row,
                        const DealtForms& forms) {
  std::vector<int> parts;
  for (const FormTerm& form : forms.terms) parts.push_back(form.part);
  for (const FormTerm& form : forms.inertia) parts.push_back(form.part);
  for (const ChangingTerm& term : forms.changing) parts.push_back(term.form.part);
  const auto also = columns_of_moved(forms.moved, discretisation.space, layout, part_of_node, p);
  OwnEntries out = put_own_cells(w, discretisation, layout, part_of_node, p, parts, also);
  put_placed(w, out, place, first_row[p], first_row[p + 1], discretisation.space, layout);
  put_forms(w, forms);
  put_moved(w, forms.moved, out, layout.n_state);
  return out;
}

std::string OwnMatrices::assemble(std::uint64_t set, std::string_view bytes) {
  try {
    std::istringstream in{std::string(bytes)};
    StateReader r(in, {});
    auto cells = std::make_unique<OwnCells>();
    get_own_cells(r, *cells);
    PlacedRows placed = get_placed(r);
    DealtForms forms = get_forms(r);
    forms.moved = get_moved(r, cells->layout);
    auto matrices = constant_matrices(*cells, forms);
    auto changing = changing_forms(std::move(cells), forms, matrices);
    sets_.erase(set);
    sets_.emplace(set, Set{OwnRows(std::move(matrices), std::move(placed)), std::move(changing)});
    return made(forms.weights);
  } catch (const Failure& failure) {
    return failed(failure);
  }
}

std::string OwnMatrices::take_states(Set& of, std::span<const double> values) {
  try {
    of.changing->take(values, of.rows);
    return made({});
  } catch (const Failure& failure) {
    return failed(failure);
  }
}

std::string OwnMatrices::answer(std::string_view message) {
  MatrixErrand errand;
  if (message.size() < sizeof errand) return {};
  std::memcpy(&errand, message.data(), sizeof errand);
  const std::string_view rest = message.substr(sizeof errand);
  if (errand.what == MatrixErrand::assemble) return assemble(errand.set, rest);
  if (errand.what == MatrixErrand::states)
    return take_states(sets_.at(errand.set), numbers_in(rest));
  if (errand.what != MatrixErrand::end)
    return answer_of(sets_.at(errand.set).rows, errand, numbers_in(rest));
  sets_.erase(errand.set);
  return {};
}

double OwnMatrices::bytes() const {
  double out = 0.0;
  for (const auto& [set, of] : sets_) out += of.rows.bytes();
  return out;
}

} // namespace hvi::solver
