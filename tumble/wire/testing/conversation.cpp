#include "tumble/wire/testing/conversation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble::testing {

namespace {

double uniform(ControllerRandom& random, double least, double most) {
  return std::uniform_real_distribution<>(least, most)(random);
}

/// [SI] a value that rigs have.
double random_value(const std::string& name, ControllerRandom& random) {
  if (name == "temperature" || name == "set_point") return si(uniform(random, -70.0, 180.0), "degC");
  if (name == "ramp") return si(uniform(random, 0.2, 15.0), "K/min");
  if (name == "position" || name == "phase") return si(uniform(random, -360.0, 360.0), "deg");
  if (name == "rate") return si(uniform(random, -300.0, 300.0), "deg/s");
  return uniform(random, 0.1, 20.0);  // acceleration, amplitude, frequency, voltage, current, numbers
}

/// What the virtual rig says to the request that the device understood: the whole answer to the one that was asked.
ControllerReply reply_to(const ControllerRequest& understood, const ControllerRequest& asked,
                         const ControllerReply& answer) {
  return understood.verb == ControllerVerb::stop && asked.verb != ControllerVerb::stop ? ControllerReply{} : answer;
}

}  // namespace

ControllerRequest random_request(const Controller& controller, const ControllerCommand& command,
                                 ControllerRandom& random) {
  ControllerRequest request{command.verb, {}, 1 + static_cast<int>(random() % controller.axes.size())};
  for (const auto& name : command.takes) {
    const bool is_needed = std::ranges::find(command.requires_, name) != command.requires_.end();
    if (name.find('.') == std::string::npos && name != "mode" && (is_needed || random() % 2 == 0))
      request.values[name] = random_value(name, random);
  }
  // A speed has no sign where a position says the direction; a chamber is told a temperature before it is started
  // again.
  if (command.verb == ControllerVerb::position && request.values.contains("rate"))
    request.values["rate"] = std::abs(request.values["rate"]);
  if (controller.name == "voetsch_ascii2" && command.verb != ControllerVerb::off && !command.takes.empty())
    request.values["temperature"] = random_value("temperature", random);
  return request;
}

ControllerReply random_reply(const Controller& controller, const ControllerRequest& request, ControllerRandom& random) {
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
      reply.values[name] = reply.values[fmt::format("{}.{}", name, request.axis)] = random_value(name, random);
  }
  return reply;
}

Conversation carry_out(ControllerHost& host, ControllerDevice& device, const ControllerRequest& request,
                       const ControllerReply& answer) {
  Conversation conversation;
  for (std::string bytes = host.ask(request); !bytes.empty(); bytes = host.next()) {
    for (const char c : bytes)
      for (const auto& understood : device.feed({&c, 1})) {
        conversation.understood.push_back(understood);
        device.answer(reply_to(understood, request, answer));
      }
    for (const auto& reply : host.feed("")) conversation.replies.push_back(reply);
    for (const char c : device.output())
      for (const auto& reply : host.feed({&c, 1})) conversation.replies.push_back(reply);
  }
  conversation.problems = texts_of(device.problems());
  return conversation;
}

ControllerTalk talk_of(const Controller& controller, const ControllerRequest& request, const ControllerReply& answer) {
  ControllerTalk talk{request, answer, {}, {}};
  ControllerHost host(controller);
  ControllerDevice device(controller);
  for (std::string bytes = host.ask(request); !bytes.empty(); bytes = host.next()) {
    for (const auto& understood : device.feed(bytes)) device.answer(reply_to(understood, request, answer));
    talk.questions.push_back(bytes);
    talk.replies.push_back(device.output());
    host.feed(talk.replies.back());
  }
  return talk;
}

bool is_accepted(const ControllerReply& reply) {
  return reply.problem.empty() && !reply.refused && reply.verb != ControllerVerb::notice;
}

}  // namespace tumble::testing
