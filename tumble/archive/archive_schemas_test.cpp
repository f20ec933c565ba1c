// Databases of earlier schemas, in tests/reference/archive: the program of today opens each of them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "tumble/archive/database/database.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/statistics.hpp"
#include "tumble/archive/testing/postgres_server.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

const std::string reference = std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/archive/schema_1";

void expect_version_1(const std::string& address, const std::string& folder_of_files) {
  Archive archive(address, "2027-01-01T00:00:00Z");
  EXPECT_EQ(archive.folder(), folder_of_files);
  const auto check = verify_archive(archive);
  EXPECT_EQ(check.results, 4u);
  for (const auto& problem : check.problems)
    EXPECT_NE(problem.text().find("/srv/archive"), std::string::npos)
        << problem.text();  // a folder of another computer
  const auto gyro = unit_record(archive, find_unit(archive, "demo-3"));
  ASSERT_EQ(gyro.results.size(), 2u);
  EXPECT_EQ(gyro.results[0].correction, "wrong power supply");
  const auto over = parameter_over_units(archive, "bias", "pendulous_accelerometer");
  ASSERT_EQ(over.values.size(), 2u);
  for (const auto& value : over.values) {
    EXPECT_NE(value.sources, 0) << "the rig and gravity are shared";
    EXPECT_GT(value.private_sd, 0.0);
    EXPECT_LT(value.private_sd, value.sd);
  }
  EXPECT_EQ(over.values[0].sources, over.values[1].sources);
  const auto drift = drift_of_unit(archive, {.what = {"bias", {}, find_unit(archive, "demo-1")}});
  ASSERT_EQ(drift.tables.front().rows.size(), 2u);
  EXPECT_TRUE(std::isfinite(std::get<double>(drift.tables.front().rows[1][3]))) << "E_n";
  Deposit deposit;
  deposit.results.push_back(testing::sample_deposit({}));
  EXPECT_EQ(put_in(archive, deposit, testing::sample_act()).results, 1u);
  EXPECT_EQ(verify_archive(archive).problems.size(), check.problems.size());
}

TEST(ArchiveSchemas, Version1IsBroughtUpToDate) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db");
  database::Database(address, true).script(read_text_file(reference + "/sqlite.sql"));
  fs::copy(reference + "/files", folder.file("lab.files"), fs::copy_options::recursive);
  expect_version_1(address, folder.file("lab.files"));
  EXPECT_TRUE(verify_archive(Archive(address)).problems.empty());
}

TEST(ArchiveSchemas, SeveralProgramsMayBringAnArchiveUpToDateAtOnce) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db");
  database::Database(address, true).script(read_text_file(reference + "/sqlite.sql"));
  fs::copy(reference + "/files", folder.file("lab.files"), fs::copy_options::recursive);
  std::vector<std::thread> programs;
  std::vector<std::string> problems(6, "none");
  for (auto& problem : problems)
    programs.emplace_back([&] {
      try {
        const Archive archive(address, "2027-01-01T00:00:00Z");
      } catch (const Error& error) {
        problem = error.what();
      }
    });
  for (auto& program : programs) program.join();
  for (const auto& problem : problems) EXPECT_EQ(problem, "none");
  EXPECT_TRUE(verify_archive(Archive(address)).problems.empty());
}

TEST(ArchiveSchemasOnPostgres, Version1IsBroughtUpToDate) {
  if (!testing::PostgresServer::installed()) {
    if (std::getenv("CI")) FAIL() << "PostgreSQL is not installed: script/packages.txt names it";
    GTEST_SKIP() << "PostgreSQL is not installed";
  }
  testing::PostgresServer server;
  const std::string address = server.new_database("lab");
  database::Database(address, false).script(read_text_file(reference + "/postgres.sql"));
  expect_version_1(address, "/srv/archive");
}

}  // namespace
}  // namespace tumble
