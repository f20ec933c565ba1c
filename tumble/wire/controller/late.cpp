// Replies that come after their request was given up: protocols without tags do not say which question they answer.
#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/body.hpp"

namespace tumble {
namespace {

constexpr ControllerVerb harmless_questions[] = {ControllerVerb::identify, ControllerVerb::state, ControllerVerb::alarm,
                                                 ControllerVerb::read, ControllerVerb::set_point};

/// A reply to this exchange, with any values; absent: none can be made.
std::optional<std::string> any_reply(const Controller& controller, const ControllerExchange& exchange) {
  if (exchange.expect.empty()) return std::nullopt;
  controller::Content content;
  content.axis = 1;
  for (const auto& piece : exchange.expect.front().pieces) {
    if (piece.kind == ControllerPiece::Kind::number) content.values[controller::key_of(piece)] = 1.0;
    if (piece.kind == ControllerPiece::Kind::word)
      content.words[piece.text] =
          piece.otherwise.value_or(std::string(static_cast<std::size_t>(std::max(piece.format.width, 1)), 'x'));
  }
  try {
    return controller::reply_body(controller, exchange, "", content);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// A question that can be asked at any time: one exchange without values, with a reply.
const ControllerExchange* question_of(const Controller& controller, ControllerVerb verb) {
  const ControllerCommand* const command = controller.find(verb);
  if (!command || !command->takes.empty() || command->exchanges.size() != 1) return nullptr;
  const ControllerExchange& exchange = command->exchanges.front();
  return exchange.expect.empty() || exchange.modbus ? nullptr : &exchange;
}

bool names_axis(const ControllerExchange& exchange) {
  return std::ranges::any_of(exchange.send.pieces,
                             [](const ControllerPiece& piece) { return piece.kind == ControllerPiece::Kind::axis; });
}

}  // namespace

void ControllerHost::owe(const ControllerExchange& late) {
  constexpr std::size_t most = 16;
  if (controller_->protocol == Controller::Protocol::modbus_tcp) return;  // its replies say what they answer
  if (owed_.size() == most) owed_.erase(owed_.begin());
  owed_.push_back({&late, sent_});
}

/// The first of the requests that were given up that the body may answer.
std::optional<std::size_t> ControllerHost::late_match(std::string_view body) const {
  const auto found = std::ranges::find_if(owed_, [&](const Owed& owed) {
    return controller::parse_reply(*controller_, *owed.exchange, owed.sent, body).has_value();
  });
  if (found == owed_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - owed_.begin());
}

/// Replies come in the order of the questions: those before one that has come late are lost.
bool ControllerHost::drop_late(std::string_view body) {
  const auto late = late_match(body);
  if (late) owed_.erase(owed_.begin(), owed_.begin() + static_cast<std::ptrdiff_t>(*late) + 1);
  return late.has_value();
}

/// Whether the outstanding request asks for a reading, which must be of now and of its axis. Commands, such as a stop,
/// are sent at once: their replies carry no reading.
bool ControllerHost::is_reading() const {
  return controller::has_reply(exchange()) && !controller::answers_itself(exchange()) && command_->takes.empty();
}

/// Whether a late reply could be taken for that of the outstanding request.
bool ControllerHost::must_clear() const {
  return is_reading() && std::ranges::any_of(owed_, [&](const Owed& owed) {
           const auto late = any_reply(*controller_, *owed.exchange);
           return !late || controller::parse_reply(*controller_, exchange(), "", *late);
         });
}

/// One whose answer is like none that may come late.
const ControllerExchange* ControllerHost::question_to_clear() const {
  for (const ControllerVerb verb : harmless_questions) {
    const ControllerExchange* const question = question_of(*controller_, verb);
    const auto reply = question ? any_reply(*controller_, *question) : std::nullopt;
    if (reply && controller::parse_reply(*controller_, *question, "", *reply) && !late_match(*reply)) return question;
  }
  return nullptr;
}

std::string ControllerHost::ask_to_clear() {
  awaits_ = due_ = true;
  spoiled_ = false;
  probe_ = question_to_clear();
  if (!probe_) {
    // A late reading of the same kind of all axes is a little old, and not of another axis.
    quiet_ = std::ranges::any_of(owed_, [](const Owed& owed) { return names_axis(*owed.exchange); });
    if (!quiet_) owed_.clear();
    return quiet_ ? "" : send();
  }
  sent_ = controller::request_body(*controller_, *probe_, {{}, {}, request_.axis});
  return controller::wrap(*controller_, controller::Direction::request, sent_, probe_->bare, ++transaction_);
}

void ControllerHost::line_is_clear() {
  owed_.clear();
  if (probe_ || quiet_) pending_.clear(), awaits_ = false;
  probe_ = nullptr;
  quiet_ = false;
}

void ControllerHost::take_while_unclear(const std::string& body, std::vector<ControllerReply>& replies) {
  if (body.empty()) return;
  if (const auto notice = controller::notice_of(*controller_, body)) return replies.push_back(*notice);
  const bool is_late = drop_late(body);
  if (!is_late && probe_ && controller::parse_reply(*controller_, *probe_, sent_, body)) return line_is_clear();
  replies.push_back(problem(say("'{}' is a late reply to a request that was given up", controller::shown(body))));
  if (quiet_ && owed_.empty()) line_is_clear();
}

}  // namespace tumble
