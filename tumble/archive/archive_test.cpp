#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tumble/archive/database/database.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/archive/testing/postgres_server.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/archive/testing/suite.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class ArchiveOnSqlite : public ::testing::TestWithParam<testing::ArchiveCase> {};

TEST_P(ArchiveOnSqlite, Passes) {
  const ScratchFolder folder;
  GetParam().run({folder.file("lab.db"), folder.path.string()});
}

INSTANTIATE_TEST_SUITE_P(Archive, ArchiveOnSqlite, ::testing::ValuesIn(testing::archive_cases()),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(ArchiveOnPostgres, PassesEveryCaseOfTheSuite) {
  if (!testing::PostgresServer::installed()) {
    if (std::getenv("CI")) FAIL() << "PostgreSQL is not installed: script/packages.txt names it";
    GTEST_SKIP() << "PostgreSQL is not installed";
  }
  testing::PostgresServer server;
  int number = 0;
  for (const auto& one : testing::archive_cases()) {
    SCOPED_TRACE(one.name);
    const ScratchFolder folder;
    one.run({server.new_database("case_" + std::to_string(++number)), folder.path.string()});
  }
}

TEST(Archive, SaysWhatAnAddressHoldsThatIsNoArchive) {
  const ScratchFolder folder;
  const auto problem = [](const std::string& address) -> std::string {
    try {
      Archive archive(address);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(problem(folder.file("none.db")).find("tumble archive init"), std::string::npos);
  std::ofstream(folder.file("text.db"))
      << "This is a text, and it is long enough to be taken for a header of a database file.\n";
  EXPECT_NE(problem(folder.file("text.db")).find("not a database"), std::string::npos)
      << problem(folder.file("text.db"));
  std::ofstream(folder.file("empty.db"));
  EXPECT_NE(problem(folder.file("empty.db")).find("no archive"), std::string::npos);
  const std::string lost = problem("postgresql://me:secret@/none?host=" + folder.path.string());
  EXPECT_NE(lost.find("archive 'postgresql://me:...@"), std::string::npos) << lost;
  EXPECT_EQ(lost.find("secret"), std::string::npos) << lost;
}

TEST(Archive, RefusesALaterSchemaAndASecondInit) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db");
  make_archive(address, "", testing::sample_act());
  EXPECT_THROW(make_archive(address, "", testing::sample_act()), Error);
  database::Database(address, false)
      .run("INSERT INTO schema_version (version, applied, program) VALUES (99, 'x', 'x')");
  try {
    Archive archive(address);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("version 99"), std::string::npos);
  }
}

TEST(Archive, FindsEveryFlippedByteOfAStoredFile) {
  const ScratchFolder folder;
  Archive archive = [&] {
    make_archive(folder.file("lab.db"), "", testing::sample_act());
    return Archive(folder.file("lab.db"));
  }();
  std::string text = "time[s],x[deg/h]\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(i) + "," + std::to_string(i * i % 17) + "\n";
  std::ofstream(folder.file("data.csv")) << text;
  Deposit deposit;
  deposit.files.push_back({.path = folder.file("data.csv"), .name = "data.csv", .unit = {"gyro", "1"}});
  put_in(archive, deposit, testing::sample_act());
  const std::string place = storage::place_of(archive.folder(), sha256_of(text));
  const std::string before = content_of(place);
  ASSERT_TRUE(verify_archive(archive).problems.empty());
  for (std::size_t i = 0; i < before.size(); ++i) {
    std::string after = before;
    after[i] = static_cast<char>(after[i] ^ (1 << i % 8));
    std::ofstream(place, std::ios::binary) << after;
    EXPECT_THROW(storage::unpack({archive.folder(), nullptr}, sha256_of(text), [](std::string_view) {}), Error) << i;
  }
  std::ofstream(place, std::ios::binary) << before.substr(0, before.size() - 1);
  EXPECT_EQ(verify_archive(archive).problems.size(), 1u);
  fs::remove(place);
  EXPECT_EQ(verify_archive(archive).problems.size(), 1u);
}

TEST(Archive, ASymbolicLinkHasTheFolderOfItsFile) {
  const ScratchFolder folder;
  make_archive(folder.file("lab.db"), "", testing::sample_act());
  fs::create_symlink(folder.file("lab.db"), folder.file("today.db"));
  EXPECT_TRUE(fs::equivalent(Archive(folder.file("today.db")).folder(), folder.file("lab.files")));
}

TEST(Database, NumbersParametersOutsideOfQuotes) {
  EXPECT_EQ(database::numbered_parameters("SELECT '?' , a FROM t WHERE b = ? AND c = ?"),
            "SELECT '?' , a FROM t WHERE b = $1 AND c = $2");
}

}  // namespace
}  // namespace tumble
