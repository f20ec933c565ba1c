// What survives: the sudden end of the process at random instants, a full disk, a database that cannot be written, and
// bits that change in the file of the database.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "tumble/archive/database/database.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/shape.hpp"
#include "tumble/archive/testing/postgres_server.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// Two results and a recording, number `k` of a sequence.
Deposit step_of(const std::string& folder, int k) {
  const std::string recording = folder + "/" + std::to_string(k) + ".csv";
  std::ofstream(recording) << "time[s],x[deg/h]\n0," << k << "\n";
  Deposit deposit;
  for (const int i : {2 * k, 2 * k + 1})
    deposit.results.push_back(testing::sample_deposit({.serial = std::to_string(i % 3), .bias = 1.0 * i}));
  deposit.files.push_back({.path = recording, .name = std::to_string(k) + ".csv", .unit = {"gyro", "0"}});
  return deposit;
}

/// The child: puts in for ever, and writes to the pipe how many steps were acknowledged, at first that it has begun.
[[noreturn]] void put_in_until_killed(const std::string& address, const std::string& folder, int first, int pipe) {
  try {
    Archive archive(address);
    for (int k = first;; ++k) {
      if (write(pipe, &k, sizeof k) < 0) _exit(1);
      put_in(archive, step_of(folder, k), testing::sample_act());
    }
  } catch (...) {
    _exit(2);
  }
}

/// Kills a child that puts in after so many microseconds. Returns how many steps it had acknowledged.
int steps_until_killed(const std::string& address, const std::string& folder, int first, useconds_t after) {
  int ends[2];
  if (pipe(ends) != 0) return first;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    put_in_until_killed(address, folder, first, ends[1]);
  }
  close(ends[1]);
  int last = first, next = 0;
  EXPECT_EQ(read(ends[0], &last, sizeof last), static_cast<ssize_t>(sizeof last)) << "the child did not begin";
  usleep(after);
  kill(child, SIGKILL);
  while (read(ends[0], &next, sizeof next) == sizeof next) last = next;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the child ended by itself: " << status;
  return last;
}

/// Kills again and again; whatever was acknowledged is there, and everything verifies.
void expect_to_survive_kills(const std::string& address, const std::string& folder) {
  const char* const wanted = std::getenv("TUMBLE_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 10;
  std::mt19937_64 random(20);
  int acknowledged = 0;
  useconds_t longest = 60'000;  // [us]
  for (int i = 0; i < kills; ++i) {
    acknowledged = steps_until_killed(address, folder, acknowledged, static_cast<useconds_t>(random() % longest));
    if (acknowledged == 0) longest *= 2;  // a machine that is busy needs longer for a step
    Archive archive(address);
    const auto check = verify_archive(archive);
    ASSERT_TRUE(check.problems.empty()) << "kill " << i << ": " << check.problems.front().text();
    std::size_t results = 0;
    for (const auto& unit : archived_units(archive)) results += unit.results;
    ASSERT_GE(results, static_cast<std::size_t>(2 * acknowledged)) << "kill " << i;
    ASSERT_LE(results, static_cast<std::size_t>(2 * acknowledged + 2)) << "kill " << i;
    if (acknowledged > 0) {
      ASSERT_GE(unit_record(archive, {"gyro", "0"}).files.size(), static_cast<std::size_t>(acknowledged))
          << "kill " << i;
    }
  }
  EXPECT_GT(acknowledged, 0) << "no kill came after a step";
}

TEST(ArchiveCrash, AKilledProcessLosesNothingThatWasAcknowledged) {
  const ScratchFolder folder;
  make_archive(folder.file("lab.db"), "", testing::sample_act());
  expect_to_survive_kills(folder.file("lab.db"), folder.path.string());
}

TEST(ArchiveCrashOnPostgres, AKilledProcessLosesNothingThatWasAcknowledged) {
  if (!testing::PostgresServer::installed()) {
    if (std::getenv("CI")) FAIL() << "PostgreSQL is not installed: script/packages.txt names it";
    GTEST_SKIP() << "PostgreSQL is not installed";
  }
  testing::PostgresServer server;
  const ScratchFolder folder;
  const std::string address = server.new_database("lab");
  make_archive(address, folder.file("kept"), testing::sample_act());
  expect_to_survive_kills(address, folder.path.string());
}

/// In a child whose files may not become larger than this: what it is told, and whether it ended by itself.
int put_in_with_a_small_disk(const std::string& address, const std::string& folder, rlim_t most) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{most, most};
    setrlimit(RLIMIT_FSIZE, &limit);
    int k = 0;
    try {
      Archive archive(address);
      for (; k < 100; ++k) put_in(archive, step_of(folder, k), testing::sample_act());
    } catch (const Error&) {
      _exit(k);
    } catch (...) {
      _exit(200);
    }
    _exit(100);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 201;
}

TEST(ArchiveCrash, AFullDiskIsAnErrorAndKeepsWhatWasAcknowledged) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db");
  make_archive(address, "", testing::sample_act());
  const auto size = fs::file_size(address);
  for (const rlim_t more : {0, 4096, 20'000, 60'000}) {
    const int before = put_in_with_a_small_disk(address, folder.path.string(), size + more);
    ASSERT_LT(before, 100) << "an error is expected, not an end of the process (200, 201), nor room for all";
    Archive archive(address);
    EXPECT_TRUE(verify_archive(archive).problems.empty());
    std::size_t results = 0;
    for (const auto& unit : archived_units(archive)) results += unit.results;
    EXPECT_GE(results, static_cast<std::size_t>(2 * before));
  }
}

/// What a child finds of an archive that it may read and not write: 0 where all is as it should be.
int read_without_permission(const std::string& address, const std::string& folder) {
  constexpr uid_t nobody = 65534;
  const pid_t child = fork();
  if (child == 0) {
    if (geteuid() == 0 && setuid(nobody) != 0) _exit(3);  // root may write everything
    try {
      Archive archive(address);
      if (!verify_archive(archive).problems.empty() || archived_units(archive).empty()) _exit(1);
      put_in(archive, step_of(folder, 1), testing::sample_act());
    } catch (const Error& error) {
      _exit(std::string(error.what()).find("readonly") != std::string::npos ||
                    std::string(error.what()).find("Permission") != std::string::npos
                ? 0
                : 2);
    } catch (...) {
      _exit(4);
    }
    _exit(5);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 201;
}

TEST(ArchiveCrash, AnArchiveThatCannotBeWrittenIsRead) {
  const ScratchFolder folder, other;
  const std::string address = folder.file("lab.db");
  make_archive(address, "", testing::sample_act());
  {
    Archive archive(address);
    put_in(archive, step_of(other.path.string(), 0), testing::sample_act());
  }
  fs::permissions(other.path, fs::perms::all);
  for (const auto& file : fs::recursive_directory_iterator(folder.path))
    fs::permissions(file, file.is_directory() ? fs::perms(0555) : fs::perms(0444));
  fs::permissions(folder.path, fs::perms(0555));
  EXPECT_EQ(read_without_permission(address, other.path.string()), 0);
  fs::permissions(folder.path, fs::perms::owner_all);
  for (const auto& file : fs::recursive_directory_iterator(folder.path)) fs::permissions(file, fs::perms::owner_all);
}

TEST(ArchiveCrash, AFolderOfFilesThatIsLostIsSaidByNameAndItsFilesCanBePutInAgain) {
  const ScratchFolder folder, other;
  make_archive(folder.file("lab.db"), "", testing::sample_act());
  Archive archive(folder.file("lab.db"));
  for (int k = 0; k < 3; ++k) put_in(archive, step_of(other.path.string(), k), testing::sample_act());
  fs::remove_all(archive.folder());
  const auto check = verify_archive(archive);
  EXPECT_EQ(check.problems.size(), 3u);
  EXPECT_NE(check.problems.at(0).text().find("is missing"), std::string::npos);
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(put_in(archive, step_of(other.path.string(), k), testing::sample_act()).results, 0u);
  EXPECT_TRUE(verify_archive(archive).problems.empty());
}

/// All that the archive says, in one text.
std::string said_by(const std::string& address) {
  database::Database database(address, false);
  std::string all;
  auto shapes = schema::covered_shapes();
  shapes.push_back(&schema::events);
  for (const auto* shape : shapes)
    database.visit(schema::select_all(*shape) + " ORDER BY 1, 2", {}, [&](const database::Row& row) {
      for (const auto& cell : row)
        all += std::visit(
                   [](const auto& value) -> std::string {
                     using Cell = std::decay_t<decltype(value)>;
                     if constexpr (std::is_same_v<Cell, std::string>)
                       return value;
                     else if constexpr (std::is_same_v<Cell, database::Bytes>)
                       return value.data;
                     else if constexpr (std::is_same_v<Cell, std::monostate>)
                       return "-";
                     else
                       return std::to_string(value);
                   },
                   cell) +
               "|";
    });
  return all;
}

/// A flipped bit of the file of the database is found, or lies where nothing is kept.
TEST(ArchiveCrash, FlippedBitsOfTheDatabaseFileAreFound) {
  const ScratchFolder folder;
  const std::string address = folder.file("lab.db"), spoiled = folder.file("spoiled.db");
  make_archive(address, folder.file("kept"), testing::sample_act());
  {
    Archive archive(address);
    for (int k = 0; k < 3; ++k) put_in(archive, step_of(folder.path.string(), k), testing::sample_act());
  }
  std::ifstream stream(address, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const std::string before = said_by(address);
  std::mt19937_64 random(3);
  int found = 0;
  for (int i = 0; i < 400; ++i) {
    std::string changed = bytes;
    const std::size_t at = random() % bytes.size();
    changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 8));
    std::ofstream(spoiled, std::ios::binary) << changed;
    bool noticed = false;
    try {
      noticed = !verify_archive(Archive(spoiled)).problems.empty();
    } catch (const Error&) {
      noticed = true;
    }
    found += noticed;
    if (noticed) continue;
    EXPECT_EQ(said_by(spoiled), before) << "byte " << at;
  }
  EXPECT_GT(found, 0);
}

}  // namespace
}  // namespace tumble
