#include "tumble/wire/controllers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Random = std::mt19937_64;

template <class Test>
void for_each_controller(Test test) {
  for (const auto& shipped : shipped_controllers()) {
    SCOPED_TRACE(shipped.name);
    test(controller_of(shipped));
  }
}

double uniform(Random& random, double least, double most) {
  return std::uniform_real_distribution<>(least, most)(random);
}

/// [SI] a value that rigs have.
double random_value(const std::string& name, Random& random) {
  if (name == "temperature" || name == "set_point") return si(uniform(random, -70.0, 180.0), "degC");
  if (name == "ramp") return si(uniform(random, 0.2, 15.0), "K/min");
  if (name == "position" || name == "phase") return si(uniform(random, -360.0, 360.0), "deg");
  if (name == "rate") return si(uniform(random, -300.0, 300.0), "deg/s");
  return uniform(random, 0.1, 20.0);  // acceleration, amplitude, frequency, voltage, current, numbers
}

ControllerRequest random_request(const Controller& controller, const ControllerCommand& command, Random& random) {
  ControllerRequest request{command.verb, {}, 1 + static_cast<int>(random() % controller.axes.size())};
  for (const auto& name : command.takes) {
    const bool is_needed = std::ranges::find(command.requires_, name) != command.requires_.end();
    if (name.find('.') == std::string::npos && name != "mode" && (is_needed || random() % 2 == 0))
      request.values[name] = random_value(name, random);
  }
  // A speed has no sign where a position says the direction; a table is told a position before it is started again.
  if (command.verb == "position" && request.values.contains("rate"))
    request.values["rate"] = std::abs(request.values["rate"]);
  if (controller.name == "voetsch_ascii2" && command.verb != "off" && !command.takes.empty())
    request.values["temperature"] = random_value("temperature", random);
  return request;
}

/// Words and values for everything that the reply carries.
ControllerReply random_reply(const Controller& controller, const ControllerRequest& request, Random& random) {
  ControllerReply reply{request.verb};
  for (const auto& name : controller.find(request.verb)->gives) {
    if (request.values.contains(name)) continue;
    const auto bits = std::ranges::find(controller.bits, name, &ControllerBits::from);
    if (const auto words = controller.words.find(name); words != controller.words.end())
      reply.words[name] = words->second[random() % words->second.size()].second;
    else if (name == "identity" || name == "code" || name == "alarm" || name == "codes")
      reply.words[name] = "x" + std::to_string(random() % 1000);
    else if (bits != controller.bits.end())
      reply.words[bits->word] = bits->rules[random() % bits->rules.size()].means;
    else
      reply.values[name] = random_value(name, random);
  }
  return reply;
}

/// A request and everything that follows, byte by byte.
struct Conversation {
  std::vector<ControllerRequest> understood;
  std::vector<ControllerReply> replies;
  std::vector<std::string> problems;
};

Conversation carry_out(ControllerHost& host, ControllerDevice& device, const ControllerRequest& request,
                       const ControllerReply& answer) {
  Conversation conversation;
  for (std::string bytes = host.ask(request); !bytes.empty(); bytes = host.next()) {
    for (const char c : bytes)
      for (const auto& understood : device.feed({&c, 1})) {
        conversation.understood.push_back(understood);
        device.answer(understood.verb == "stop" && request.verb != "stop" ? ControllerReply{} : answer);
      }
    for (const auto& reply : host.feed("")) conversation.replies.push_back(reply);
    for (const char c : device.output())
      for (const auto& reply : host.feed({&c, 1})) conversation.replies.push_back(reply);
  }
  conversation.problems = device.problems();
  return conversation;
}

void expect_understood(const Controller& controller, const ControllerRequest& request,
                       const Conversation& conversation) {
  ASSERT_FALSE(conversation.understood.empty());
  const ControllerRequest& last = conversation.understood.back();
  const auto* command = controller.find(request.verb);
  EXPECT_EQ(last.verb, command->same_as.empty() ? request.verb : command->same_as);
  for (const auto& [name, value] : request.values) {
    const auto single = last.values.find(name + "." + std::to_string(request.axis));
    const auto found = single == last.values.end() ? last.values.find(name) : single;
    ASSERT_NE(found, last.values.end()) << name;
    EXPECT_NEAR(found->second, value, resolution_of(controller, request.verb, name, value)) << name;
  }
}

void expect_answered(const Controller& controller, const ControllerRequest& request, const ControllerReply& answer,
                     const Conversation& conversation) {
  ASSERT_EQ(conversation.replies.size(), 1u) << "one request, one reply";
  const ControllerReply& reply = conversation.replies.front();
  EXPECT_EQ(reply.problem, "");
  EXPECT_FALSE(reply.refused) << reply.text;
  EXPECT_EQ(reply.verb, request.verb);
  EXPECT_EQ(reply.axis, request.axis);
  for (const auto& [name, word] : answer.words) EXPECT_EQ(reply.words.at(name), word) << name;
  for (const auto& [name, value] : answer.values)
    EXPECT_NEAR(reply.values.at(name), value, resolution_of(controller, request.verb, name, value)) << name;
}

TEST(ShippedControllers, VectorsHoldBothWays) {
  for_each_controller(
      [](const Controller& controller) { EXPECT_EQ(problems_of_vectors(controller), std::vector<std::string>{}); });
}

TEST(ShippedControllers, WhatIsAskedIsUnderstoodAndAnsweredByteByByte) {
  for_each_controller([](const Controller& controller) {
    Random random(19);
    ControllerHost host(controller);
    ControllerDevice device(controller);
    for (int trial = 0; trial < 40; ++trial)
      for (const auto& command : controller.commands) {
        SCOPED_TRACE(command.verb);
        const auto request = random_request(controller, command, random);
        const auto answer = random_reply(controller, request, random);
        const auto conversation = carry_out(host, device, request, answer);
        EXPECT_TRUE(host.idle());
        EXPECT_EQ(conversation.problems, std::vector<std::string>{});
        expect_understood(controller, request, conversation);
        expect_answered(controller, request, answer, conversation);
        if (testing::Test::HasFailure()) return;
      }
  });
}

/// Whether the last exchange can say no.
bool can_refuse(const Controller& controller, const ControllerCommand& command) {
  const auto& last = command.exchanges.back();
  const bool replies = last.modbus || !last.expect.empty();
  return replies && (last.modbus || !controller.errors.empty() || !last.refused.empty());
}

TEST(ShippedControllers, ARefusalArrivesAsOne) {
  for_each_controller([](const Controller& controller) {
    Random random(23);
    for (const auto& command : controller.commands) {
      if (!can_refuse(controller, command)) continue;
      SCOPED_TRACE(command.verb);
      ControllerHost host(controller);
      ControllerDevice device(controller);
      ControllerReply no{command.verb};
      no.refused = true, no.text = "not now";
      const auto conversation = carry_out(host, device, random_request(controller, command, random), no);
      ASSERT_EQ(conversation.replies.size(), 1u);
      EXPECT_TRUE(conversation.replies[0].refused);
      EXPECT_TRUE(conversation.replies[0].values.empty());
      EXPECT_FALSE(conversation.replies[0].text.empty());
    }
  });
}

/// The bytes of one exchange of every command, to be spoiled: what was asked, and its reply.
struct Exchange {
  ControllerRequest request;
  std::string question, reply;
};

std::vector<Exchange> exchanges_of(const Controller& controller, Random& random) {
  std::vector<Exchange> all;
  for (const auto& command : controller.commands) {
    ControllerHost host(controller);
    ControllerDevice device(controller);
    const auto request = random_request(controller, command, random);
    Exchange exchange{request, host.ask(request), ""};
    for (std::size_t n = device.feed(exchange.question).size(); n > 0; --n)
      device.answer(random_reply(controller, request, random));
    exchange.reply = device.output();
    if (!exchange.reply.empty()) all.push_back(exchange);
  }
  return all;
}

std::string mutated(std::string bytes, Random& random) {
  for (std::size_t times = 1 + random() % 4; times > 0; --times) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    const char c = static_cast<char>(random() % 256);
    switch (random() % 6) {
      case 0:
        if (!bytes.empty()) bytes[at] = c;
        break;
      case 1:
        if (!bytes.empty()) bytes.erase(at, 1 + random() % 3);
        break;
      case 2:
        bytes.insert(at, 1, c);
        break;
      case 3:
        bytes.insert(at, bytes.substr(0, random() % 20));
        break;
      case 4:
        bytes.resize(at);
        break;
      default:
        bytes += bytes.substr(at);
    }
  }
  return bytes;
}

bool is_accepted(const ControllerReply& reply) {
  return reply.problem.empty() && !reply.refused && reply.verb != "notice";
}

TEST(ShippedControllers, SurviveTenThousandMutatedInputs) {
  for_each_controller([](const Controller& controller) {
    Random random(29);
    const auto exchanges = exchanges_of(controller, random);
    ASSERT_FALSE(exchanges.empty());
    for (int trial = 0; trial < 10000; ++trial) {
      const auto& exchange = exchanges[random() % exchanges.size()];
      ControllerHost host(controller);
      ControllerDevice device(controller);
      host.ask(exchange.request);
      std::size_t accepted = 0;
      for (const auto& reply : host.feed(mutated(exchange.reply, random))) {
        for (const auto& [name, value] : reply.values) ASSERT_TRUE(std::isfinite(value)) << name;
        accepted += is_accepted(reply) ? 1 : 0;
      }
      ASSERT_LE(accepted, 1u) << "one request was asked";
      device.feed(mutated(exchange.question, random));
      device.output();
    }
  });
}

/// One byte that differs is seen by every one of these checksums.
TEST(ShippedControllers, OneWrongByteIsNeverAcceptedBehindAChecksum) {
  int tried = 0;
  for_each_controller([&](const Controller& controller) {
    const bool has_checksum = controller.checksum.kind != ControllerChecksum::Kind::none ||
                              controller.protocol == Controller::Protocol::modbus_rtu;
    if (!has_checksum) return;
    Random random(31);
    for (const auto& exchange : exchanges_of(controller, random))
      for (std::size_t at = 0; at < exchange.reply.size(); ++at)
        for (int other = 1; other < 256; ++other, ++tried) {
          std::string bytes = exchange.reply;
          bytes[at] = static_cast<char>(bytes[at] ^ other);
          ControllerHost host(controller);
          host.ask(exchange.request);
          for (const auto& reply : host.feed(bytes)) ASSERT_FALSE(is_accepted(reply)) << at << " " << other;
        }
  });
  EXPECT_GT(tried, 10000);
}

TEST(ShippedControllers, HaveVectorsAndATitleThatPromisesNothing) {
  for_each_controller([](const Controller& controller) {
    EXPECT_FALSE(controller.vectors.empty());
    EXPECT_FALSE(controller.source.empty());
    EXPECT_NE(controller.find("read"), nullptr) << "what cannot be read cannot be confirmed";
  });
}

TEST(FindController, NamesTheNearest) {
  try {
    find_controller("espec_p30");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'espec_p300'?"), std::string::npos) << error.what();
  }
}

TEST(ControllerOf, TakesSettings) {
  const auto& shipped = find_controller("acutrol_like");
  const Controller controller = controller_of(shipped, {{"reply_prefix", "8"}, {"axes", "2"}});
  ControllerHost host(controller);
  EXPECT_EQ(host.ask({"stop", {}, 2}), ":mode:off 2\r\n");
  const auto replies = host.feed("12345678OK\r\n");
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_TRUE(is_accepted(replies[0])) << replies[0].problem;
  EXPECT_THROW(controller_of(shipped, {{"prefix", "8"}}), Error);
}

}  // namespace
}  // namespace tumble
