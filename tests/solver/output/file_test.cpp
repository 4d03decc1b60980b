// Files appear whole or not at all; what cannot be written is a Failure(output).
#include "solver/common/failure.hpp"
#include "solver/output/file.hpp"
#include "solver/output/folder_lock.hpp"
#include "solver/output/table.hpp"
#include "solver/output/temporary_file.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

namespace hvi::solver {
namespace {

namespace fs = std::filesystem;

fs::path fresh_folder(const std::string& name) {
  auto folder = fs::path(testing::TempDir()) / ("hvi_" + name);
  fs::remove_all(folder);
  return folder;
}

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

FailureKind kind_of_write(const fs::path& path) {
  try {
    write_atomically(path, "x");
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find(path.string()), std::string::npos);
    return failure.kind;
  }
  return FailureKind::bad_value;
}

TEST(File, MakesFoldersAndReplaces) {
  const auto folder = fresh_folder("file");
  write_atomically(folder / "deep" / "a.txt", "one");
  write_atomically(folder / "deep" / "a.txt", "two", Durability::synced);
  EXPECT_EQ(content(folder / "deep" / "a.txt"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "deep"), {}), 1);
}

TEST(File, AFolderOrAFileInTheWayIsAFailure) {
  const auto folder = fresh_folder("file_way");
  fs::create_directories(folder / "taken" / "inside");
  EXPECT_EQ(kind_of_write(folder / "taken"), FailureKind::output);
  write_atomically(folder / "plain", "x");
  EXPECT_EQ(kind_of_write(folder / "plain" / "below.txt"), FailureKind::output);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2); // no temporary file left
}

TEST(File, AFullDiskIsAFailureAndKeepsTheOldFile) {
  // A link to /dev/full in place of a folder cannot be made; a tiny file-size limit acts the same.
  const auto folder = fresh_folder("file_full");
  write_atomically(folder / "a.txt", "old");
  const auto command = "ulimit -f 1; trap '' XFSZ; exec '" +
                       fs::read_symlink("/proc/self/exe").string() +
                       "' --gtest_also_run_disabled_tests --gtest_filter=File.DISABLED_WriteLarge "
                       ">/dev/null 2>&1";
  ::setenv("HVI_TEST_FILE", (folder / "a.txt").c_str(), 1);
  EXPECT_EQ(std::system(("bash -c \"" + command + "\"").c_str()), 0);
  EXPECT_EQ(content(folder / "a.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

/// A temporary file as a writer leaves it that was killed.
fs::path left_by_a_dead_writer(const fs::path& folder) {
  auto path = folder / ".a.txt.abcdefgh.hvi-part";
  std::ofstream(path) << "half";
  return path;
}

TEST(File, LeftoversOfTheDeadGoAndNoOthers) {
  const auto folder = fresh_folder("leftovers");
  fs::create_directories(folder);
  const auto dead = left_by_a_dead_writer(folder);
  std::ofstream(folder / "a.txt.backup") << "mine";
  std::ofstream(folder / "mine.hvi-part") << "mine";
  const TemporaryFile living(folder / "b.txt");
  ASSERT_TRUE(living.is_open());
  remove_leftovers(folder);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 3);
}

TEST(File, AWrittenFileIsNoLeftoverBeforeItHasItsName) {
  const auto folder = fresh_folder("written");
  fs::create_directories(folder);
  TemporaryFile file(folder / "a.txt");
  ASSERT_TRUE(file.write("whole") && file.sync() && file.close());
  remove_leftovers(folder); // another run begins
  EXPECT_TRUE(file.rename_to(folder / "a.txt"));
  EXPECT_EQ(content(folder / "a.txt"), "whole");
}

TEST(File, ATemporaryFileThatIsTakenAwayIsAFailure) {
  const auto folder = fresh_folder("taken_away");
  fs::create_directories(folder);
  TemporaryFile file(folder / "a.txt");
  ASSERT_TRUE(file.write("whole"));
  for (const auto& entry : fs::directory_iterator(folder)) fs::remove(entry.path());
  EXPECT_FALSE(file.rename_to(folder / "a.txt"));
  EXPECT_FALSE(fs::exists(folder / "a.txt"));
}

TEST(File, ALongNameHasRoomForATemporaryOne) {
  const auto folder = fresh_folder("long");
  const std::string name(250, 'n');
  write_atomically(folder / name, "x");
  EXPECT_EQ(content(folder / name), "x");
}

TEST(File, LinesAreAppendedWhole) {
  const auto folder = fresh_folder("append");
  append_line(folder / "a.txt", "one");
  append_line(folder / "a.txt", "two");
  EXPECT_EQ(content(folder / "a.txt"), "one\ntwo\n");
  std::ofstream(folder / "a.txt", std::ios::app) << "half of a li"; // killed while it wrote
  append_line(folder / "a.txt", "three");
  EXPECT_EQ(content(folder / "a.txt"), "one\ntwo\nhalf of a li\nthree\n");
}

TEST(File, DevicesAndPipesAreRefused) {
  EXPECT_EQ(kind_of_write("/dev/null"), FailureKind::special_output);
  EXPECT_THROW(try_to_write("/dev/full"), Failure);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(FolderLock, OneAtATimeAndItSaysWho) {
  const auto folder = fresh_folder("lock");
  {
    const FolderLock first(folder);
    try {
      const FolderLock second(folder);
      FAIL() << "two at once";
    } catch (const Failure& busy) {
      EXPECT_EQ(busy.kind, FailureKind::busy_folder);
      const std::string said = busy.what();
      EXPECT_NE(said.find(std::to_string(::getpid())), std::string::npos) << said;
      EXPECT_NE(said.find(folder.string()), std::string::npos) << said;
    }
  }
  EXPECT_FALSE(fs::exists(folder)); // it was made, and stayed empty
  fs::create_directories(folder);
  { const FolderLock again(folder); }
  EXPECT_TRUE(fs::exists(folder));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(FolderLock, AFileInTheWayIsAFailure) {
  const auto folder = fresh_folder("lock_way");
  write_atomically(folder / "plain", "x");
  EXPECT_THROW(FolderLock(folder / "plain"), Failure);
  EXPECT_THROW(FolderLock(folder / "plain" / "below"), Failure);
  EXPECT_THROW(FolderLock("/proc/nothing/here"), Failure);
}

/// The child of the test above: runs with a file-size limit, so that writing fails half way.
TEST(File, DISABLED_WriteLarge) {
  const char* path = std::getenv("HVI_TEST_FILE");
  ASSERT_NE(path, nullptr);
  try {
    write_atomically(path, std::string(1 << 20, 'x'));
    FAIL() << "the limit did not act";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::output);
  }
}

TEST(Table, CsvReadsBackToTheSameBits) {
  ReportTable table{{"t", "a,b"}, {{0.1, 0.2}, {1.0 / 3.0, std::nan("")}}};
  const auto text = csv_text(table);
  EXPECT_EQ(text.substr(0, text.find('\n')), "t,\"a,b\"");
  std::istringstream in(text.substr(text.find('\n') + 1));
  double t = 0, v = 0;
  char comma = 0;
  in >> t >> comma >> v;
  EXPECT_EQ(t, 0.1);
  EXPECT_EQ(v, 1.0 / 3.0);
  EXPECT_TRUE(text.ends_with(",\n"));
}

TEST(Table, QuotesInNamesAreDoubled) {
  const ReportTable table{{"t", "of \"a\"", "plain"}, {{1}, {2}, {3}}};
  EXPECT_EQ(csv_text(table), "t,\"of \"\"a\"\"\",plain\n1,2,3\n");
}

TEST(Table, UnitsLieBesideItAndItsNamesStay) {
  ReportTable table{{"t", "a,b", "n"}, {{1}, {2}, {3}}, {"s", "N/mm", ""}};
  EXPECT_TRUE(csv_text(table).starts_with("t,\"a,b\",n\n"));
  const auto folder = fresh_folder("units");
  EXPECT_EQ(write_table(folder, "f.csv", table),
            (std::vector<std::string>{"f.csv", "f.csv-metadata.json"}));
  const std::vector<CsvColumn> told{{"t", "s"}, {"a,b", "N/mm"}, {"n", "", false}};
  const auto about = nlohmann::json::parse(csv_metadata("below/f.csv", told));
  std::ifstream written(folder / "f.csv-metadata.json");
  EXPECT_EQ(nlohmann::json::parse(written)["tableSchema"]["columns"][1],
            about["tableSchema"]["columns"][1]);
  EXPECT_EQ(about["url"], "f.csv");
  const auto& columns = about["tableSchema"]["columns"];
  EXPECT_EQ(columns[1]["titles"], "a,b");
  EXPECT_EQ(columns[1]["schema:unitText"], "N/mm");
  EXPECT_FALSE(columns[2].contains("schema:unitText"));
  EXPECT_EQ(columns[1]["datatype"], "double");
  EXPECT_EQ(columns[2]["datatype"], "string");
  table.units = {"", "", ""};
  EXPECT_EQ(write_table(folder, "f.csv", table), std::vector<std::string>{"f.csv"});
  EXPECT_FALSE(std::filesystem::exists(folder / "f.csv-metadata.json"));
  for (const char* text : {"{\"url\": \"f.csv\"}", "not JSON", "[1]", "{\"dc:creator\": 3}"}) {
    std::ofstream(folder / "f.csv-metadata.json") << text; // somebody else's
    write_table(folder, "f.csv", table);
    EXPECT_TRUE(std::filesystem::exists(folder / "f.csv-metadata.json")) << text;
  }
  EXPECT_EQ(csv_metadata("f.csv", {{"t", ""}}), "");
}

TEST(Table, AlignsAndShortens) {
  ReportTable table{{"t", "u_y"}, {{1, 2, 3, 4, 5}, {-0.026611454116, 1, 2, std::nan(""), 1e-7}}};
  EXPECT_EQ(aligned_text(table), "t              u_y\n"
                                 "1  -0.026611454116\n"
                                 "2                1\n"
                                 "3                2\n"
                                 "4                -\n"
                                 "5            1e-07\n");
  EXPECT_EQ(aligned_text(table, 2), "t              u_y\n"
                                    "1  -0.026611454116\n"
                                    "... 3 rows ...\n"
                                    "5            1e-07\n");
}

} // namespace
} // namespace hvi::solver
