#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/body.hpp"

namespace tumble {

ControllerDevice::ControllerDevice(const Controller& declaration)
    : controller_(&declaration), progress_(declaration.commands.size()) {}

namespace {

/// Where a bare question may stand: a single byte anywhere before the end of the line, as controllers take it out of
/// what they receive; others at its begin.
std::size_t place_of_bare(const Controller& controller, const ControllerExchange& exchange,
                          const std::string& pending) {
  const auto& pieces = exchange.send.pieces;
  const bool is_byte = pieces.size() == 1 && pieces[0].kind == ControllerPiece::Kind::literal &&
                       pieces[0].text.size() == 1 && !controller.send.tail.empty();
  if (!is_byte) return 0;
  const auto at = pending.find(pieces[0].text);
  const auto is_before = [&](const std::string& tail) { return pending.find(tail) >= at; };
  return at != std::string::npos && std::ranges::all_of(controller.send.tail, is_before) ? at : 0;
}

}  // namespace

/// Exchanges that are sent bare have no end.
bool ControllerDevice::take_bare(std::vector<ControllerRequest>& requests) {
  for (const auto& command : controller_->commands)
    for (const auto& exchange : command.exchanges) {
      const auto size = exchange.bare ? controller::size_of(exchange.send) : std::nullopt;
      if (!size || pending_.size() < *size) continue;
      const std::size_t at = place_of_bare(*controller_, exchange, pending_);
      const std::string body = pending_.substr(at, *size);
      if (!controller::parse_request(*controller_, exchange, body)) continue;
      pending_.erase(at, *size);
      take_body(body, true, 0, requests);
      return true;
    }
  return false;
}

std::vector<ControllerRequest> ControllerDevice::feed(std::string_view bytes) {
  std::vector<ControllerRequest> requests;
  pending_ += bytes;
  const auto sizes = controller::request_sizes(*controller_);
  for (;;) {
    if (take_bare(requests)) continue;
    const auto line = controller::take_line(*controller_, controller::Direction::request, sizes, pending_);
    if (!line) break;
    if (!line->problem.empty()) problems_.push_back(line->problem);
    if (line->body && !(line->body->empty() && controller_->trim))
      take_body(*line->body, false, line->transaction, requests);
  }
  return requests;
}

/// What these bytes may be: each verb either goes on with its next exchange or begins again.
std::vector<ControllerDevice::Match> ControllerDevice::matches_of(const std::string& body, bool bare) const {
  std::vector<Match> matches;
  for (std::size_t c = 0; c < controller_->commands.size(); ++c) {
    const auto& command = controller_->commands[c];
    if (command.same_as) continue;
    const auto try_from = [&](std::size_t from) {
      for (std::size_t e = from; e < command.exchanges.size(); ++e) {
        const auto& exchange = command.exchanges[e];
        const auto content =
            exchange.bare == bare ? controller::parse_request(*controller_, exchange, body) : std::nullopt;
        if (content) {
          Match match{c, e, {command.verb, content->values, content->axis.value_or(0)}};
          matches.push_back(match);
          return true;
        }
        if (exchange.when.empty()) return false;
      }
      return false;
    };
    if (progress_[c].next == 0 || !try_from(progress_[c].next)) try_from(0);
  }
  return matches;
}

void ControllerDevice::take_body(const std::string& body, bool bare, std::uint16_t transaction,
                                 std::vector<ControllerRequest>& requests) {
  Slot slot;
  slot.sent = body;
  slot.transaction = transaction;
  const auto matches = matches_of(body, bare);
  if (!matches.empty()) return proceed(matches, slot, requests);
  problems_.push_back(say("unknown command '{}'", controller::shown(body)));
  slot.answered = true;
  slot.bytes = error_bytes(slot, "unknown command");
  slots_.push_back(slot);
}

/// Moves every verb on that the line fits, and decides for which of them the line is answered: one that it completes,
/// one that was under way, the one that moved last.
void ControllerDevice::proceed(const std::vector<Match>& matches, Slot slot, std::vector<ControllerRequest>& requests) {
  ++lines_;
  std::tuple<bool, bool, std::uint64_t> best{false, false, 0};
  bool completes = false;
  for (const auto& match : matches) {
    const auto& command = controller_->commands[match.command];
    Progress& progress = progress_[match.command];
    const bool goes_on = progress.next > 0 && match.exchange >= progress.next;
    const bool ends = match.exchange + 1 == command.exchanges.size();
    const std::tuple rank{ends, goes_on, goes_on ? progress.when : 0};
    if (!goes_on) progress.request = {command.verb, {}, 1};
    for (const auto& [name, value] : match.request.values) progress.request.values[name] = value;
    if (match.request.axis > 0) progress.request.axis = match.request.axis;
    progress.next = ends ? 0 : match.exchange + 1;
    progress.when = lines_;
    if (slot.command && rank <= best) continue;
    best = rank;
    slot.command = &command, slot.exchange = match.exchange, slot.request = progress.request, completes = ends;
  }
  const ControllerExchange& exchange = slot.command->exchanges[slot.exchange];
  if (completes || !controller::answers_itself(exchange)) {
    requests.push_back(slot.request);
  } else {
    slot.answered = true;
    slot.bytes = reply_bytes(slot, {});
  }
  slots_.push_back(slot);
}

std::string ControllerDevice::reply_bytes(const Slot& slot, const ControllerReply& reply) const {
  const ControllerExchange& exchange = slot.command->exchanges[slot.exchange];
  if (!controller::has_reply(exchange)) return "";
  if (reply.refused) return error_bytes(slot, reply.text);
  const auto content = controller::content_of(*controller_, reply, slot.request);
  std::string body = controller::reply_body(*controller_, exchange, slot.sent, content);
  if (controller_->echo == Controller::Echo::always) body = slot.sent + "\r\n" + body;
  return controller::wrap(*controller_, controller::Direction::reply, body, false, slot.transaction);
}

std::string ControllerDevice::error_bytes(const Slot& slot, const std::string& text) const {
  const ControllerExchange* const exchange = slot.command ? &slot.command->exchanges[slot.exchange] : nullptr;
  const auto body = controller::refusal_body(*controller_, exchange, slot.sent, text);
  if (!body) return "";
  return controller::wrap(*controller_, controller::Direction::reply, *body, false, slot.transaction);
}

void ControllerDevice::answer(const ControllerReply& reply) {
  const auto slot = std::ranges::find(slots_, false, &Slot::answered);
  if (slot == slots_.end())
    throw Error(Error::Kind::bad_input, say("{}: there is no request to answer", Name{controller_->name}));
  try {
    slot->bytes = reply_bytes(*slot, reply);
  } catch (const Error& error) {
    throw Error(error.kind,
                say("{}: answer to {}: {}", Name{controller_->name}, Name{name(slot->request.verb)}, reason_of(error)));
  }
  slot->answered = true;
}

void ControllerDevice::notice(const std::string& state) {
  for (const auto& notice : controller_->notices) {
    if (notice.state != state) continue;
    Slot slot;
    slot.answered = true;
    slot.bytes = controller::wrap(*controller_, controller::Direction::reply,
                                  controller::fill(notice.expect, {}, controller_->axes));
    slots_.push_back(slot);
    return;
  }
  throw Error(Error::Kind::bad_input, say("{}: there is no notice that says '{}'", Name{controller_->name}, state));
}

std::string ControllerDevice::output() {
  std::string bytes;
  for (; !slots_.empty() && slots_.front().answered; slots_.pop_front()) bytes += slots_.front().bytes;
  return bytes;
}

Problems ControllerDevice::problems() {
  Problems problems;
  problems.swap(problems_);
  return problems;
}

}  // namespace tumble
