#pragma once

#include <random>
#include <string>
#include <vector>

#include "tumble/wire/controller.hpp"

/// For the tests of controllers: requests, replies, and hosts and devices that talk with each other.
namespace tumble::testing {

using ControllerRandom = std::mt19937_64;

/// A request of this command with values that rigs have; values without which it is refused are always there.
ControllerRequest random_request(const Controller& controller, const ControllerCommand& command,
                                 ControllerRandom& random);

/// Words and values for everything that the reply to this request carries.
ControllerReply random_reply(const Controller& controller, const ControllerRequest& request, ControllerRandom& random);

/// A request and everything that follows, byte by byte.
struct Conversation {
  std::vector<ControllerRequest> understood;  ///< by the device
  std::vector<ControllerReply> replies;       ///< to the host
  std::vector<std::string> problems;          ///< of the device
};

/// Asks the host, carries all bytes, and answers each request that the device reports with `answer`.
Conversation carry_out(ControllerHost& host, ControllerDevice& device, const ControllerRequest& request,
                       const ControllerReply& answer);

/// The bytes of one request and of its reply, exchange by exchange.
struct ControllerTalk {
  ControllerRequest request;
  ControllerReply answer;
  std::vector<std::string> questions, replies;  ///< a question without a reply has an empty one
};

/// The talk that a new host has with a new device about this request.
ControllerTalk talk_of(const Controller& controller, const ControllerRequest& request, const ControllerReply& answer);

/// Whether the reply fulfils the request.
bool is_accepted(const ControllerReply& reply);

}  // namespace tumble::testing
