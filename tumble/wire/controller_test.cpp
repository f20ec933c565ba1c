#include "tumble/wire/controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::string table_text(const std::string& tail) {
  return R"(title = "a table"
certainty = "computed"
axes = ["X", "Y"]
link = {tcp = 1000}
[framing]
send = {head = "$", tail = "\r\n"}
reply = {head = "$", tail = "\r\n"}
checksum = {kind = "sum_hex", mark = "*"}
[[error]]
expect = "ERR {code=7}"
meaning = {7 = "locked"}
[[notice]]
expect = "ALARM {code=1}"
state = "fault"
[word.state]
M = "moving"
S = "ready"
[command.rate]
exchange = [
  {send = "A {axis},{acceleration:.2f deg/s^2}", expect = "OK A", when = "acceleration"},
  {send = "V {rate.1:.3f deg/s=0},{rate.2:.3f deg/s=0}", expect = "OK V"},
]
[command.position]
send = "P {axis}{position:.3f deg}"
expect = "OK {position:.3f deg}"
timeout = "3 s"
[command.stop]
send = "!"
bare = true
[command.read]
send = "R {axis}"
expect = "R {axis} {position:.3f deg}"
[command.state]
send = "S"
expect = "S {state}"
)" + tail;
}

constexpr const char* position_vector = R"(
[[vector]]
made_by_hand = true
verb = "state"
send = "$S*53\r\n"
reply = "$S M*C0\r\n"
words = {state = "moving"}
)";

Controller table() { return read_controller(table_text(position_vector), "table.toml"); }

/// "$body*CS" with the sum that its characters have.
std::string line(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum += static_cast<unsigned char>(c);
  char digits[3];
  std::snprintf(digits, sizeof digits, "%02X", sum & 0xffu);
  return "$" + body + "*" + digits + "\r\n";
}

Refused refusal(const std::string& text) {
  return refusal_of([&] { read_controller(text, "table.toml"); });
}

TEST(ControllerVerb, IsFoundByTheWordThatItHas) {
  for (const auto& word : controller_verbs()) {
    const auto verb = find_verb(word);
    ASSERT_TRUE(verb) << word;
    EXPECT_EQ(name(*verb), word);
  }
  EXPECT_EQ(find_verb("set_temperature"), ControllerVerb::set_temperature);
  EXPECT_EQ(find_verb("random"), ControllerVerb::random);
  EXPECT_FALSE(find_verb("notice")) << "only a reply has it";
  EXPECT_FALSE(find_verb(""));
}

TEST(ReadController, SaysEveryProblemWithItsLineAndTheNearestKey) {
  const Refused all = refusal(table_text(position_vector) + R"(
[command.sine]
sned = "S"
expect = "{amplitude:.3f V}"
[command.rotate]
send = "R {position:.3q deg}"
[bits.alarm]
from = "alarms"
rules = [{means = "a"}, {bit = 1, means = "b"}]
)");
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      {{.values = {"sned", "send"}, .table = "[command.sine]"},
                       {.values = {"send", "send"}, .pattern = "is missing", .table = "[command.sine]"},
                       {.values = {"amplitude", "deg", "V"}},
                       {.values = {"rotate"}, .pattern = "unknown verb"},
                       {.values = {".3q"}, .pattern = "is not a format"},
                       {.values = {"b"}, .pattern = "the rules before it hold"}},
                      all));
  for (const Problem& problem : all.problems) EXPECT_EQ(problem.where.file, "table.toml") << problem.text();
}

TEST(ReadController, NeedsAVectorThatHolds) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "there is no [[vector]]", .file = "table.toml"},
                      refusal(table_text(""))));
  std::string wrong = position_vector;
  wrong.replace(wrong.find("moving"), 6, "ready");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"state", "moving", "ready"}, .table = "vector"},
                      refusal(table_text(wrong))));
  wrong = position_vector;
  wrong.replace(wrong.find("*53"), 3, "*54");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "$S*54", .pattern = "is stated, and the declaration gives"},
                      refusal(table_text(wrong))));
}

TEST(ReadController, AVectorThatDoesNotHoldIsAPlaceInTheFile) {
  std::string wrong = position_vector;
  wrong.replace(wrong.find("moving"), 6, "ready");
  try {
    read_controller(table_text(wrong), "table.toml");
    FAIL();
  } catch (const Error& error) {
    const Where& where = error.problems.at(0).where;
    EXPECT_EQ(where.file, "table.toml");
    EXPECT_GT(where.line, 0u);
    EXPECT_EQ(where.table, "vector");
  }
}

TEST(ReadController, RefusesCommandsThatTheDeviceSideCannotDistinguish) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"state"}, .pattern = "write same_as"},
                      refusal(table_text(position_vector) + "[command.hold]\nsend = \"S\"\nexpect = \"S {state}\"\n")));
}

TEST(ControllerHost, SendsOnlyTheExchangesThatTheRequestWants) {
  const Controller controller = table();
  ControllerHost host(controller);
  EXPECT_EQ(host.ask({ControllerVerb::rate, {{"rate", si(2.0, "deg/s")}}, 2}), line("V 0.000,2.000"));
  EXPECT_EQ(host.feed(line("OK V")).size(), 1u);
  EXPECT_EQ(host.ask({ControllerVerb::rate, {{"rate", si(1.0, "deg/s")}, {"acceleration", si(5.0, "deg/s^2")}}, 1}),
            line("A X,5.00"));
  EXPECT_TRUE(host.feed(line("OK A")).empty());
  EXPECT_EQ(host.next(), line("V 1.000,2.000")) << "the other axis keeps what was sent last";
  EXPECT_TRUE(host.next().empty());
  EXPECT_EQ(host.feed(line("OK V")).size(), 1u);
  EXPECT_TRUE(host.idle());
}

TEST(ControllerHost, ReportsWhatIsNoAnswerAndGoesOnWaiting) {
  const Controller controller = table();
  ControllerHost host(controller);
  host.ask({ControllerVerb::read, {}, 1});
  const auto problem_after = [&](const std::string& bytes) {
    const auto replies = host.feed(bytes);
    return replies.size() == 1 && replies[0].values.empty() ? replies[0].problem.text() : "not one problem";
  };
  EXPECT_NE(problem_after(line("OK V")).find("is a reply to 'rate'"), std::string::npos);
  EXPECT_NE(problem_after("$R X 1.000*00\r\n").find("wrong checksum"), std::string::npos);
  EXPECT_NE(problem_after("$R X\r\n").find("wrong checksum"), std::string::npos);
  EXPECT_NE(problem_after(line("R Y 1.000")).find("a reply of axis Y"), std::string::npos);
  EXPECT_NE(problem_after(line("what")).find("unknown reply 'what'"), std::string::npos);
  EXPECT_NE(problem_after("noise\r\n").find("does not begin with"), std::string::npos);
  EXPECT_NE(problem_after(line("R X 1.0x")).find("unknown reply"), std::string::npos);
  EXPECT_NE(problem_after(std::string(2000, 'x')).find("without an end of line"), std::string::npos);
  EXPECT_TRUE(host.waiting());
  const auto replies = host.feed(line("R X -1.500"));
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_DOUBLE_EQ(replies[0].values.at("position"), si(-1.5, "deg"));
  EXPECT_NE(host.feed(line("R X 1.0"))[0].problem.text().find("although nothing was asked"), std::string::npos);
}

TEST(ControllerHost, FindsTheReplyBehindACutLine) {
  const Controller controller = table();
  ControllerHost host(controller);
  host.ask({ControllerVerb::read, {}, 1});
  const auto replies = host.feed("$R X 1.0" + line("R X 2.000"));
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_NE(replies[0].problem.text().find("stands before"), std::string::npos);
  EXPECT_DOUBLE_EQ(replies[1].values.at("position"), si(2.0, "deg"));
}

TEST(ControllerHost, RefusesByErrorTextsAndByValuesThatComeBackOtherwise) {
  const Controller controller = table();
  ControllerHost host(controller);
  host.ask({ControllerVerb::position, {{"position", si(10.0, "deg")}}, 1});
  EXPECT_DOUBLE_EQ(host.timeout(), 3.0);
  auto replies = host.feed(line("ERR 7"));
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_TRUE(replies[0].refused);
  EXPECT_EQ(replies[0].text, "ERR 7: locked");
  host.ask({ControllerVerb::position, {{"position", si(10.0, "deg")}}, 1});
  replies = host.feed(line("OK 11.000"));
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_TRUE(replies[0].refused && replies[0].values.empty()) << replies[0].text.text();
}

TEST(ControllerHost, SaysWhatIsMissingWhenItGivesUp) {
  const Controller controller = table();
  ControllerHost host(controller);
  host.ask({ControllerVerb::read, {}, 2});
  host.feed("$R Y 1.2");
  const std::string problem = host.give_up().problem;
  EXPECT_NE(problem.find("no reply to 'R Y' within 1 s; received was '$R Y 1.2', which is cut"), std::string::npos)
      << problem;
  EXPECT_TRUE(host.idle());
}

TEST(ControllerHost, RefusesRequestsThatDoNotFitBeforeAnythingIsSent) {
  const Controller controller = table();
  ControllerHost host(controller);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.values = {"position", "position"}, .pattern = "needs the value"}, [&] {
        host.ask({ControllerVerb::position, {}, 1});
      }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"position", "rate"}, .pattern = "takes no"}, [&] {
    host.ask({ControllerVerb::position, {{"position", 1.0}, {"rate", 1.0}}, 1});
  })) << "a rate would be ignored";
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"position"}, .pattern = "is not a number"}, [&] {
    host.ask({ControllerVerb::position, {{"position", std::nan("")}}, 1});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"3", "2"}, .pattern = "no axis"}, [&] {
    host.ask({ControllerVerb::read, {}, 3});
  }));
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.values = {"home"}}, [&] {
    host.ask({ControllerVerb::home, {}, 1});
  }));
  EXPECT_TRUE(host.idle());
  host.ask({ControllerVerb::read, {}, 1});
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"read", "read"}, .pattern = "outstanding"}, [&] {
    host.ask({ControllerVerb::read, {}, 1});
  })) << "one request at a time";
}

TEST(ControllerHost, PassesNoticesOn) {
  const Controller controller = table();
  ControllerHost host(controller);
  ControllerDevice device(controller);
  device.notice("fault");
  const auto replies = host.feed(device.output());
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].verb, ControllerVerb::notice);
  EXPECT_EQ(replies[0].words.at("state"), "fault");
}

TEST(ControllerDevice, AnswersInOrderAndRefusesWhatItDoesNotKnow) {
  const Controller controller = table();
  ControllerDevice device(controller);
  const auto requests = device.feed(line("R X") + line("what") + "!" + line("S"));
  ASSERT_EQ(requests.size(), 3u);
  EXPECT_EQ(requests[1].verb, ControllerVerb::stop);
  EXPECT_EQ(device.output(), "") << "the first request has no answer yet";
  device.answer({ControllerVerb::read, {{"position", si(1.0, "deg")}}});
  EXPECT_EQ(device.output(), line("R X 1.000") + line("ERR 7"));
  device.answer({ControllerVerb::stop});
  device.answer({ControllerVerb::state, {}, {{"state", "ready"}}});
  EXPECT_EQ(device.output(), line("S S"));
  EXPECT_EQ(device.problems().size(), 1u);
  device.feed(line("S"));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"state", "state", "flying"}}, [&] {
    device.answer({ControllerVerb::state, {}, {{"state", "flying"}}});
  }));
}

TEST(ControllerDevice, AcknowledgesTheStepsBeforeTheLast) {
  const Controller controller = table();
  ControllerDevice device(controller);
  EXPECT_TRUE(device.feed(line("A Y,5.00")).empty());
  EXPECT_EQ(device.output(), line("OK A"));
  const auto requests = device.feed(line("V 0.000,3.000"));
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_EQ(requests[0].axis, 2);
  EXPECT_DOUBLE_EQ(requests[0].values.at("acceleration"), si(5.0, "deg/s^2"));
  EXPECT_DOUBLE_EQ(requests[0].values.at("rate.2"), si(3.0, "deg/s"));
}

constexpr const char* binary_text = R"(title = "a table with binary frames"
certainty = "computed"
link = {serial = "115200:8E1"}
[framing]
send = {head = "\u00AA\u0055"}
reply = {head = "\u00AA\u00AB"}
checksum = {kind = "xor", with_head = true}
[command.rate]
send = "\u0001{rate:i32le 0.0001 deg/s}"
expect = "\u0001"
[command.read]
send = "\u0002"
expect = "\u0002{position:i32le 0.0001 deg}{rate:f32be deg/s}"
[[vector]]
made_by_hand = true
verb = "rate"
values = {rate = "-1 deg/s"}
send_hex = "AA 55 01 F0 D8 FF FF D6"
reply_hex = "AA AB 01 00"
)";

TEST(ControllerHost, SpeaksBinaryFramesWithoutATail) {
  const Controller controller = read_controller(binary_text, "binary.toml");
  ControllerHost host(controller);
  ControllerDevice device(controller);
  const auto requests = device.feed("\x55noise" + host.ask({ControllerVerb::read}));
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_EQ(device.problems().size(), 1u) << "the noise";
  device.answer({ControllerVerb::read, {{"position", si(-123.4567, "deg")}, {"rate", si(0.5, "deg/s")}}});
  std::string bytes = device.output();
  std::vector<ControllerReply> replies;
  for (const char c : bytes)
    for (const auto& reply : host.feed({&c, 1})) replies.push_back(reply);
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_NEAR(replies[0].values.at("position"), si(-123.4567, "deg"), si(5e-5, "deg"));
  EXPECT_DOUBLE_EQ(replies[0].values.at("rate"), si(0.5, "deg/s"));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"rate", "300000", "deg/s"}}, [&] {
    host.ask({ControllerVerb::rate, {{"rate", si(3e5, "deg/s")}}});
  })) << "more than 32 bits";
}

}  // namespace
}  // namespace tumble
