// What control groups leave, from folders that look like theirs; limits of this process; refusals.
#include "solver/common/memory_room.hpp"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

struct Groups : testing::Test {
  fs::path top = fs::path(testing::TempDir()) /
                 ("groups" + std::to_string(testing::UnitTest::GetInstance()->random_seed()) +
                  testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override { fs::create_directories(top / "outer" / "inner"); }
  void TearDown() override { fs::remove_all(top); }
  void write(const fs::path& file, const std::string& text) const {
    std::ofstream(top / file) << text << "\n";
  }
};

TEST_F(Groups, SecondVersion) {
  write("outer/inner/memory.max", "max");
  write("outer/inner/memory.current", "100");
  EXPECT_FALSE(control_group_room(top / "outer" / "inner", top)) << "no limit anywhere";
  write("outer/memory.max", "1000");
  write("outer/memory.current", "700");
  EXPECT_EQ(control_group_room(top / "outer" / "inner", top), 300.0) << "the one above it";
  write("outer/memory.stat", "anon 500\nfile 200\ninactive_file 150\nactive_file 50");
  EXPECT_EQ(control_group_room(top / "outer" / "inner", top), 450.0);
  write("outer/inner/memory.max", "120");
  EXPECT_EQ(control_group_room(top / "outer" / "inner", top), 20.0) << "the least";
  EXPECT_EQ(control_group_room(top / "outer", top), 450.0);
  write("outer/inner/memory.current", "130");
  EXPECT_EQ(control_group_room(top / "outer" / "inner", top), 0.0);
}

TEST_F(Groups, FirstVersion) {
  write("outer/memory.limit_in_bytes", "9223372036854771712");
  write("outer/memory.usage_in_bytes", "5");
  EXPECT_FALSE(control_group_room(top / "outer", top));
  write("outer/memory.limit_in_bytes", "1000");
  write("outer/memory.stat", "inactive_file 7\ntotal_inactive_file 15");
  EXPECT_EQ(control_group_room(top / "outer", top), 1010.0);
}

TEST_F(Groups, NothingThere) {
  EXPECT_FALSE(control_group_room(top / "outer", top));
  EXPECT_FALSE(control_group_room(top / "nowhere", top));
}

TEST(MemoryRoom, IsWhatTheLimitOnAddressesLeaves) {
#if defined(HVI_SANITIZE)
  GTEST_SKIP() << "the sanitizers take terabytes of addresses";
#endif
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  rlimit limit = before;
  limit.rlim_cur = rlim_t{2} << 30;
  if (before.rlim_max < limit.rlim_cur) GTEST_SKIP();
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  const MemoryRoom room = memory_room();
  setrlimit(RLIMIT_AS, &before);
  if (room.from.find("addresses") == std::string::npos) GTEST_SKIP() << "less is there";
  EXPECT_LT(room.bytes, 2.0 * (1 << 30));
  EXPECT_GT(room.bytes, 1.0 * (1 << 30));
}

TEST(MemoryRoom, RefusesWhatNoMachineHas) {
  EXPECT_NO_THROW(require_memory(little_memory / 2, "little"));
  try {
    require_memory(1e18, "a wish");
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::too_large);
    const std::string said = failure.what();
    EXPECT_NE(said.find("for a wish"), std::string::npos) << said;
    EXPECT_NE(said.find("1e+09 GB"), std::string::npos) << said;
    EXPECT_FALSE(failure.help.empty());
  }
}

TEST(MemoryRoom, PeakIsAtLeastWhatIsHeld) {
  EXPECT_GT(memory_held(), 1e6);
  const double held = memory_held();
  EXPECT_GE(memory_peak(), held);
}

} // namespace
} // namespace hvi::solver
