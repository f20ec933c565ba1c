#include "tumble/serve/users.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/serve/guard.hpp"
#include "tumble/serve/passwords.hpp"
#include "tumble/serve/sign_in.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using State = PasswordCheck::State;

/// One hash for all tests: each costs a tenth of a second.
const std::string& hash_of_horse() {
  static const std::string hash = hash_of_password("correct horse");
  return hash;
}

/// A file of two users, and a clock that stands.
struct Office {
  ScratchFolder scratch;
  std::string file = (scratch.path / "users.toml").string();
  double now = 1000.0;

  Office() {
    add_user(file, {"Li Wei", {Right::operate}, hash_of_horse()});
    add_user(file, {"A. \"B\" Šimon", {Right::read, Right::approve}, hash_of_horse()});
  }
  std::shared_ptr<SignIn> sign_in() {
    return std::make_shared<SignIn>(file, [this] { return now; });
  }
  /// So that the change is seen where the file system keeps whole seconds only.
  void touch() const {
    std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) + std::chrono::seconds(2));
  }
};

HttpRequest with_cookie(const std::string& cookie) {
  HttpRequest request;
  request.method = "GET";
  request.path = "/api/jobs";
  if (!cookie.empty()) request.headers["cookie"] = cookie.substr(0, cookie.find(';'));
  return request;
}

TEST(Password, IsKeptAsWhatNobodyCanReverse) {
  const auto& hash = hash_of_horse();
  EXPECT_EQ(hash.find("horse"), std::string::npos);
  EXPECT_TRUE(hash.starts_with("scrypt:32768:8:3:"));
  EXPECT_TRUE(is_password("correct horse", hash));
  EXPECT_FALSE(is_password("correct Horse", hash));
  EXPECT_FALSE(is_password("", hash));
  EXPECT_NE(hash_of_password("correct horse"), hash);  // another salt
}

TEST(Password, AgreesWithRfc7914) {
  // Section 12: scrypt("pleaseletmein", "SodiumChloride", N = 16384, r = 8, p = 1), its first 32 bytes.
  EXPECT_TRUE(is_password("pleaseletmein",
                          "scrypt:16384:8:1:536f6469756d43686c6f72696465:"
                          "7023bdcb3afd7348461c06cd81fd38ebfda8fbba904f8e3ea9b543f6545da1f2"));
}

TEST(Password, OfADamagedFileIsNobodys) {
  const auto& hash = hash_of_horse();
  for (const std::string& broken : std::vector<std::string>{
           "", "scrypt", "scrypt:1:8:3:00:00", "plain:correct horse", hash.substr(0, hash.size() - 2), hash + "00",
           "scrypt:999999999999:8:3:" + hash.substr(17), "scrypt:32768:8:3:zz" + hash.substr(19)}) {
    EXPECT_FALSE(is_password_hash(broken)) << broken;
    EXPECT_FALSE(is_password("correct horse", broken)) << broken;
  }
}

TEST(Password, MustBeHardToGuess) {
  for (const std::string poor : {"", "short", "123456789"})
    EXPECT_TRUE(has_problem(problems_of_password(poor, "x"), {.pattern = "too short"})) << poor;
  for (const std::string poor : {"a password\n", "\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff"})
    EXPECT_TRUE(has_problem(problems_of_password(poor, "x"), {.pattern = "control characters"})) << poor;
  EXPECT_TRUE(has_problem(problems_of_password("Li Wei Wang", "Li Wei Wang"), {.pattern = "the name of the user"}));
  EXPECT_TRUE(problems_of_password("correct horse", "Li Wei").empty());
  EXPECT_TRUE(problems_of_password("测试密码测试", "Li Wei").empty());
}

TEST(Users, AreReadAsTheyWereWritten) {
  const Office office;
  const auto users = read_users(office.file);
  ASSERT_EQ(users.size(), 2u);
  EXPECT_EQ(users[0].name, "Li Wei");
  EXPECT_EQ(users[0].roles, std::set<Right>{Right::operate});
  EXPECT_EQ(users[1].name, "A. \"B\" Šimon");
  EXPECT_EQ(users[1].roles, (std::set<Right>{Right::read, Right::approve}));
  struct stat state {};
  ASSERT_EQ(stat(office.file.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0600u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"Li Wei"}, .table = "[[user]]", .key = "name"}, [&] {
    add_user(office.file, {"Li Wei", {Right::read}, hash_of_horse()});
  }));
}

TEST(Users, KeepTheRestOfTheFileWhenAPasswordChanges) {
  const Office office;
  std::string text = read_text_file(office.file);
  text += "# remark of the laboratory\n";
  write_file_atomically(office.file, text);
  const auto other = hash_of_password("another horse");
  change_password(office.file, "A. \"B\" Šimon", other);
  const std::string changed = read_text_file(office.file);
  EXPECT_NE(changed.find("# remark of the laboratory"), std::string::npos);
  EXPECT_EQ(read_users(office.file)[1].password, other);
  EXPECT_EQ(read_users(office.file)[0].password, hash_of_horse());
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"nobody"}},
                      [&] { change_password(office.file, "nobody", other); }));
}

TEST(Users, SayAllThatIsWrongWithTheirFile) {
  const ScratchFolder scratch;
  const auto file = (scratch.path / "users.toml").string();
  write_file_atomically(file,
                        "[[user]]\nname = \"a\"\nroles = [\"admin\"]\npassword = \"secret\"\nshoe = 42\n"
                        "[[user]]\nname = \"a\"\n");
  try {
    read_users(file);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.size(), 6u) << error.what();
    for (const std::string& problem : texts_of(error.problems))
      EXPECT_EQ(problem.find("secret"), std::string::npos) << problem;
  }
}

TEST(Users, OfAFileThatOthersMayWriteAreRefused) {
  const Office office;
  chmod(office.file.c_str(), 0666);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {office.file}, .pattern = "chmod"},
                      [&] { read_users(office.file); }));
}

TEST(SignIn, OpensASessionWithTheRolesOfItsUser) {
  Office office;
  const Guard guard{"", "127.0.0.1", 8321, false, "", office.sign_in()};
  EXPECT_FALSE(guard.session_of(with_cookie(""))) << "an empty token lets everybody in only where there are no users";
  ASSERT_EQ(guard.users->check("Li Wei", "correct horse").state, State::right);
  const auto cookie = guard.cookie(guard.users->begin("Li Wei"));
  const auto session = guard.session_of(with_cookie(cookie));
  ASSERT_TRUE(session);
  EXPECT_EQ(session->user, "Li Wei");
  EXPECT_TRUE(session->may(Right::read) && session->may(Right::operate));
  EXPECT_FALSE(session->may(Right::approve));
  EXPECT_NE(cookie.find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie.find("SameSite=Strict"), std::string::npos);
}

TEST(SignIn, RefusesForgedAndOldCookies) {
  Office office;
  const Guard guard{"", "127.0.0.1", 8321, false, "", office.sign_in()};
  const auto secret = guard.users->begin("Li Wei");
  const auto cookie = guard.cookie(secret);
  std::string forged = cookie;
  forged[forged.find('=') + 1] ^= 1;
  EXPECT_FALSE(guard.session_of(with_cookie(forged)));
  EXPECT_FALSE(guard.session_of(with_cookie(guard.cookie(secret + "0"))));
  EXPECT_FALSE(guard.session_of(with_cookie(guard.cookie("Li Wei"))));
  EXPECT_FALSE(guard.session_of(with_cookie(guard.cookie(guard.begin_by_link()))));  // of a link that nobody has
  EXPECT_FALSE(guard.session_of(with_cookie("tumble_8322=" + secret)));
  office.now += SignIn::longest_session - 1.0;
  EXPECT_TRUE(guard.session_of(with_cookie(cookie)));
  office.now += 2.0;
  EXPECT_FALSE(guard.session_of(with_cookie(cookie)));
  office.now -= 10.0;
  EXPECT_FALSE(guard.session_of(with_cookie(cookie))) << "a session that has ended stays ended";
}

TEST(SignIn, EndsWithSignOutAndWithTheUser) {
  Office office;
  const auto users = office.sign_in();
  const auto first = users->begin("Li Wei"), second = users->begin("Li Wei");
  users->end(first);
  EXPECT_FALSE(users->session_of(first));
  EXPECT_TRUE(users->session_of(second));
  change_password(office.file, "Li Wei", hash_of_password("another horse"));
  office.touch();
  EXPECT_FALSE(users->session_of(second)) << "a new password ends the sessions of the old one";
  const auto third = users->begin("Li Wei");
  const auto text = read_text_file(office.file);
  write_file_atomically(office.file, text.substr(text.rfind("[[user]]")));
  office.touch();
  EXPECT_FALSE(users->session_of(third));
}

TEST(SignIn, TakesRolesAwayAtOnce) {
  Office office;
  const auto users = office.sign_in();
  const auto secret = users->begin("Li Wei");
  auto text = read_text_file(office.file);
  text.replace(text.find("operate"), 7, "read");
  write_file_atomically(office.file, text);
  office.touch();
  const auto session = users->session_of(secret);
  ASSERT_TRUE(session);
  EXPECT_FALSE(session->may(Right::operate));
}

/// The thread of the network asks so: it waits for no disk.
TEST(SignIn, HearsOfAChangeWithoutBeingAsked) {
  Office office;
  const auto users = office.sign_in();
  const auto secret = users->begin("Li Wei");
  EXPECT_TRUE(users->known_session_of(secret));
  auto text = read_text_file(office.file);
  text.replace(text.find("operate"), 7, "read");
  write_file_atomically(office.file, text);
  office.touch();
  while (users->known_session_of(secret)->may(Right::operate)) std::this_thread::yield();
}

TEST(SignIn, LetsNobodyInWhereItsFileIsBroken) {
  Office office;
  const auto users = office.sign_in();
  const auto secret = users->begin("Li Wei");
  write_file_atomically(office.file, "[[user]]\nname = ");
  office.touch();
  EXPECT_FALSE(users->session_of(secret));
  EXPECT_EQ(users->check("Li Wei", "correct horse").state, State::wrong);
}

TEST(SignIn, CountsWrongPasswordsAndPauses) {
  Office office;
  const auto users = office.sign_in();
  for (const std::string name : {"Li Wei", "nobody"}) {  // who is not there is treated as who is
    for (unsigned i = 1; i < SignIn::free_attempts; ++i) {
      const auto check = users->check(name, "wrong horse");
      EXPECT_EQ(check.state, State::wrong);
      EXPECT_EQ(check.remaining, SignIn::free_attempts - i);
    }
    EXPECT_EQ(users->check(name, "wrong horse").pause, SignIn::first_pause);
    EXPECT_EQ(users->check(name, "correct horse").state, State::paused) << "not even the right one is looked at";
  }
  office.now += SignIn::first_pause + 1.0;
  EXPECT_EQ(users->check("Li Wei", "wrong horse").pause, 2.0 * SignIn::first_pause);
  office.now += 2.0 * SignIn::first_pause + 1.0;
  const auto right = users->check("Li Wei", "correct horse");
  EXPECT_EQ(right.state, State::right);
  EXPECT_EQ(right.before, SignIn::free_attempts + 1);
  EXPECT_EQ(users->check("Li Wei", "correct horse").before, 0u);
}

}  // namespace
}  // namespace tumble
