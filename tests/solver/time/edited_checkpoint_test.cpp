// Checkpoints that somebody edited, with hashes that fit: each is refused in words, or it is
// another state of the same problem, from which the run goes on. HVI_EDITS sets the number for each
// scene.
#include "solver/discrete/memory.hpp"
#include "solver/time/checkpoint.hpp"
#include "tests/solver/time/plans.hpp"

#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

struct EditedScene {
  std::string name;
  Plan plan;
  bool monitors = false;
};

EditedScene edited_with_route(HistoryRoute route, std::string name) {
  EditedScene scene{std::move(name), slab(2, 22)};
  scene.plan.problem.histories[0].route = route;
  return scene;
}

std::vector<EditedScene> edited_scenes() {
  std::vector<EditedScene> out{{"recursion", slab(3, 10), true},
                               {"friction", slab(2, 10, 2, true)},
                               {"friction in space", slab(2, 7, 3, true)},
                               edited_with_route(HistoryRoute::fit, "fit"),
                               edited_with_route(HistoryRoute::tree, "tree"),
                               edited_with_route(HistoryRoute::direct, "direct"),
                               {"graded", slab(2, 9, 2, true), true}};
  auto& graded = out.back().plan.problem.time;
  for (double& t : graded.grid) t *= t;
  graded.scheme = Scheme::bdf2;
  return out;
}

class Editor {
public:
  explicit Editor(unsigned seed) : random_(seed) {}

  /// One change: a number of some kind at some place, a byte, or a part too much or too little.
  std::string edited(std::string state) {
    const auto at = below(state.size());
    switch (below(8)) {
    case 0:
    case 1:
      return with(std::move(state), at, integers_[below(integers_.size())]);
    case 2:
    case 3:
      return with(std::move(state), at, doubles_[below(doubles_.size())]);
    case 4:
      return with(std::move(state), at, counts_[below(counts_.size())]);
    case 5:
      return state.erase(at, 1 + below(16));
    case 6:
      return state.insert(at, 1 + below(16), static_cast<char>(below(256)));
    default:
      state[at] = static_cast<char>(below(256));
      return state;
    }
  }

private:
  std::size_t below(std::size_t n) { return random_() % n; }
  template <class T>
  static std::string with(std::string state, std::size_t at, T value) {
    at = std::min(at, state.size() - sizeof value);
    std::memcpy(state.data() + at, &value, sizeof value);
    return state;
  }

  std::mt19937 random_;
  std::vector<std::int32_t> integers_{
      -1, -2, 0, 1, 3, 17, 1000, 1 << 30, std::numeric_limits<std::int32_t>::min()};
  std::vector<double> doubles_{
      std::nan(""), std::numeric_limits<double>::infinity(), -1e300, 1e300, -1.0, 0.0, 1e-300,
      0.37};
  std::vector<std::uint64_t> counts_{0, 1, 5, 1000, 1ULL << 33, ~0ULL, 1ULL << 63};
};

/// A run that stopped halfway, whose checkpoint says otherwise for what extent its memories were
/// chosen.
class EditedExtent {
public:
  explicit EditedExtent(HistoryRoute route) : plan_(edited_with_route(route, "").plan) {
    settings_.output_folder = folder_.string();
    settings_.checkpoint_every = 100;
    for (const auto& mistake : discretise(plan_, d_)) throw mistake;
    Plan half = plan_;
    half.problem.time.grid.resize(6);
    (void)run(half, d_, settings_);
    saved = memory_extent(half.problem);
    state_ = read_checkpoint(file(), fingerprint(plan_, d_.mesh));
    settings_.resume = true;
  }
  ~EditedExtent() { std::filesystem::remove_all(folder_); }

  void expect_refused(const MemoryExtent& wrong) const {
    std::string bytes(sizeof saved, '\0'), edited = state_;
    std::memcpy(bytes.data(), &saved, sizeof saved);
    const auto at = state_.find(bytes);
    ASSERT_NE(at, std::string::npos);
    std::memcpy(edited.data() + at, &wrong, sizeof wrong);
    write_checkpoint(file(), fingerprint(plan_, d_.mesh), edited);
    try {
      run(plan_, d_, settings_);
      ADD_FAILURE() << wrong.horizon << ' ' << wrong.shortest_step << ' ' << wrong.steps;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.kind, FailureKind::bad_checkpoint) << failure.what();
    }
  }

  MemoryExtent saved;

private:
  std::filesystem::path file() const {
    return checkpoint_path(settings_.output_folder, settings_.name);
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("hvi_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  Plan plan_;
  Discretisation d_;
  RunSettings settings_;
  std::string state_;
};

/// Numbers that no run has are refused before anything is allocated for them.
TEST(EditedCheckpoint, ExtentsOfNoRunAreRefused) {
  const EditedExtent edited(HistoryRoute::direct);
  const MemoryExtent saved = edited.saved;
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  for (const MemoryExtent& wrong :
       {MemoryExtent{saved.horizon, saved.shortest_step, std::int64_t{1} << 40},
        {saved.horizon, saved.shortest_step, std::numeric_limits<std::int64_t>::max()},
        {saved.horizon, saved.shortest_step, -1},
        {saved.horizon, 0.0, saved.steps},
        {saved.horizon, nan, saved.steps},
        {infinite, saved.shortest_step, saved.steps},
        {saved.horizon, 2.0 * saved.shortest_step, 1}, // longer than the steps taken
        {-1.0, saved.shortest_step, saved.steps}})
    edited.expect_refused(wrong);
}

/// A grid may have a step of 1e-290. Lags of 290 decades are not fitted, which would take hours; so
/// these memories are others than the saved ones.
TEST(EditedCheckpoint, LagsOfHundredsOfDecadesAreNotFitted) {
  const EditedExtent edited(HistoryRoute::fit);
  edited.expect_refused({edited.saved.horizon, 1e-290, edited.saved.steps});
}

TEST(EditedCheckpoint, IsRefusedOrIsAnotherState) {
  const char* asked = std::getenv("HVI_EDITS");
  const int edits = asked != nullptr ? std::atoi(asked) : 60;
  const auto folder = std::filesystem::path(testing::TempDir()) / "hvi_edited";
  unsigned seed = 7;
  for (const auto& scene : edited_scenes()) {
    SCOPED_TRACE(scene.name);
    RunSettings settings;
    settings.output_folder = folder.string();
    settings.monitors = scene.monitors;
    settings.checkpoint_every = 100; // at the end only
    Discretisation d;
    for (const auto& mistake : discretise(scene.plan, d)) throw mistake;
    Plan half = scene.plan;
    half.problem.time.grid.resize(scene.name == "tree" ? 20 : 6);
    (void)run(half, d, settings);
    const auto file = checkpoint_path(settings.output_folder, settings.name);
    const auto mark = fingerprint(scene.plan, d.mesh);
    const std::string state = read_checkpoint(file, mark);
    settings.resume = true;
    EXPECT_EQ(run(scene.plan, d, settings).resumed_from, std::ssize(half.problem.time.grid) - 1);
    Editor editor(seed++);
    int refused = 0;
    for (int i = 0; i < edits; ++i) {
      write_checkpoint(file, mark, editor.edited(state));
      try {
        EXPECT_TRUE(run(scene.plan, d, settings).certificate.certified);
      } catch (const Failure&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, edits / 4) << "of " << edits;
  }
  std::filesystem::remove_all(folder);
}

} // namespace
} // namespace hvi::solver
