#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <vector>

#include "tumble/archive/database/database.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/archive/testing/postgres_server.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/archive/testing/suite.hpp"
#include "tumble/archive/transfer.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

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
  const auto refusal = [](const std::string& address) { return refusal_of([&] { Archive archive(address); }); };
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      Asked{.values = {folder.file("none.db")}, .pattern = "tumble archive init"},
                      refusal(folder.file("none.db"))));
  std::ofstream(folder.file("text.db"))
      << "This is a text, and it is long enough to be taken for a header of a database file.\n";
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("text.db")}, .part = "not a database"},
                      refusal(folder.file("text.db"))));
  std::ofstream(folder.file("empty.db")) << "";
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("empty.db")}, .pattern = "holds no archive"},
                      refusal(folder.file("empty.db"))));
  const Refused lost = refusal("postgresql://me:secret@/none?host=" + folder.path.string());
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "postgresql://me:...@"}, lost));
  for (const std::string& text : texts_of(lost.problems)) EXPECT_EQ(text.find("secret"), std::string::npos) << text;
}

/// How many of some processes that begin at once end well. Each does `work` with its number, which throws Error
/// where it fails.
int ended_well(int processes, const std::function<void(int)>& work) {
  int gate[2];
  EXPECT_EQ(pipe(gate), 0);
  std::vector<pid_t> children;
  for (int i = 0; i < processes; ++i) {
    children.push_back(fork());
    if (children.back() != 0) continue;
    close(gate[1]);  // the end of the pipe, when the parent closes it, is the sign to begin
    char go = 0;
    if (read(gate[0], &go, 1) < 0) _exit(1);
    try {
      work(i);
    } catch (const Error& error) {
      _exit(std::string(error.what()).find("is there already") != std::string::npos ? 3 : 1);
    }
    _exit(0);
  }
  close(gate[1]);
  int well = 0;
  for (const pid_t child : children) {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) != 1) << "another refusal than that the name is taken";
    well += WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  close(gate[0]);
  return well;
}

std::size_t files_in(const ScratchFolder& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()));
}

TEST(Archive, OfSeveralExportsAtOnceOneHasTheName) {
  const ScratchFolder folder, target;
  make_archive(folder.file("lab.db"), "", testing::sample_act());
  Archive archive(folder.file("lab.db"));
  Deposit deposit;
  deposit.results.push_back(testing::sample_deposit({.serial = "1"}));
  put_in(archive, deposit, testing::sample_act());
  const std::string path = target.file("unit.db"), neighbour = target.file("unit.db.part");
  std::ofstream(neighbour) << "of somebody else";
  EXPECT_EQ(ended_well(6,
                       [&](int) {
                         const Archive own(folder.file("lab.db"));
                         export_unit(own, {"gyro", "1"}, path, testing::sample_act());
                       }),
            1);
  EXPECT_TRUE(verify_archive(Archive(path)).problems.empty());
  EXPECT_EQ(content_of(neighbour), "of somebody else");
  EXPECT_EQ(files_in(target), 2u);
}

TEST(Archive, OfSeveralThatAreMadeAtOnceOneHasTheName) {
  const ScratchFolder folder;
  EXPECT_EQ(ended_well(6, [&](int) { make_archive(folder.file("lab.db"), "", testing::sample_act()); }), 1);
  EXPECT_TRUE(verify_archive(Archive(folder.file("lab.db"))).problems.empty());
  EXPECT_EQ(files_in(folder), 2u) << "the archive and the folder of its files";
}

/// A limit of the size of files stands for a full disk.
TEST(Archive, WhatCannotBeMadeIsNotInTheWayOfAnother) {
  const ScratchFolder folder;
  const std::string path = folder.file("lab.db");
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit small{20'000, 20'000};
    setrlimit(RLIMIT_FSIZE, &small);
    try {
      make_archive(path, "", testing::sample_act());
    } catch (const Error&) {
      _exit(3);
    }
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_EQ(files_in(folder), 1u) << "the folder of its files";
  make_archive(path, "", testing::sample_act());
  EXPECT_TRUE(verify_archive(Archive(path)).problems.empty());
}

TEST(Archive, RefusesALaterSchemaAndASecondInit) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db");
  make_archive(address, "", testing::sample_act());
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {address}, .pattern = "is there already"},
                      [&] { make_archive(address, "", testing::sample_act()); }));
  database::Database(address, false)
      .run("INSERT INTO schema_version (version, applied, program) VALUES (99, 'x', 'x')");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {address, "99"}, .pattern = "use a newer one"},
                      [&] { Archive archive(address); }));
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
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {place}, .pattern = "its bytes have changed"}, [&] {
      storage::unpack({archive.folder(), nullptr}, sha256_of(text), [](std::string_view) {});
    })) << i;
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
