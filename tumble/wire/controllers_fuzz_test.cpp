#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "tumble/units/error.hpp"
#include "tumble/wire/controllers.hpp"
#include "tumble/wire/testing/conversation.hpp"

/// Bytes that no sound line carries, for the host and the device of every declaration: 10^4 inputs each, or
/// TUMBLE_FUZZ_INPUTS. A test that hangs runs into the limit of ctest.
namespace tumble {

namespace assets {
extern const std::vector<std::pair<std::string_view, std::string_view>> controllers;
}

namespace {

using testing::ControllerTalk;
using FuzzRandom = testing::ControllerRandom;

std::size_t inputs_from(const char* text) {
  if (text == nullptr) return 10000;
  std::size_t inputs = 0;
  const std::string_view word = text;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), inputs);
  if (error == std::errc() && end == word.data() + word.size() && inputs > 0) return inputs;
  throw std::invalid_argument(fmt::format("TUMBLE_FUZZ_INPUTS is '{}'; accepted: a whole number from 1", text));
}

/// A declaration with some talks of each of its commands.
struct FuzzStage {
  Controller controller;
  std::vector<ControllerTalk> talks;
  std::string letters;  ///< bytes that stand in them
};

FuzzStage stage_of(const std::string& name) {
  FuzzStage stage{controller_of(find_controller(name)), {}, ""};
  FuzzRandom random(29);
  for (const auto& command : stage.controller.commands)
    for (int times = 0; times < 8; ++times) {
      const auto request = testing::random_request(stage.controller, command, random);
      const auto answer = testing::random_reply(stage.controller, request, random);
      stage.talks.push_back(testing::talk_of(stage.controller, request, answer));
      for (const auto& bytes : stage.talks.back().questions) stage.letters += bytes;
      for (const auto& bytes : stage.talks.back().replies) stage.letters += bytes;
    }
  return stage;
}

/// One to four bytes that changed, are absent, or are too many.
std::string mutated(std::string bytes, FuzzRandom& random) {
  for (std::size_t times = 1 + random() % 4; times > 0; --times) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    const char c = static_cast<char>(random() % 256);
    const auto kind = random() % 4;
    if (kind == 0 || bytes.empty())
      bytes.insert(at, 1, c);
    else if (kind == 1)
      bytes[at] = c;
    else if (kind == 2)
      bytes.erase(at, 1 + random() % 3);
    else
      bytes.insert(at, bytes.substr(0, random() % 20));
  }
  return bytes;
}

std::string random_bytes(const std::string& letters, FuzzRandom& random) {
  std::string bytes(random() % 200, '\0');
  const bool any = random() % 2 == 0;
  for (char& c : bytes) c = any ? static_cast<char>(random() % 256) : letters[random() % letters.size()];
  return bytes;
}

enum class Spoiled { mutated, cut, doubled, other, random, endless };

/// What arrives in place of `bytes`; `other` is a sound line of another exchange.
std::string spoiled(Spoiled kind, const std::string& bytes, const std::string& other, const FuzzStage& stage,
                    FuzzRandom& random) {
  switch (kind) {
    case Spoiled::mutated:
      return mutated(random() % 4 == 0 ? bytes + other : bytes, random);
    case Spoiled::cut:
      return bytes.substr(0, random() % bytes.size());
    case Spoiled::doubled:
      return bytes + bytes;
    case Spoiled::other:
      return other;
    case Spoiled::random:
      return random_bytes(stage.letters, random);
    case Spoiled::endless:
      break;
  }
  return std::string(stage.controller.longest + random() % 3, stage.letters[random() % stage.letters.size()]);
}

Spoiled any_kind(FuzzRandom& random) {
  const auto number = random() % 64;  // long lines take long: few of them
  if (number == 0) return Spoiled::endless;
  return number < 32 ? Spoiled::mutated : static_cast<Spoiled>(1 + number % 4);
}

/// An exchange whose text has bytes, of the replies or of the questions.
struct FuzzPlace {
  const ControllerTalk* talk = nullptr;
  std::size_t exchange = 0;
};

FuzzPlace any_place(const FuzzStage& stage, std::vector<std::string> ControllerTalk::*side, FuzzRandom& random) {
  for (;;) {
    const auto& talk = stage.talks[random() % stage.talks.size()];
    const std::size_t exchange = random() % (talk.*side).size();
    if (!(talk.*side)[exchange].empty()) return {&talk, exchange};
  }
}

/// A host that awaits the reply of this exchange.
ControllerHost host_at(const Controller& controller, const FuzzPlace& place) {
  ControllerHost host(controller);
  host.ask(place.talk->request);
  for (std::size_t i = 0; i < place.exchange; ++i) {
    host.feed(place.talk->replies[i]);
    host.next();
  }
  return host;
}

template <class Side>
auto feed_in_pieces(Side& side, std::string_view bytes, FuzzRandom& random) {
  decltype(side.feed(bytes)) all;
  const std::size_t piece = random() % 4 == 0 ? 1 : 1 + random() % (bytes.size() + 1);
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    for (auto& one : side.feed(bytes.substr(at, piece))) all.push_back(std::move(one));
  return all;
}

/// Whether the words are those that the declaration knows.
bool has_known_words(const Controller& controller, const ControllerReply& reply) {
  return std::ranges::all_of(reply.words, [&](const auto& word) {
    const auto texts = controller.words.find(word.first);
    return texts == controller.words.end() ||
           std::ranges::find(texts->second, word.second, &ControllerWords::value_type::second) != texts->second.end();
  });
}

/// What is wrong with a reply to this request; empty: nothing.
std::string fault_of(const Controller& controller, const ControllerRequest& request, const ControllerReply& reply) {
  if (reply.verb == ControllerVerb::notice) return "";
  if (reply.verb != request.verb || reply.axis != request.axis) return "a reply of " + name(reply.verb);
  const bool fulfils = testing::is_accepted(reply);
  if (!fulfils && !(reply.values.empty() && reply.words.empty())) return "values of a reply that is not accepted";
  const auto& gives = controller.find(request.verb)->gives;
  for (const auto& [name, value] : reply.values) {
    if (!std::isfinite(value)) return name + " is not a number";
    if (std::ranges::find(gives, name.substr(0, name.find('.'))) == gives.end()) return "an unknown value " + name;
  }
  return has_known_words(controller, reply) ? "" : "an unknown word";
}

/// Asks again after the spoiled bytes: a rest of them may spoil one reply, and not two.
bool recovers(const Controller& controller, ControllerHost& host, const ControllerTalk& talk) {
  for (int times = 0; times < 2; ++times) {
    if (!host.idle()) host.give_up();
    host.line_is_clear();
    ControllerDevice device(controller);
    const auto conversation = testing::carry_out(host, device, talk.request, talk.answer);
    if (std::ranges::count_if(conversation.replies, testing::is_accepted) == 1) return true;
  }
  return false;
}

/// The device understands a sound command again, at the latest when what waits for its end is too long.
bool recovers(const FuzzStage& stage, ControllerDevice& device, FuzzRandom& random) {
  const auto& controller = stage.controller;
  const ControllerTalk* talk = nullptr;
  while (talk == nullptr || talk->questions.size() > 1) talk = &stage.talks[random() % stage.talks.size()];
  const std::string& question = talk->questions.front();
  for (std::size_t sent = 0; sent <= 2 * (controller.longest + question.size()); sent += question.size())
    if (!device.feed(question).empty()) return true;
  return false;
}

class ControllerFuzz : public ::testing::TestWithParam<std::string> {};

TEST_P(ControllerFuzz, TheHostAcceptsNoReplyOfAnotherCommand) {
  const FuzzStage stage = stage_of(GetParam());
  FuzzRandom random(37);
  for (std::size_t n = inputs_from(std::getenv("TUMBLE_FUZZ_INPUTS")); n > 0; --n) {
    const auto place = any_place(stage, &ControllerTalk::replies, random);
    const auto other = any_place(stage, &ControllerTalk::replies, random);
    const Spoiled kind = any_kind(random);
    const std::string& sound = place.talk->replies[place.exchange];
    const auto bytes = spoiled(kind, sound, other.talk->replies[other.exchange], stage, random);
    ControllerHost host = host_at(stage.controller, place);
    const auto replies = feed_in_pieces(host, bytes, random);
    for (const auto& reply : replies) ASSERT_EQ(fault_of(stage.controller, place.talk->request, reply), "") << bytes;
    const auto accepted = std::ranges::count_if(replies, testing::is_accepted);
    ASSERT_LE(accepted, 1) << "one request was asked";
    if (kind == Spoiled::cut && sound.find_first_not_of("\r\n", bytes.size()) != std::string::npos) {
      ASSERT_EQ(accepted, 0) << bytes;
    }
    if (n % 4 != 0) continue;
    ASSERT_TRUE(recovers(stage.controller, host, *place.talk)) << bytes;
  }
}

TEST_P(ControllerFuzz, TheDeviceUnderstandsOnlyWhatIsDeclaredAndRecovers) {
  const FuzzStage stage = stage_of(GetParam());
  FuzzRandom random(41);
  for (std::size_t n = inputs_from(std::getenv("TUMBLE_FUZZ_INPUTS")); n > 0; --n) {
    const auto place = any_place(stage, &ControllerTalk::questions, random);
    const auto other = any_place(stage, &ControllerTalk::questions, random);
    const auto bytes = spoiled(any_kind(random), place.talk->questions[place.exchange],
                               other.talk->questions[other.exchange], stage, random);
    ControllerDevice device(stage.controller);
    for (const auto& request : feed_in_pieces(device, bytes, random)) {
      ASSERT_NE(stage.controller.find(request.verb), nullptr);
      for (const auto& [name, value] : request.values) ASSERT_TRUE(std::isfinite(value)) << name;
      ASSERT_LE(request.axis, static_cast<int>(stage.controller.axes.size()));
    }
    device.output();
    if (n % 4 != 0) continue;
    ASSERT_TRUE(recovers(stage, device, random)) << bytes;
  }
}

std::vector<std::string> names_of_controllers() {
  std::vector<std::string> names;
  for (const auto& [name, text] : assets::controllers) names.emplace_back(name);
  std::ranges::sort(names);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Shipped, ControllerFuzz, ::testing::ValuesIn(names_of_controllers()),
                         [](const auto& entry) { return entry.param; });

}  // namespace
}  // namespace tumble
