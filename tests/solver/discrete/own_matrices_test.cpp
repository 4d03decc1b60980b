// The rows that several processes assemble on their own cells, against the whole matrices.
#include "solver/discrete/dealt_operators.hpp"
#include "solver/discrete/distinct_forms.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/discrete/own_matrices.hpp"
#include "solver/discrete/rounding.hpp"
#include "solver/linear/matrix_rows.hpp"
#include "tests/solver/time/plans.hpp"

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
    const auto distinct = distinct_terms(plan.problem, count_fields(plan.problem),
                                         [](const FormTerm&) { return true; });
    DistinctForms forms{{}, distinct.weights};
    for (const FormTerm* term : distinct.terms) forms.terms.push_back(*term);
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

TEST(OwnMatrices, OnlyWhatIsKnownToBeSymmetricIsDealtOut) {
  const auto may = [](const Plan& plan) {
    Discretisation d;
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    return may_be_dealt(plan.problem, d, make_layout(d.space, d.dofs));
  };
  EXPECT_TRUE(may(slab(2, 2)));
  EXPECT_TRUE(may(uneven_slab(2, 2)));
  Plan plan = slab(2, 2);
  plan.problem.forms[1].entries.push_back({slot::value(0), slot::value(1), Expr(1.0)});
  EXPECT_FALSE(may(plan));
  plan = slab(2, 2);
  plan.problem.space.dirichlet = {clamp(roof, 1)}; // it slides along
  EXPECT_FALSE(may(plan));
  plan = slab(2, 2);
  plan.problem.law_terms.clear();
  plan.report = {};
  EXPECT_FALSE(may(plan));
  plan = slab(2, 2);
  plan.problem.forms.push_back(springs(body, 1.0));
  plan.problem.forms.back().field = field_of_u(2);
  EXPECT_FALSE(may(plan));
}

} // namespace
} // namespace hvi::solver
