// What a checkpoint is good for: the same problem only, whole on the disk before it has its name.
#include "solver/common/read_file.hpp"
#include "solver/kernel/table.hpp"
#include "solver/output/file.hpp"
#include "solver/time/checkpoint.hpp"
#include "tests/solver/time/plans.hpp"

#include <gmock/gmock.h>

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <set>

namespace {
int synced = 0; ///< calls of fsync by this program
}
extern "C" int fsync(int descriptor) {
  ++synced;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace hvi::solver {
namespace {

using namespace testing_plans;

Expr tabulated(double last, Table::Interpolation kind = Table::Interpolation::linear) {
  return Expr::tabulated(std::make_shared<const Table>("load.csv", std::vector<double>{0, 1, 2},
                                                       std::vector<double>{0, 1, last}, kind),
                         var(slot::t));
}

std::uint64_t fingerprint_of(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  return fingerprint(plan, d.mesh);
}

/// Everything that decides the numbers changes the fingerprint; each change gives another one.
TEST(Fingerprint, ChangesWithEachIngredient) {
  const auto changed = [](const std::function<void(Plan&)>& change) {
    Plan plan = slab(3, 4, 2, true);
    plan.problem.loads.push_back(force(flank, {tabulated(7.0)}));
    change(plan);
    return fingerprint_of(plan);
  };
  using Change = std::function<void(Plan&)>;
  const std::vector<Change> changes = {
      [](Plan&) {},
      [](Plan& p) { p.problem.loads.back() = force(flank, {tabulated(7.0 + 1e-15)}); },
      [](Plan& p) {
        p.problem.loads.back() =
            force(flank, {tabulated(7.0, Table::Interpolation::monotone_cubic)});
      },
      [](Plan& p) {
        p.problem.loads.front() = force(body, {0.0, tabulated(7.0)});
      },
      [](Plan& p) {
        p.problem.space.dirichlet[0].value = {0.0, tabulated(7.0)};
      },
      [](Plan& p) {
        p.problem.space.dirichlet[0].value = {0.0, tabulated(8.0)};
      },
      [](Plan& p) { p.problem.law_terms[0].rows[0].offset = tabulated(7.0); },
      [](Plan& p) { p.problem.law_terms[0].rows[0].offset = tabulated(8.0); },
      [](Plan& p) { p.problem.law_terms[0].factor = 1.0 + 1e-15; },
      [](Plan& p) { p.problem.laws[1].expression = Expr(0.5); },
      [](Plan& p) { p.problem.histories[0].kernel = exponential_kernel(0.5 + 1e-15); },
      [](Plan& p) {
        p.problem.forms[0] = elastic(2, body, field_of_u(1), {5, 10 + 1e-14});
      },
      [](Plan& p) { p.report.probes[0].expression = tabulated(7.0); },
      [](Plan& p) { p.report.probes[0].expression = tabulated(8.0); },
      [](Plan& p) { p.problem.mesh.high[0] = 2 + 1e-15; },
      [](Plan& p) { p.problem.mesh.cells[1] = 4; },
      [](Plan& p) { p.problem.space.order = 2; },
      [](Plan& p) { p.problem.time.scheme = Scheme::bdf2; },
      [](Plan& p) { p.problem.time.sampling = LoadSampling::average; },
      [](Plan& p) {
        p.problem.time.initial = {0.0, 1e-300 * (1.0 - var(slot::x(1)))};
      },
      [](Plan& p) { p.options.tolerance = 1e-9; },
      [](Plan& p) { p.options.memory_tolerance = 1e-9; },
      [](Plan& p) { p.options.branch = Branch::least_energy; },
      [](Plan& p) { p.options.proportional_path = false; },
      [](Plan& p) { p.options.reduced_precision = false; },
      [](Plan& p) { p.options.audit = false; },
  };
  std::set<std::uint64_t> seen;
  for (std::size_t i = 0; i < changes.size(); ++i)
    EXPECT_TRUE(seen.insert(changed(changes[i])).second) << "change " << i << " is not seen";
  // What may differ: where the mesh lies, how many threads work, how far the run goes.
  for (const Change& same : {Change([](Plan& p) { p.problem.mesh.path = "elsewhere.msh"; }),
                             Change([](Plan& p) { p.options.threads = 2; }),
                             Change([](Plan& p) { p.problem.time.grid.push_back(1.25); })})
    EXPECT_TRUE(seen.contains(changed(same)));
}

/// What a slab does not have, as the plan alone says it.
TEST(Fingerprint, ChangesWithWhatFewPlansHave) {
  const auto changed = [](const std::function<void(Plan&)>& change) {
    Plan plan = slab(3, 4, 2, true);
    plan.problem.space.more.push_back({"theta", "W", {}});
    change(plan);
    return fingerprint(plan, {});
  };
  using Change = std::function<void(Plan&)>;
  const std::vector<Change> changes = {
      [](Plan&) {},
      [](Plan& p) { p.problem.space.dirichlet[0].unknown = 1; },
      [](Plan& p) { p.problem.law_terms[0].unknown = 1; },
      [](Plan& p) { p.problem.law_terms[0].law = 1; },
      [](Plan& p) { p.problem.law_terms[0].mean = true; },
      [](Plan& p) { p.problem.law_terms[0].rule_of = 1; },
      [](Plan& p) { p.report.probes[0].unknown = 1; },
      [](Plan& p) { p.report.probes[0].on_pair = true; },
      [](Plan& p) {
        p.problem.time.velocity = {{tabulated(7.0), 0.0}};
      },
      [](Plan& p) {
        p.problem.time.velocity = {{tabulated(8.0), 0.0}};
      },
      [](Plan& p) { p.problem.space.unknown = "w"; },
      [](Plan& p) { p.problem.laws[0].coupled = "bed"; },
      [](Plan& p) { p.problem.laws[0].coupled = "wall"; },
      [](Plan& p) { p.problem.law_terms[0].name = "another"; },
      [](Plan& p) { p.report.probes[0].component = 1; },
      [](Plan& p) { p.start = std::make_shared<const Plan>(p); },
      [](Plan& p) {
        Plan start = p;
        start.problem.law_terms[0].factor = 2.0;
        p.start = std::make_shared<const Plan>(std::move(start));
      },
  };
  std::set<std::uint64_t> seen;
  for (std::size_t i = 0; i < changes.size(); ++i)
    EXPECT_TRUE(seen.insert(changed(changes[i])).second) << "change " << i << " is not seen";
}

/// A file may be another one under the same name: all that is computed with changes the
/// fingerprint.
TEST(Fingerprint, ChangesWithTheMesh) {
  const Plan plan = slab(3, 4, 2, true);
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  using Change = std::function<void(Mesh&)>;
  const std::vector<Change> changes = {
      [](Mesh&) {},
      [](Mesh& m) { m.dim = 3; },
      [](Mesh& m) { m.axisymmetric = true; },
      [](Mesh& m) { m.nodes[3][1] = std::nextafter(m.nodes[3][1], 2.0); },
      [](Mesh& m) { std::swap(m.cells[0], m.cells[1]); },
      [](Mesh& m) { std::swap(m.facets[0].nodes[0], m.facets[0].nodes[1]); },
      [](Mesh& m) { m.facets[0].cell += 1; },
      [](Mesh& m) { m.facets[0].other = 1; },
      [](Mesh& m) { m.groups["left"].kind = Group::Kind::points; },
      [](Mesh& m) { m.groups["left"].entities.pop_back(); },
      [](Mesh& m) { m.groups["another"]; },
  };
  std::set<std::uint64_t> seen;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Mesh mesh = d.mesh;
    changes[i](mesh);
    EXPECT_TRUE(seen.insert(fingerprint(plan, mesh)).second) << "change " << i << " is not seen";
  }
  Mesh elsewhere = d.mesh;
  elsewhere.description = "another.msh";
  EXPECT_TRUE(seen.contains(fingerprint(plan, elsewhere)));
}

/// Its text is cut off somewhere, and a walk by calls in calls would need more stack than there is.
TEST(Fingerprint, SeesTheDeepestPartOfALongExpression) {
  const auto with = [](double first) {
    Expr sum = first * sin(var(slot::lag));
    for (int i = 1; i < 60000; ++i) sum = sum + exp(-static_cast<double>(i) * var(slot::lag));
    Plan plan;
    plan.problem.histories.emplace_back().kernel.expression = sum;
    return fingerprint(plan, {});
  };
  EXPECT_EQ(with(1.0), with(1.0));
  EXPECT_NE(with(1.0), with(2.0));
}

TEST(CheckpointFile, IsOnTheDiskBeforeItHasItsName) {
  const auto path = std::filesystem::path(testing::TempDir()) / "hvi_synced" / "a.checkpoint";
  synced = 0;
  write_checkpoint(path, 42, "state");
  EXPECT_EQ(synced, 2) << "the file, and the folder that holds its new name";
  EXPECT_EQ(read_checkpoint(path, 42), "state");
  try {
    (void)read_checkpoint(path, 43);
    FAIL() << "of another problem";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::bad_checkpoint);
  }
}

/// A field of the header that is not what it was is told as what it is; and a state is whole.
TEST(CheckpointFile, TellsWhatIsWrongWithIt) {
  const auto path = std::filesystem::path(testing::TempDir()) / "hvi_header" / "a.checkpoint";
  write_checkpoint(path, 42, "state");
  const std::string whole = *read_file(path);
  const auto refused_with = [&](std::size_t at, std::string_view bytes) -> std::string {
    std::string changed = whole;
    changed.replace(at, bytes.size(), bytes);
    write_atomically(path, changed, Durability::ordinary);
    try {
      (void)read_checkpoint(path, 42);
    } catch (const Failure& failure) {
      return failure.what();
    }
    return "read";
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused_with(0, "other"), HasSubstr("is no checkpoint"));
  EXPECT_THAT(refused_with(11, "\x7f"), HasSubstr("has format 2130706"));
  EXPECT_THAT(refused_with(13, "\x7f"), HasSubstr("is damaged"));
  std::string swapped = whole.substr(12, 4);
  std::ranges::reverse(swapped);
  EXPECT_THAT(refused_with(12, swapped), HasSubstr("another order of bytes"));
  EXPECT_THAT(refused_with(20, "\x7f"), HasSubstr("is damaged"));
  EXPECT_THAT(refused_with(whole.size() - 1, "f"), HasSubstr("is damaged"));
  EXPECT_EQ(refused_with(whole.size() - 1, "e"), "read"); // as it was
}

} // namespace
} // namespace hvi::solver
