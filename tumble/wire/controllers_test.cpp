#include "tumble/wire/controllers.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/testing/conversation.hpp"

namespace tumble {
namespace {

using testing::carry_out;
using testing::Conversation;
using testing::is_accepted;
using testing::random_reply;
using testing::random_request;
using Random = testing::ControllerRandom;

template <class Test>
void for_each_controller(Test test) {
  for (const auto& shipped : shipped_controllers()) {
    SCOPED_TRACE(shipped.name);
    test(controller_of(shipped));
  }
}

void expect_understood(const Controller& controller, const ControllerRequest& request,
                       const Conversation& conversation) {
  ASSERT_FALSE(conversation.understood.empty());
  const ControllerRequest& last = conversation.understood.back();
  const auto* command = controller.find(request.verb);
  EXPECT_EQ(last.verb, command->same_as.value_or(request.verb));
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
  EXPECT_FALSE(reply.refused) << reply.text.text();
  EXPECT_EQ(reply.verb, request.verb);
  EXPECT_EQ(reply.axis, request.axis);
  for (const auto& [name, word] : answer.words) EXPECT_EQ(reply.words.at(name), word) << name;
  for (const auto& [name, value] : answer.values) {
    if (name.find('.') != std::string::npos) continue;
    EXPECT_NEAR(reply.values.at(name), value, resolution_of(controller, request.verb, name, value)) << name;
  }
}

TEST(ShippedControllers, VectorsHoldBothWays) {
  for_each_controller([](const Controller& controller) {
    EXPECT_EQ(texts_of(problems_of_vectors(controller)), std::vector<std::string>{});
  });
}

TEST(ShippedControllers, WhatIsAskedIsUnderstoodAndAnsweredByteByByte) {
  for_each_controller([](const Controller& controller) {
    Random random(19);
    ControllerHost host(controller);
    ControllerDevice device(controller);
    for (int trial = 0; trial < 40; ++trial)
      for (const auto& command : controller.commands) {
        SCOPED_TRACE(name(command.verb));
        const auto request = random_request(controller, command, random);
        const auto answer = random_reply(controller, request, random);
        const auto conversation = carry_out(host, device, request, answer);
        EXPECT_TRUE(host.idle());
        EXPECT_EQ(conversation.problems, std::vector<std::string>{});
        expect_understood(controller, request, conversation);
        expect_answered(controller, request, answer, conversation);
        if (::testing::Test::HasFailure()) return;
      }
  });
}

/// Whether the last exchange can say no.
bool can_refuse(const Controller& controller, const ControllerCommand& command) {
  const auto& last = command.exchanges.back();
  const bool replies = last.modbus || !last.expect.empty();
  const bool is_http = controller.protocol == Controller::Protocol::http;
  return replies && (last.modbus || is_http || !controller.errors.empty() || !last.refused.empty());
}

TEST(ShippedControllers, ARefusalArrivesAsOne) {
  for_each_controller([](const Controller& controller) {
    Random random(23);
    for (const auto& command : controller.commands) {
      if (!can_refuse(controller, command)) continue;
      SCOPED_TRACE(name(command.verb));
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

/// One byte that differs is seen by every one of these checksums.
TEST(ShippedControllers, OneWrongByteIsNeverAcceptedBehindAChecksum) {
  int tried = 0;
  for_each_controller([&](const Controller& controller) {
    if (!controller.checksum.sum) return;
    Random random(31);
    for (const auto& command : controller.commands) {
      const auto request = random_request(controller, command, random);
      const auto talk = testing::talk_of(controller, request, random_reply(controller, request, random));
      for (std::size_t at = 0; at < talk.replies[0].size(); ++at)
        for (int other = 1; other < 256; ++other, ++tried) {
          std::string bytes = talk.replies[0];
          bytes[at] = static_cast<char>(bytes[at] ^ other);
          ControllerHost host(controller);
          host.ask(request);
          host.feed(bytes);
          ASSERT_TRUE(host.waiting()) << at << " " << other;
        }
    }
  });
  EXPECT_GT(tried, 10000);
}

TEST(ShippedControllers, HaveVectorsAndATitleThatPromisesNothing) {
  for_each_controller([](const Controller& controller) {
    EXPECT_FALSE(controller.vectors.empty());
    EXPECT_FALSE(controller.source.empty());
    EXPECT_NE(controller.find(ControllerVerb::read), nullptr) << "what cannot be read cannot be confirmed";
  });
}

/// Another request came first, and its reply comes after it was given up. Commands that differ only in their arguments
/// may have the same reply ($ASMOD,OK to each mode).
TEST(ShippedControllers, ALateReplyIsNotTakenForTheNextWhereRepliesSayWhoseTheyAre) {
  int tried = 0;
  for (const char* name : {"mn_three_axis", "newport_smc100", "cts_ethernet", "cts_serial", "watlow_f4t"}) {
    SCOPED_TRACE(name);
    const Controller controller = controller_of(find_controller(name));
    Random random(43);
    for (const auto& late : controller.commands)
      for (const auto& next : controller.commands) {
        const auto first = random_request(controller, late, random);
        const auto second = random_request(controller, next, random);
        const auto talk = testing::talk_of(controller, first, random_reply(controller, first, random));
        ControllerHost host(controller);
        if (talk.replies[0].empty() || host.ask(first).empty()) continue;
        host.give_up();
        const bool asks_the_same = host.ask(second) == talk.questions[0];
        const auto own = testing::talk_of(controller, second, random_reply(controller, second, random));
        if (asks_the_same || !host.waiting() || own.replies[0] == talk.replies[0]) continue;
        host.feed(talk.replies[0]);
        EXPECT_FALSE(host.idle()) << tumble::name(late.verb) << " for " << tumble::name(next.verb);
        ++tried;
      }
  }
  EXPECT_GT(tried, 100);
}

TEST(ShippedControllers, EveryCommandHasAVector) {
  for_each_controller([](const Controller& controller) {
    for (const auto& command : controller.commands) {
      if (command.same_as) continue;
      const auto holds = [&](const ControllerVector& vector) { return vector.request.verb == command.verb; };
      EXPECT_TRUE(std::ranges::any_of(controller.vectors, holds)) << name(command.verb);
    }
  });
}

bool is_sure(FrameCertainty certainty) {
  return certainty == FrameCertainty::maker || certainty == FrameCertainty::crossed;
}

TEST(ShippedControllers, AreOnlySupportedIfReadingAndStoppingAreSure) {
  for_each_controller([](const Controller& controller) {
    EXPECT_EQ(controller.supported(), is_sure(controller.certainty));
    for (const ControllerVerb verb : {ControllerVerb::read, ControllerVerb::stop, ControllerVerb::off}) {
      const auto* const command = controller.supported() ? controller.find(verb) : nullptr;
      EXPECT_TRUE(!command || is_sure(command->certainty)) << name(verb);
    }
  });
}

TEST(ControllerDevice, TakesABareByteOutOfALine) {
  const Controller controller = controller_of(find_controller("grbl"));
  ControllerDevice device(controller);
  const auto requests = device.feed("$\xff?");
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_EQ(requests[0].verb, ControllerVerb::read);
  const auto later = device.feed("$X\n?");
  EXPECT_EQ(later.back().verb, ControllerVerb::read);
}

TEST(FindController, NamesTheNearest) {
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.values = {"espec_p30", "espec_p300"}},
                      [] { find_controller("espec_p30"); }));
}

TEST(ControllerOf, TakesSettings) {
  const auto& shipped = find_controller("acutrol_like");
  const Controller controller = controller_of(shipped, {{"reply_prefix", "8"}, {"axes", "2"}});
  ControllerHost host(controller);
  EXPECT_EQ(host.ask({ControllerVerb::stop, {}, 2}), ":mode:off 2\r\n");
  const auto replies = host.feed("12345678OK\r\n");
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_TRUE(is_accepted(replies[0])) << replies[0].problem.text();
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"prefix"}}, [&] {
    controller_of(shipped, {{"prefix", "8"}});
  }));
}

TEST(ShippedControllers, AChamberSetToDecimalCommasIsNotRead) {
  const Controller espec = controller_of(find_controller("espec_p300"), {});
  ControllerHost host(espec);
  host.ask({ControllerVerb::read});
  const auto replies = host.feed("23,5,25,0,180,0,-75,0\r\n");
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_FALSE(replies[0].problem.empty()) << "23.5 degC is not 23 degC";
}

}  // namespace
}  // namespace tumble
