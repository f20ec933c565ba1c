#include "tumble/serve/workbench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/serve/event_feed.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/guard.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

TEST(Workbench, EveryRouteIsDescribed) {
  std::ifstream file(TUMBLE_SOURCE_DIR "/web/openapi.json");
  const auto description = nlohmann::json::parse(file);
  std::vector<std::string> described;
  for (const auto& [path, methods] : description.at("paths").items())
    for (const auto& [method, entry] : methods.items())
      described.push_back((method == "get" ? "GET " : "POST ") + path);
  auto routes = workbench_routes();
  std::ranges::sort(routes);
  std::ranges::sort(described);
  EXPECT_EQ(routes, described);
}

TEST(EventFeed, GoesOnBehindAnyEventThatItKeeps) {
  EventFeed feed(100);
  std::uint64_t seen = feed.latest();
  EXPECT_EQ(seen, 99u);
  EXPECT_EQ(feed.after(seen), "");
  feed.publish("job", "{1}");
  feed.publish("job", "{2}");
  EXPECT_EQ(feed.after(seen), "id: 100\nevent: job\ndata: {1}\n\nid: 101\nevent: job\ndata: {2}\n\n");
  EXPECT_EQ(seen, 101u);
  seen = 100;
  EXPECT_EQ(feed.after(seen), "id: 101\nevent: job\ndata: {2}\n\n");
}

TEST(EventFeed, SaysWhereItCannotGoOn) {
  EventFeed feed(100);
  for (int i = 0; i < 5000; ++i) feed.publish("job", "{}");
  for (std::uint64_t seen : {0ul, 50ul, 200ul, 5100ul, ~0ul}) {
    EXPECT_EQ(feed.after(seen), "id: 5099\nevent: reset\ndata: {}\n\n");
    EXPECT_EQ(seen, 5099u);
  }
}

/// Ids of a journal grow with gaps; a reader who names one gets exactly what is behind it.
TEST(EventFeed, GoesOnBehindAnIdOfAJournal) {
  EventFeed feed(1);
  for (const std::uint64_t id : {10, 10, 25, 40}) feed.publish("happened", "{}", id);
  const auto text_after = [&](std::uint64_t id) {
    auto seen = feed.seen_by_id(id);
    return feed.after(seen);
  };
  const std::string of_25 = "id: 25\nevent: happened\ndata: {}\n\n", of_40 = "id: 40\nevent: happened\ndata: {}\n\n";
  EXPECT_EQ(text_after(10), of_25 + of_40);
  EXPECT_EQ(text_after(24), of_25 + of_40);
  EXPECT_EQ(text_after(25), of_40);
  EXPECT_EQ(text_after(40), "");
  EXPECT_EQ(text_after(99), "") << "the server was started again, and has not come so far";
  for (std::uint64_t id = 41; id < 3000; ++id) feed.publish("view", "{}", id);
  EXPECT_EQ(text_after(25), "id: 2999\nevent: reset\ndata: {}\n\n") << "some are no longer kept";
  EXPECT_EQ(text_after(2998), "id: 2999\nevent: view\ndata: {}\n\n");
}

TEST(EventFeed, WakesThoseWhoSubscribed) {
  EventFeed feed(1);
  int woken = 0;
  {
    const auto subscription = feed.subscribe([&] { ++woken; });
    feed.publish("job", "{}");
  }
  feed.publish("job", "{}");
  EXPECT_EQ(woken, 1);
}

TEST(FolderPaths, LeadNowhereOutside) {
  const ScratchFolder scratch;
  const fs::path root = scratch.path / "data";
  fs::create_directories(root / "sub");
  std::ofstream(root / "sub" / "a.csv") << "x";
  std::ofstream(scratch.path / "b.csv") << "x";
  fs::create_symlink(scratch.path / "b.csv", root / "link.csv");
  fs::create_symlink("sub/a.csv", root / "near.csv");
  EXPECT_EQ(inside(root, "sub/a.csv"), root / "sub/a.csv");
  EXPECT_EQ(inside(root, "near.csv"), root / "near.csv");
  const auto input = Error::Kind::bad_input;
  for (const std::string name : {"../b.csv", "sub/../../b.csv", "/etc/passwd", "link.csv", "./sub/a.csv",
                                 "sub//../a.csv", ".", "..", "sub/.hidden"})
    EXPECT_TRUE(refuses(input, Asked{.values = {name}}, [&] { inside(root, name); })) << name;
  EXPECT_TRUE(refuses(input, Asked{.pattern = "a link leads out"}, [&] { inside(root, "link.csv"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"none.csv"}}, [&] { inside(root, "none.csv"); }));
  EXPECT_TRUE(refuses(input, Asked{.pattern = "a name is missing"}, [&] { inside(root, ""); }));
  for (const std::string name : {"a/b", "a\\b", ".a", "-a"})
    EXPECT_TRUE(refuses(input, Asked{.values = {name}}, [&] { require_file_name(name); })) << name;
  EXPECT_TRUE(refuses(input, Asked{.pattern = "1 to 200 bytes"}, [] { require_file_name(""); }));
  EXPECT_TRUE(refuses(input, Asked{.pattern = "1 to 200 bytes"}, [] { require_file_name(std::string(201, 'a')); }));
  const Asked cannot_be_shown{.pattern = "characters that cannot be shown"};
  for (const std::string name : {"a\nb", "a\x7f", "\xff", "a\rb", "\xc3"}) {
    EXPECT_TRUE(refuses(input, cannot_be_shown, [&] { inside(root, name); })) << name;
    EXPECT_TRUE(refuses(input, cannot_be_shown, [&] { require_file_name(name); })) << name;
  }
  EXPECT_TRUE(refusal_of([] { require_file_name("测试 1.csv"); }).empty());
}

HttpRequest from(std::map<std::string, std::string> headers, const std::string& method = "GET",
                 const std::string& path = "/api/jobs") {
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.headers = std::move(headers);
  return request;
}

TEST(Guard, KnowsItsOwnNames) {
  const Guard here{"", "127.0.0.1", 8321, false, "lab"};
  for (const char* host : {"127.0.0.1:8321", "localhost:8321", "LOCALHOST:8321", "[::1]:8321"})
    EXPECT_TRUE(here.names_this_server(from({{"host", host}}))) << host;
  for (const char* host : {"", "127.0.0.1", "evil.example:8321", "127.0.0.1.evil.example:8321", "lab:8321",
                           "10.0.0.1:8321", "[::1", "localhost:8321:1", "127.0.0.1:08321"})
    EXPECT_FALSE(here.names_this_server(from({{"host", host}}))) << host;
  const Guard outside{"t", "0.0.0.0", 443, true, "Lab"};
  for (const char* host : {"lab", "lab.local", "LAB:443", "10.0.0.1", "[fe80::1]"})
    EXPECT_TRUE(outside.names_this_server(from({{"host", host}}))) << host;
  EXPECT_FALSE(outside.names_this_server(from({{"host", "lab.evil.example"}})));
}

TEST(Guard, RefusesPagesOfOthers) {
  const Guard guard{"", "127.0.0.1", 8321, false, ""};
  const auto asked = [&](std::map<std::string, std::string> headers, const char* method, const char* path) {
    headers["host"] = "127.0.0.1:8321";
    return guard.is_cross_site(from(headers, method, path));
  };
  EXPECT_FALSE(asked({}, "POST", "/api/jobs/cancel"));
  EXPECT_FALSE(
      asked({{"origin", "http://127.0.0.1:8321"}, {"sec-fetch-site", "same-origin"}}, "POST", "/api/jobs/cancel"));
  EXPECT_TRUE(asked({{"origin", "http://evil.example"}}, "POST", "/api/jobs/cancel"));
  EXPECT_TRUE(asked({{"origin", "null"}}, "POST", "/api/jobs/cancel"));
  EXPECT_TRUE(asked({{"origin", "http://localhost:8321"}}, "POST", "/api/jobs/cancel"));
  EXPECT_TRUE(asked({{"sec-fetch-site", "same-site"}}, "GET", "/api/jobs"));
  EXPECT_FALSE(asked({{"sec-fetch-site", "cross-site"}, {"sec-fetch-mode", "navigate"}}, "GET", "/"));
}

TEST(Guard, RolesAreWhatTheySay) {
  const Guard guard{"secret", "127.0.0.1", 8321, false, ""};
  EXPECT_FALSE(guard.session_of(from({})));
  const auto session = guard.session_of(from({{"authorization", "Bearer secret"}}));
  ASSERT_TRUE(session);
  for (const Right right : all_rights()) EXPECT_TRUE(session->may(right)) << name(right);
  const Session operator_only{"a", {Right::operate}}, approver{"b", {Right::approve}}, nobody{"c", {}};
  EXPECT_TRUE(operator_only.may(Right::read) && operator_only.may(Right::operate) &&
              !operator_only.may(Right::approve));
  EXPECT_TRUE(approver.may(Right::read) && !approver.may(Right::operate) && approver.may(Right::approve));
  EXPECT_FALSE(nobody.may(Right::read));
}

TEST(Guard, TheCookieIsNotTheToken) {
  const Guard guard{"secret", "127.0.0.1", 8321, false, ""};
  const std::string secret = guard.begin_by_link(), cookie = guard.cookie(secret),
                    pair = cookie.substr(0, cookie.find(';'));
  EXPECT_EQ(cookie.find("secret"), std::string::npos);
  EXPECT_TRUE(guard.session_of(from({{"cookie", pair}})));
  EXPECT_TRUE(guard.session_of(from({{"cookie", "a=b; " + pair + "; c=d"}})));
  EXPECT_TRUE(guard.session_of(from({{"authorization", "Bearer secret"}})));
  for (const auto& headers : std::vector<std::map<std::string, std::string>>{{},
                                                                             {{"cookie", pair + "x"}},
                                                                             {{"cookie", "x" + pair}},
                                                                             {{"authorization", "Bearer "}},
                                                                             {{"authorization", "secret"}}})
    EXPECT_FALSE(guard.session_of(from(headers)));
  const std::string other = guard.cookie(guard.begin_by_link());
  guard.end_session(from({{"cookie", pair}}));
  EXPECT_FALSE(guard.session_of(from({{"cookie", pair}}))) << "who has signed out";
  EXPECT_TRUE(guard.session_of(from({{"cookie", other.substr(0, other.find(';'))}}))) << "another browser stays";
}

}  // namespace
}  // namespace tumble
