#include "tumble/formats/confinement.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// A folder with links of all kinds, beside one with a secret.
struct Folders {
  ScratchFolder scratch;
  fs::path inside = fs::canonical(scratch.path) / "inside", outside = fs::canonical(scratch.path) / "outside";

  Folders() {
    fs::create_directories(inside / "sub");
    fs::create_directory(outside);
    for (const auto& file : {inside / "a.toml", inside / "sub/b.toml", outside / "secret.toml"})
      std::ofstream(file) << "x = 1\n";
    fs::create_symlink(outside / "secret.toml", inside / "out.toml");
    fs::create_symlink(outside / "absent.toml", inside / "absent.toml");
    fs::create_symlink("../outside", inside / "away");
    fs::create_symlink("sub", inside / "within");
    fs::create_symlink(inside / "a.toml", inside / "absolute.toml");
    fs::create_symlink("circle", inside / "circle");
  }
};

std::string problem_of(const fs::path& folder, const std::string& name) {
  try {
    return file_named_in(folder, name), "";
  } catch (const Error& error) {
    return error.problems.front().text();
  }
}

TEST(Confinement, IsOffUnlessSomebodyAsks) {
  const Folders folders;
  EXPECT_EQ(file_named_in(folders.inside, "../outside/secret.toml"), (folders.outside / "secret.toml").string());
  EXPECT_EQ(read_text_file((folders.inside / "out.toml").string()), "x = 1\n");
  EXPECT_TRUE(confined_to().empty());
}

TEST(Confinement, TakesWhatLiesInTheFolder) {
  const Folders folders;
  const Confinement confined(folders.inside);
  for (const std::string name :
       {"a.toml", "./sub/../a.toml", "sub/b.toml", "within/b.toml", "not/there.toml", "absolute.toml", "circle"})
    EXPECT_EQ(problem_of(folders.inside, name), "") << name;
  EXPECT_EQ(problem_of(folders.inside, (folders.inside / "a.toml").string()), "");
  EXPECT_EQ(problem_of(folders.inside / "sub", "../a.toml"), "");
}

/// The message has the name as it was written, and is the same whether the file is there.
TEST(Confinement, RefusesWhatLiesOutsideAndSaysNothingOfIt) {
  const Folders folders;
  const Confinement confined(folders.inside);
  for (const std::string name :
       {"../outside/secret.toml", "../outside/absent.toml", "/etc/passwd", "/no/such/file", "out.toml", "absent.toml",
        "away/secret.toml", "away/absent.toml", "sub/../../outside/secret.toml", "..", "/"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {name}}, [&] { file_named_in(folders.inside, name); }));
}

TEST(Confinement, HoldsWhereFilesAreOpened) {
  const Folders folders;
  const auto link = (folders.inside / "out.toml").string();
  {
    const Confinement confined(folders.inside);
    EXPECT_EQ(read_text_file((folders.inside / "absolute.toml").string()), "x = 1\n");
    EXPECT_TRUE(
        refuses(Error::Kind::bad_file, Asked{.values = {link}, .pattern = "leads out"}, [&] { read_text_file(link); }));
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {link}, .pattern = "leads out"},
                        [&] { write_file_atomically(link, "y"); }));
    EXPECT_TRUE(refuses(Error::Kind::bad_file,
                        Asked{.values = {(folders.inside / "away/new.toml").string()}, .pattern = "leads out"},
                        [&] { write_file_atomically((folders.inside / "away/new.toml").string(), "y"); }));
    EXPECT_EQ(read_text_file((folders.outside / "secret.toml").string()), "x = 1\n") << "that somebody names himself";
  }
  write_file_atomically(link, "y");
  EXPECT_EQ(read_text_file((folders.outside / "secret.toml").string()), "y");
}

/// SQLite writes into what has their names, also when a database is only looked at.
TEST(Confinement, JournalsOfDatabasesAreFilesOfTheirOwn) {
  const Folders folders;
  const auto database = (folders.inside / "lab.db").string(), link = (folders.inside / "link.db").string();
  write_file_atomically(database, "");
  fs::create_symlink("lab.db", link);
  require_own_journals(database);
  for (const std::string end : {"-wal", "-shm", "-journal"}) {
    write_file_atomically(database + end, "");
    require_own_journals(database);
    fs::remove(database + end);
    for (const auto& target :
         {folders.outside / "secret.toml", folders.outside / "absent.toml", folders.inside / "x"}) {
      fs::create_symlink(target, database + end);
      EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {database}, .pattern = "a link or a device"},
                          [&] { require_own_journals(database); }))
          << end << target;
      EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {link}, .pattern = "a link or a device"},
                          [&] { require_own_journals(link); }))
          << end << target;
      fs::remove(database + end);
    }
  }
}

}  // namespace
}  // namespace tumble
