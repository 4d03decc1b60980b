// The rows that several processes assemble on their own cells, against the whole matrices.
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/contact.hpp"
#include "solver/discrete/dealt_operators.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/discrete/own_matrices.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/linear/double_double.hpp"
#include "solver/linear/matrix_rows.hpp"
#include "tests/solver/time/plans.hpp"

#include <map>
#include <numeric>
#include <sstream>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// A plan dealt out to some processes, all of which are here.
class Dealt {
public:
  Dealt(const Plan& plan, int processes) : processes_(processes) {
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    layout = make_layout(d.space, d.dofs);
    const DealtForms forms = forms_to_deal(plan.problem, d, layout);
    const auto part = parts_of_nodes(d.space, layout, processes);
    std::vector<int> first(static_cast<std::size_t>(processes) + 1, 0); // rows as unknowns are
    for (int i = 0; i < layout.n_unknowns; ++i)
      ++first[part[layout.dof_of[i] / d.space.components] + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    place.assign(static_cast<std::size_t>(layout.n_state), -1);
    std::vector<int> next(first.begin(), first.end() - 1);
    for (int i = 0; i < layout.n_unknowns; ++i)
      place[i] = next[part[layout.dof_of[i] / d.space.components]]++;
    others_.resize(static_cast<std::size_t>(processes));
    for (int p = 0; p < processes; ++p) {
      std::ostringstream out;
      StateWriter w(out);
      of_.push_back(put_assembly(w, d, layout, part, p, place, first, forms));
      weights = assembled(ask(p, {1, MatrixErrand::assemble}, std::move(out).str()));
    }
  }

  /// Blocks of numbers by unknown, as the processes answer.
  std::vector<Vector> ask(MatrixErrand errand, const std::vector<Vector>& columns) {
    errand.set = 1;
    std::vector<Vector> out;
    for (int p = 0; p < processes_; ++p) {
      std::vector<double> numbers;
      for (const Vector& x : columns)
        for (const auto entry : of_[p].state) numbers.push_back(entry < x.size() ? x[entry] : 0.0);
      const std::string answer = others_[p].answer(message_of(errand, numbers));
      const auto said = numbers_in(answer);
      const auto n = static_cast<std::size_t>(of_[p].unknowns);
      if (n == 0) continue;
      out.resize(said.size() / n, Vector::Zero(layout.n_unknowns));
      for (std::size_t k = 0; k < said.size(); ++k) out[k / n][of_[p].state[k % n]] = said[k];
    }
    return out;
  }
  void ask_all(MatrixErrand errand, const std::vector<double>& numbers) {
    errand.set = 1;
    for (auto& other : others_) other.answer(message_of(errand, numbers));
  }
  /// What one process answers.
  std::vector<double> numbers_of(int p, MatrixErrand errand, std::span<const double> numbers = {}) {
    errand.set = 1;
    const std::string answer = others_[p].answer(message_of(errand, numbers));
    const auto said = numbers_in(answer);
    return {said.begin(), said.end()};
  }
  /// States become these: by process what OwnChangingForms::take is to have.
  std::string take_states(int p, const std::vector<double>& values) {
    return others_[p].answer(message_of({1, MatrixErrand::states}, values));
  }
  const std::vector<std::int32_t>& cells(int p) const { return of_[p].cells; }
  int entry(int p, double here) const { return of_[p].state[static_cast<std::size_t>(here)]; }
  /// y += what the rows of process p add to A^T x.
  void add_transposed(int p, int matrix, const Vector& x, Vector& y) {
    std::vector<double> own;
    for (int i = 0; i < of_[p].unknowns; ++i) own.push_back(x[of_[p].state[i]]);
    const auto said = numbers_of(p, {0, MatrixErrand::transposed, matrix}, own);
    for (std::size_t j = 0; j < of_[p].state.size(); ++j)
      if (of_[p].state[j] < y.size()) y[of_[p].state[j]] += said[j];
  }
  RowArrays placed(int p, int matrix) const { return others_[p].placed(1, matrix); }
  /// The matrix of a field, column by column.
  DenseMatrix matrix(int field) {
    DenseMatrix out = DenseMatrix::Zero(layout.n_unknowns, layout.n_state);
    for (int j = 0; j < layout.n_state; ++j)
      for (std::size_t b = 0; b < weights.size(); ++b)
        out.col(j) += weights[b][field] * ask({0, MatrixErrand::products, static_cast<int>(b)},
                                              {Vector::Unit(layout.n_state, j)})[0];
    return out;
  }

  Discretisation d;
  StateLayout layout;
  std::vector<Vector> weights;
  std::vector<std::int32_t> place;

private:
  std::string ask(int p, const MatrixErrand& errand, const std::string& bytes) {
    return others_[p].answer(message_of(errand, bytes));
  }
  int processes_;
  std::vector<OwnMatrices> others_;
  std::vector<OwnEntries> of_;
};

SparseMatrix whole(const Plan& plan, const Dealt& dealt, int field) {
  const Operators operators = assemble_operators(plan.problem, dealt.d, dealt.layout, 1);
  SparseMatrix out = operators.weights(field, 0) * operators.bases[0];
  for (int b = 1; b < operators.n_bases(); ++b)
    out = SparseMatrix(out + operators.weights(field, b) * operators.bases[b]);
  return out;
}

FormTerm springs(int part, const Expr& stiffness) {
  FormTerm out;
  out.part = part;
  out.field = field_of_u(0);
  for (int i = 0; i < 2; ++i) out.entries.push_back({slot::value(i), slot::value(i), stiffness});
  return out;
}

/// Stiffnesses that change with the place and from part to part, springs on facets and at a node.
Plan uneven_slab(int dim, int order) {
  Plan plan = slab(dim == 2 ? 4 : 2, 2, dim);
  plan.problem.space.order = order;
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  for (auto& entry : plan.problem.forms[0].entries)
    entry.coefficient = entry.coefficient * (1.0 + x * y);
  for (auto& entry : plan.problem.forms[1].entries)
    entry.coefficient = entry.coefficient * (1.0 + exp(-x) + 2.0 * var(slot::inside(flank)));
  plan.problem.forms.push_back(springs(ground, 3.0 + sin(x)));
  plan.problem.forms.push_back(springs(flank, 7.0));
  plan.problem.space.dirichlet = {
      clamp(roof, -1, std::vector<Expr>(static_cast<std::size_t>(dim), var(slot::t) * 0.1))};
  return plan;
}

TEST(OwnMatrices, RowsAreThoseOfTheWholeMatrix) {
  for (const auto& [dim, order] :
       {std::pair(2, 1), std::pair(2, 2), std::pair(3, 1), std::pair(3, 2)}) {
    const Plan plan = uneven_slab(dim, order);
    for (const int processes : {1, 2, 3, 5}) {
      Dealt dealt(plan, processes);
      EXPECT_GT(dealt.layout.n_state, dealt.layout.n_unknowns);
      for (const int field : {field_of_u(0), field_of_u(1), field_of_memory(0)}) {
        const DenseMatrix all = DenseMatrix(whole(plan, dealt, field));
        EXPECT_LE((dealt.matrix(field) - all).lpNorm<Eigen::Infinity>(),
                  1e-14 * all.lpNorm<Eigen::Infinity>())
            << dim << "D, P" << order << ", " << processes << " processes, field " << field;
      }
    }
  }
}

// Whatever the number of processes, a checkpoint has the coefficients of the same matrices.
TEST(OwnMatrices, MatricesThatHappenToBeMultiplesStayApart) {
  Plan plan = slab(3, 2);
  plan.problem.parts.push_back(plan.problem.parts[body]);
  plan.problem.parts.back().name = "all";
  plan.problem.forms = {elastic(2, body, field_of_u(1), {5, 10}),
                        elastic(2, 4, field_of_u(0), {50, 100})};
  plan.problem.histories.clear();
  Dealt dealt(plan, 2);
  EXPECT_EQ(dealt.weights.size(), 2u);
  EXPECT_EQ(assemble_operators(plan.problem, dealt.d, dealt.layout, 1, false).n_bases(), 2);
  EXPECT_EQ(assemble_operators(plan.problem, dealt.d, dealt.layout, 1).n_bases(), 1);
}

// A row is the sum over the same cells in the same order.
TEST(OwnMatrices, OneFormHasTheSameBits) {
  Plan plan = uneven_slab(2, 2);
  plan.problem.forms = {plan.problem.forms[1]};
  Dealt dealt(plan, 3);
  EXPECT_EQ(dealt.matrix(field_of_u(0)), DenseMatrix(whole(plan, dealt, field_of_u(0))));
}

TEST(OwnMatrices, RingsToo) {
  Plan plan = uneven_slab(2, 1);
  plan.problem.mesh.axisymmetric = true;
  plan.problem.space.dirichlet = {clamp(roof)};
  plan.problem.forms = {plan.problem.forms[0], plan.problem.forms[3]};
  Dealt dealt(plan, 2);
  for (const int field : {field_of_u(0), field_of_u(1)})
    EXPECT_LE((dealt.matrix(field) - DenseMatrix(whole(plan, dealt, field))).norm(),
              1e-14 * whole(plan, dealt, field).norm());
}

TEST(OwnMatrices, MoreProcessesThanNodes) {
  Plan plan = slab(1, 2);
  Dealt dealt(plan, 9);
  EXPECT_LE((dealt.matrix(field_of_u(0)) - DenseMatrix(whole(plan, dealt, field_of_u(0)))).norm(),
            1e-14 * whole(plan, dealt, field_of_u(0)).norm());
}

TEST(OwnMatrices, SumsSizesAndRoundingAreThoseOfTheWholeMatrix) {
  const Plan plan = slab(4, 2);
  Dealt dealt(plan, 3);
  const Operators operators = assemble_operators(plan.problem, dealt.d, dealt.layout, 1);
  ASSERT_EQ(dealt.weights.size(), 2u);
  ASSERT_EQ(operators.n_bases(), 2);
  Vector gamma(2);
  gamma << 3.5, -0.25;
  dealt.ask_all({0, MatrixErrand::sum, 2}, {gamma[0], gamma[1]});
  const SparseMatrix k = combine(operators, gamma);
  const Vector x = Vector::Random(k.rows());
  const auto of = dealt.ask({0, MatrixErrand::products, 2}, {x});
  ASSERT_EQ(of.size(), 2u);
  const double scale = k.norm();
  EXPECT_LE((of[0] - k * x).lpNorm<Eigen::Infinity>(), 1e-14 * scale);
  const HeldRows held(k, {});
  Vector magnitude;
  held.apply_magnitude(x, magnitude);
  EXPECT_LE(
      (dealt.ask({0, MatrixErrand::magnitudes, 2}, {x})[0] - magnitude).lpNorm<Eigen::Infinity>(),
      1e-14 * scale);
  const auto whole_size = held.whole_sizes(x);
  for (int i = 0; i < k.rows(); ++i) EXPECT_NEAR(of[1][i], whole_size(i), 1e-14 * scale);
  EXPECT_LE((dealt.ask({0, MatrixErrand::diagonal, 2}, {})[0] - k.diagonal()).norm(),
            1e-14 * scale);

  RoundingForces forces;
  forces.fill(Vector::Zero(k.rows()));
  Vector size = Vector::Zero(k.rows());
  add_rounding(operators.bases[0], x, 0x1p-52, forces, size);
  const Vector sizes = operators.bases[0].diagonal().cwiseAbs().cwiseSqrt();
  const auto random = dealt.ask({0, MatrixErrand::rounding, 0, 0x1p-52}, {x, sizes});
  ASSERT_EQ(random.size(), n_samples + 1);
  for (std::size_t s = 0; s < n_samples; ++s)
    EXPECT_LE((random[s] - forces[s]).norm(), 1e-13 * forces[s].norm());
  EXPECT_LE((random[n_samples] - size).norm(), 1e-14 * size.norm());
}

TEST(OwnMatrices, PlacedRowsAreInTheOrderOfTheProcesses) {
  const Plan plan = slab(3, 2);
  Dealt dealt(plan, 2);
  const Operators operators = assemble_operators(plan.problem, dealt.d, dealt.layout, 1);
  dealt.ask_all({0, MatrixErrand::place, 1, 5.0}, {});
  int row = 0;
  for (int p = 0; p < 2; ++p) {
    const RowArrays rows = dealt.placed(p, 1);
    for (int i = 0; i < rows.rows; ++i, ++row) {
      const auto unknown = std::ranges::find(dealt.place, row) - dealt.place.begin();
      for (int e = rows.start[i]; e < rows.start[i + 1]; ++e) {
        const auto other = std::ranges::find(dealt.place, rows.column[e]) - dealt.place.begin();
        EXPECT_EQ(rows.value[e], operators.bases[1].coeff(unknown, other));
        EXPECT_TRUE(e == rows.start[i] || rows.column[e - 1] < rows.column[e]);
      }
    }
  }
  EXPECT_EQ(row, dealt.layout.n_unknowns);
}

// What an assembly meets with comes back with its place in the script.
TEST(OwnMatrices, FailuresComeBack) {
  Plan plan = slab(2, 2);
  plan.problem.forms[1].origin = {42};
  for (auto& entry : plan.problem.forms[1].entries) entry.coefficient = log(var(slot::x(0)) - 1.0);
  try {
    const Dealt dealt(plan, 2);
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::bad_value);
    EXPECT_EQ(failure.origin, Origin{42});
  }
}

// Which entry has its mirror image where is asked of all processes together.
TEST(OwnMatrices, EntriesWithoutMirrorImagesAreFound) {
  Plan plan = slab(3, 2);
  for (const double more : {0.0, 1e-6}) {
    plan.problem.forms[1].entries.push_back({slot::value(0), slot::value(1), Expr(more)});
    for (const int processes : {1, 3}) {
      Dealt dealt(plan, processes);
      double apart = 0.0;
      std::map<std::pair<int, int>, double> alone;
      for (int p = 0; p < processes; ++p) {
        const auto found = dealt.numbers_of(p, {0, MatrixErrand::asymmetry, 1});
        apart = std::max(apart, found[0] / found[1]);
        for (std::size_t k = 2; k < found.size(); k += 3) {
          const int i = dealt.entry(p, found[k]), j = dealt.entry(p, found[k + 1]);
          const auto [at, fresh] =
              alone.try_emplace({std::min(i, j), std::max(i, j)}, found[k + 2]);
          if (!fresh) apart = std::max(apart, std::abs(found[k + 2] - at->second) / found[1]);
        }
      }
      EXPECT_EQ(alone.empty(), processes == 1);
      EXPECT_EQ(apart > asymmetry_of_rounding, more > 0.0) << processes << ' ' << apart;
    }
  }
}

TEST(OwnMatrices, ProductsOfTheTransposeAndPreciseOnesAreThoseOfTheWhole) {
  Plan plan = slab(3, 2);
  plan.problem.forms[1].entries.push_back({slot::value(0), slot::value(1), Expr(50.0)});
  Dealt dealt(plan, 3);
  const SparseMatrix a = assemble_operators(plan.problem, dealt.d, dealt.layout, 1).bases[1];
  Vector x(dealt.layout.n_unknowns);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = std::sin(3.0 * static_cast<double>(i));
  Vector back = Vector::Zero(x.size());
  for (int p = 0; p < 3; ++p) dealt.add_transposed(p, 1, x, back);
  const Vector expected = a.transpose() * x;
  EXPECT_LE((back - expected).norm(), 1e-14 * expected.norm());
  const auto precise = dealt.ask({0, MatrixErrand::precisely, 1}, {x});
  std::vector<DoubleDouble> sums(static_cast<std::size_t>(x.size()));
  Vector sizes = Vector::Zero(x.size());
  subtract_product(a, x, sums, sizes);
  for (int i = 0; i < x.size(); ++i) { // whatever the order of the sums
    EXPECT_NEAR(precise[0][i] + sums[i].high + (precise[1][i] + sums[i].low), 0.0,
                1e-29 * sizes[i]);
    EXPECT_NEAR(precise[2][i], sizes[i], 1e-14 * sizes[i]);
  }
}

void expect_rows_of_the_whole(const Plan& plan, bool coupled) {
  for (const int processes : {1, 2, 4}) {
    Dealt dealt(plan, processes);
    for (const int field : {field_of_u(0), field_of_u(1)}) {
      const DenseMatrix all = DenseMatrix(whole(plan, dealt, field));
      EXPECT_LE((dealt.matrix(field) - all).lpNorm<Eigen::Infinity>(),
                1e-14 * all.lpNorm<Eigen::Infinity>())
          << processes << " processes, field " << field;
    }
    EXPECT_EQ(dealt.d.space.is_product(), coupled);
  }
}

// A node has the rows of those that repeat it, whose cells are at the other end of the body.
TEST(OwnMatrices, PeriodicPartsAreDealtOut) {
  Plan plan = uneven_slab(2, 2);
  plan.problem.parts.push_back(group("left", "left"));
  plan.problem.space.periodic = {{{}, flank, static_cast<int>(plan.problem.parts.size()) - 1}};
  expect_rows_of_the_whole(plan, false);
}

// A temperature in P1 beside a displacement in P2, in one of two pieces, which expands it.
TEST(OwnMatrices, SeveralUnknownsAreDealtOut) {
  Plan plan = two_blocks(2, 2, 2);
  plan.problem.parts.push_back(group("above", "upper"));
  const int above = static_cast<int>(plan.problem.parts.size()) - 1;
  plan.problem.space.order = 2;
  plan.problem.space.more = {{"theta", "W", {}, false, 1, above}};
  FormTerm conducts = diffusion(2, above, field_of_u(0), 1.0 + var(slot::x(0)));
  for (auto& entry : conducts.entries)
    entry.test = slot::of_unknown(1, entry.test), entry.trial = slot::of_unknown(1, entry.trial);
  FormTerm expands; // theta d v_x / dx
  expands.part = above;
  expands.field = field_of_u(1);
  expands.entries.push_back({slot::gradient(0, 0), slot::of_unknown(1, slot::value(0)), Expr(3.0)});
  plan.problem.forms.push_back(conducts);
  plan.problem.forms.push_back(expands);
  expect_rows_of_the_whole(plan, true);
}

/// A slab on a wall, with a mass inside, more of it at one end, and some on the flank.
Plan thrown_slab(int dim, int order) {
  Plan plan = slab(dim == 2 ? 5 : 2, 2, dim);
  plan.problem.space.order = order;
  plan.problem.time.scheme = Scheme::midpoint;
  const Expr r = var(slot::argument(0)), x = var(slot::x(0));
  plan.problem.laws[0].expression = select(less_equal(r, 0.0), 0.0, 1e300);
  for (const int part : {body, flank}) {
    plan.problem.forms.push_back({});
    FormTerm& mass = plan.problem.forms.back();
    mass.part = part;
    mass.field = field_of_u(2);
    for (int i = 0; i < dim; ++i)
      mass.entries.push_back({slot::value(i), slot::value(i), 2.0 + x * x});
  }
  return plan;
}

/// Walls inside it, too: nodes that are far from all others keep their mass.
void add_walls_inside(Plan& plan) {
  LawTerm term = plan.problem.law_terms[0];
  term.part = static_cast<int>(plan.problem.parts.size());
  term.rows = {{}};
  term.rows[0].u[0] = 1.0;
  plan.problem.parts.push_back(all_cells("half"));
  plan.problem.parts.back().region.kind = RegionSpec::Kind::where;
  plan.problem.parts.back().region.children.resize(1);
  plan.problem.parts.back().region.predicate = less(var(slot::x(0)), 1.3);
  plan.problem.law_terms.push_back(std::move(term));
}

// Rows of nodes that get mass have columns which are none of their cells'.
TEST(OwnMatrices, MassThatIsTakenOffWallsIsDealtOut) {
  for (const auto& [dim, order] :
       {std::pair(2, 1), std::pair(2, 2), std::pair(3, 1), std::pair(3, 2)})
    for (const bool periodic : {false, true}) {
      Plan plan = thrown_slab(dim, order);
      if (!periodic) add_walls_inside(plan);
      if (periodic) {
        plan.problem.parts.push_back(group("left", "left"));
        plan.problem.space.periodic = {
            {{}, flank, static_cast<int>(plan.problem.parts.size()) - 1}};
      }
      for (const int processes : {1, 2, 5}) {
        Dealt dealt(plan, processes);
        const DenseMatrix all =
            DenseMatrix(restrict_rows(inertia_matrix(plan.problem, dealt.d), dealt.layout));
        const DenseMatrix plain = DenseMatrix(
            restrict_rows(matrix_of_field(plan.problem, dealt.d, field_of_u(2)), dealt.layout));
        EXPECT_GT((all - plain).norm(), 0.1 * plain.norm());
        EXPECT_LE((dealt.matrix(field_of_u(2)) - all).lpNorm<Eigen::Infinity>(),
                  1e-14 * all.lpNorm<Eigen::Infinity>())
            << dim << "D, P" << order << ", " << processes << " processes";
        const DenseMatrix stiff = DenseMatrix(whole(plan, dealt, field_of_u(0)));
        EXPECT_LE((dealt.matrix(field_of_u(0)) - stiff).lpNorm<Eigen::Infinity>(),
                  1e-14 * stiff.lpNorm<Eigen::Infinity>());
      }
    }
}

StateTerm state_inside(std::string name, int part, Expr rate) {
  StateTerm out;
  out.name = std::move(name);
  out.part = part;
  out.rate = std::move(rate);
  out.initial = 0.1 + 0.2 * var(slot::x(0));
  return out;
}

/// A slab whose stiffness falls with a state, whose viscosity grows with the time, and whose right
/// half has springs that a state of its own changes.
Plan ageing_slab(int dim, int order) {
  Plan plan = slab(dim == 2 ? 4 : 2, 2, dim);
  plan.problem.space.order = order;
  const int half = static_cast<int>(plan.problem.parts.size());
  plan.problem.parts.push_back(all_cells("half"));
  plan.problem.parts.back().region.kind = RegionSpec::Kind::where;
  plan.problem.parts.back().region.children = {RegionSpec{}};
  plan.problem.parts.back().region.predicate = less(1.0, var(slot::x(0)));
  plan.problem.states = {state_inside("d", body, var(slot::x(1))), state_inside("time", body, 1.0),
                         state_inside("e", half, 0.5)};
  plan.problem.states[1].initial = 0.0;
  const auto read = [](int i) { return var(slot::state(i)); };
  for (auto& entry : plan.problem.forms[1].entries)
    entry.coefficient = entry.coefficient * (1.0 - read(0)) * (1.0 + var(slot::x(1)));
  for (auto& entry : plan.problem.forms[0].entries)
    entry.coefficient = entry.coefficient * (1.0 + 0.5 * read(1));
  plan.problem.forms.push_back(springs(half, 7.0 + read(2) * read(2)));
  return plan;
}

/// Of each process the states at its points, by form as forms_to_deal has them.
std::vector<double> states_here(const Plan& plan, const Dealt& dealt, const Contact& contact,
                                int p) {
  const DealtForms forms = forms_to_deal(plan.problem, dealt.d, dealt.layout);
  std::vector<double> out;
  for (const ChangingTerm& term : forms.changing)
    for (const Slot s : term.reading.states) {
      const double* const values =
          contact.state_values.data() +
          contact.first_state[static_cast<std::size_t>(s - slot::first_state)];
      if (term.reading.uniform) {
        out.push_back(*values);
        continue;
      }
      const auto& cell =
          body_group(plan.problem, contact, term.form.part, {}, "").body->points.cell;
      for (std::size_t k = 0; k < cell.size(); ++k)
        if (std::ranges::binary_search(dealt.cells(p), cell[k])) out.push_back(values[k]);
    }
  return out;
}

TEST(OwnMatrices, FormsThatStatesChangeAreDealtOut) {
  for (const auto& [dim, order] : {std::pair(2, 1), std::pair(2, 2), std::pair(3, 1)}) {
    const Plan plan = ageing_slab(dim, order);
    for (const int processes : {1, 2, 4}) {
      Dealt dealt(plan, processes);
      Contact contact = make_contact(plan.problem, dealt.d, dealt.layout);
      for (Eigen::Index i = 0; i < contact.state_values.size(); ++i)
        contact.state_values[i] = 0.5 + 0.4 * std::sin(1.7 * static_cast<double>(i));
      const double now = 0.75;
      contact.state_values.segment(contact.first_state[1], contact.state_groups[0].n_points)
          .setConstant(now);
      for (int p = 0; p < processes; ++p)
        assembled(dealt.take_states(p, states_here(plan, dealt, contact, p)));
      for (const int field : {field_of_u(0), field_of_u(1), field_of_memory(0)}) {
        const DenseMatrix all = DenseMatrix(restrict_rows(
            matrix_of_field(plan.problem, dealt.d, field, contact, contact.state_values),
            dealt.layout));
        EXPECT_LE((dealt.matrix(field) - all).lpNorm<Eigen::Infinity>(),
                  1e-14 * all.lpNorm<Eigen::Infinity>())
            << dim << "D, P" << order << ", " << processes << " processes, field " << field;
      }
    }
  }
}

// A coefficient that is no number at these states.
TEST(OwnMatrices, FailuresOfStatesComeBack) {
  Plan plan = ageing_slab(2, 1);
  plan.problem.forms[1].origin = {42};
  for (auto& entry : plan.problem.forms[1].entries)
    entry.coefficient = entry.coefficient * log(2.0 - var(slot::state(0)));
  Dealt dealt(plan, 2);
  Contact contact = make_contact(plan.problem, dealt.d, dealt.layout);
  contact.state_values.setConstant(3.0);
  try {
    assembled(dealt.take_states(1, states_here(plan, dealt, contact, 1)));
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::bad_value);
    EXPECT_EQ(failure.origin, Origin{42});
  }
}

} // namespace
} // namespace hvi::solver
