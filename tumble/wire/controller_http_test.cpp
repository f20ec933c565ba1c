#include <gtest/gtest.h>

#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {
namespace {

const Controller& shaker() {
  static const Controller controller = controller_of(find_controller("vibrationview"));
  return controller;
}

/// What a host that asked for the level gets from these bytes.
std::vector<ControllerReply> replies_to_read(const std::string& bytes) {
  ControllerHost host(shaker());
  host.ask({ControllerVerb::read});
  return host.feed(bytes);
}

const std::string level_of_2_g = "HTTP/1.1 200 OK\r\nContent-Length: 26\r\n\r\n{\"data\": {\"result\":[2.0]}}";

TEST(ControllerHttp, ReadsMessagesInChunks) {
  const auto replies = replies_to_read(
      "HTTP/1.1 200 OK\r\nTransfer-Encoding: "
      "chunked\r\n\r\n8\r\n{\"data\":\r\n10\r\n{\"result\":[0.5]}\r\n1\r\n}\r\n0\r\n\r\n");
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].problem, "");
  EXPECT_NEAR(replies[0].values.at("acceleration"), 0.5 * 9.80665, 1e-6);
}

TEST(ControllerHttp, ReportsWhatIsNoMessageAndReadsTheNext) {
  const auto replies = replies_to_read("rubbish\r\n" + level_of_2_g);
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_NE(replies[0].problem.text().find("'rubbish<0D><0A>' is no message of HTTP"), std::string::npos)
      << replies[0].problem.text();
  EXPECT_NEAR(replies[1].values.at("acceleration"), 2.0 * 9.80665, 1e-6);
}

TEST(ControllerHttp, WaitsForTheReplyBehindAnInterimOne) {
  const auto replies = replies_to_read("HTTP/1.1 100 Continue\r\n\r\n" + level_of_2_g);
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_NE(replies[0].problem, "");
  EXPECT_EQ(replies[1].problem, "");
}

TEST(ControllerHttp, AcceptsNoReplyWithoutTheValue) {
  for (const char* text : {"{\"data\":{\"result\":[]}}", "{\"data\":{\"result\":[[]]}}", "{\"data\":{\"result\":\"2\"}",
                           "[2.0]", "2.0", "{\"data\":{\"result\":[null]}}"}) {
    const std::string body = text;
    const auto replies =
        replies_to_read("HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    ASSERT_EQ(replies.size(), 1u) << text;
    EXPECT_NE(replies[0].problem.text().find("unknown reply"), std::string::npos) << replies[0].problem.text();
  }
}

TEST(ControllerHttp, ADeviceSaysThatATargetIsUnknown) {
  ControllerDevice device(shaker());
  EXPECT_TRUE(device.feed("GET /api/v1/fly HTTP/1.1\r\nHost: a\r\n\r\n").empty());
  const std::string bytes = device.output();
  EXPECT_TRUE(bytes.starts_with("HTTP/1.1 404 Error\r\n")) << bytes;
  EXPECT_TRUE(bytes.ends_with("{\"error\":{\"message\":\"unknown command\"}}")) << bytes;
}

TEST(ControllerHttp, ADeclarationNeedsPointersAndReplies) {
  const Refused refusal = refusal_of([] {
    read_controller(R"(title = "a"
certainty = "uncertain"
protocol = "http"
[link]
tcp = 80
[http]
message = "error"
headers = "A: b\r\nC: d"
[command.read]
send = "GET /a"
json = "/a~2"
)",
                    "a.toml");
  });
  EXPECT_TRUE(refuses(
      Error::Kind::bad_input,
      {{.pattern = "a JSON pointer is expected", .file = "a.toml", .table = "[http]", .key = "message", .line = 7},
       {.pattern = "host and headers have no end of line"},
       {.pattern = "JSON pointers are expected", .key = "json"},
       {.values = {"expect", "expect"}, .pattern = "is missing"}},
      refusal));
}

}  // namespace
}  // namespace tumble
