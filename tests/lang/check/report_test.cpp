// What a script asks for in its report.
#include "tests/lang/scripts.hpp"

#include <gtest/gtest.h>

namespace hvi::lang {
namespace {

using namespace testing_scripts;

TEST(Report, TablesGoToTheirFiles) {
  const auto script =
      checked(problem(2, "tensor B = isotropic(lambda = 1, mu = 1)\n",
                      "integral(body, B : eps(u) : eps(v))", "integral(body, v.y)") +
              "report\n  table a = u.y at [1, 0]\n  table b = u.x at [2, 0], c = norm(u) to "
              "\"b.csv\"\n  table d = u.y at [2, 0] to \"d.csv\"\n");
  EXPECT_EQ(script.errors, std::vector<std::string>{});
  ASSERT_TRUE(script.model);
  std::vector<std::string> files;
  for (const auto& table : script.model->report.tables) files.push_back(table.file);
  EXPECT_EQ(files, (std::vector<std::string>{"", "b.csv", "d.csv"}));
}

} // namespace
} // namespace hvi::lang
