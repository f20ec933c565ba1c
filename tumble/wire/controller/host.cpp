#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/wire/controller/body.hpp"

namespace tumble {

using controller::Content;
using controller::Direction;
using controller::Line;

namespace {

std::string quoted(const std::string& body) { return "'" + controller::shown(body) + "'"; }

/// Whether the exchange belongs to this request.
bool is_wanted(const ControllerExchange& exchange, const ControllerRequest& request) {
  return exchange.when.empty() || request.values.contains(exchange.when);
}

void require_values(const Controller& declaration, const ControllerCommand& command, const ControllerRequest& request) {
  Problems problems;
  for (const auto& [name, value] : request.values) {
    if (std::ranges::find(command.takes, name) == command.takes.end())
      problems.push_back(say("{}: {} takes no '{}' (it takes: {})", Name{declaration.name},
                             Name{tumble::name(command.verb)}, name,
                             command.takes.empty() ? Sentence("nothing") : say("{}", fmt::join(command.takes, ", "))));
    if (!std::isfinite(value)) problems.push_back(say("{}: {} is not a number", Name{declaration.name}, Name{name}));
  }
  for (const auto& name : command.requires_)
    if (!request.values.contains(name))
      problems.push_back(
          say("{}: {} needs the value '{}'", Name{declaration.name}, Name{tumble::name(command.verb)}, name));
  const int axes = static_cast<int>(declaration.axes.size());
  if (request.axis < 1 || request.axis > axes)
    problems.push_back(say("{}: there is no axis {} (it has {})", Name{declaration.name}, request.axis, axes));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

const ControllerCommand& command_of(const Controller& declaration, ControllerVerb verb) {
  if (const auto* command = declaration.find(verb)) return *command;
  std::vector<std::string> known;
  for (const auto& command : declaration.commands) known.push_back(name(command.verb));
  throw Error(Error::Kind::unsupported, say("{} cannot '{}'{} (it can: {})", Name{declaration.name}, name(verb),
                                            did_you_mean(name(verb), known), fmt::join(known, ", ")));
}

/// A value that comes back under the name that was sent, and is another one.
Sentence other_value(const Controller& declaration, const ControllerRequest& request, const ControllerReply& reply) {
  for (const auto& [name, value] : reply.values) {
    const auto sent = request.values.find(name);
    if (sent == request.values.end()) continue;
    const double step = resolution_of(declaration, request.verb, name, sent->second);
    if (std::abs(value - sent->second) > 2.0 * step)
      return say("{} reads back {:.9g} [SI], and {:.9g} was sent", Name{name}, value, sent->second);
  }
  return {};
}

}  // namespace

const ControllerCommand* Controller::find(ControllerVerb verb) const {
  const auto found = std::ranges::find(commands, verb, &ControllerCommand::verb);
  return found == commands.end() ? nullptr : &*found;
}

ControllerHost::ControllerHost(const Controller& declaration) : controller_(&declaration) {}

double ControllerHost::timeout() const { return command_ ? exchange().timeout : 0.0; }
double ControllerHost::pause() const { return command_ ? exchange().pause : 0.0; }

ControllerReply ControllerHost::problem(const Sentence& what) const {
  ControllerReply reply{request_.verb};
  reply.axis = request_.axis;
  reply.problem = what;
  return reply;
}

/// Those of the request, and for the other axes those that were sent last.
std::map<std::string, double> ControllerHost::values_to_send(const ControllerExchange& sending) const {
  auto values = request_.values;
  for (const auto& [name, value] : sending.set) values.emplace(name, value);
  const std::string mine = fmt::format(".{}", request_.axis);
  const auto now = values;
  for (const auto& [key, value] : last_)
    if (!key.ends_with(mine) || !now.contains(key.substr(0, key.size() - mine.size()))) values.emplace(key, value);
  return values;
}

std::string ControllerHost::ask(const ControllerRequest& request) {
  if (command_)
    throw Error(Error::Kind::bad_input, say("{}: {} was asked while {} is outstanding", Name{controller_->name},
                                            Name{name(request.verb)}, Name{name(request_.verb)}));
  const ControllerCommand& command = command_of(*controller_, request.verb);
  require_values(*controller_, command, request);
  const ControllerRequest before = request_;
  request_ = request;
  try {
    for (const auto& exchange : command.exchanges)
      if (is_wanted(exchange, request))
        controller::request_body(*controller_, exchange, {values_to_send(exchange), {}, request.axis});
  } catch (const Error& error) {
    request_ = before;
    throw Error(error.kind, say("{}: {}: {}", Name{controller_->name}, Name{name(request.verb)}, reason_of(error)));
  }
  command_ = &command;
  reply_ = {request.verb};
  reply_.axis = request.axis;
  exchange_ = 0;
  while (!is_wanted(command.exchanges[exchange_], request_)) ++exchange_;
  return must_clear() ? ask_to_clear() : send();
}

std::string ControllerHost::send() {
  due_ = spoiled_ = false;
  const ControllerExchange& now = exchange();
  sent_ = controller::request_body(*controller_, now, {values_to_send(now), {}, request_.axis});
  awaits_ = controller::has_reply(now);
  ++transaction_;
  std::string bytes = controller::wrap(*controller_, Direction::request, sent_, now.bare, transaction_);
  if (!awaits_) advance(ready_);
  return bytes;
}

std::string ControllerHost::next() { return due_ && !probe_ && !quiet_ ? send() : ""; }

/// The values of single axes that a command with several carries are sent again with the next.
void ControllerHost::remember() {
  const auto values = values_to_send(exchange());
  for (const auto& piece : exchange().send.pieces) {
    if (piece.axis == 0) continue;
    const std::string key = controller::key_of(piece);
    if (const auto value = values.find(key); value != values.end())
      last_[key] = value->second;
    else if (const auto mine = values.find(piece.text); piece.axis == request_.axis && mine != values.end())
      last_[key] = mine->second;
  }
}

void ControllerHost::advance(std::vector<ControllerReply>& replies) {
  remember();
  do {
    ++exchange_;
  } while (exchange_ < command_->exchanges.size() && !is_wanted(exchange(), request_));
  awaits_ = false;
  due_ = exchange_ < command_->exchanges.size();
  if (!due_) end(reply_, replies);
}

/// What was stopped must not begin again with the next line that carries all axes: a stop that names no axis has
/// stopped them all.
void ControllerHost::forget_motions() {
  const auto names_axis = [](const ControllerPiece& piece) {
    return piece.axis != 0 || piece.kind == ControllerPiece::Kind::axis;
  };
  const bool of_one = std::ranges::any_of(command_->exchanges, [&](const ControllerExchange& one) {
    return one.modbus || std::ranges::any_of(one.send.pieces, names_axis);
  });
  const std::string mine = fmt::format(".{}", request_.axis);
  std::erase_if(last_, [&](const auto& value) { return !of_one || value.first.ends_with(mine); });
}

void ControllerHost::end(ControllerReply reply, std::vector<ControllerReply>& replies) {
  if (command_->verb == ControllerVerb::stop) forget_motions();
  replies.push_back(std::move(reply));
  command_ = nullptr;
  awaits_ = due_ = false;
}

void ControllerHost::accept(const ControllerReply& part, std::vector<ControllerReply>& replies) {
  for (const auto& [name, value] : part.values) reply_.values[name] = value;
  for (const auto& [name, word] : part.words) reply_.words[name] = word;
  const Sentence other = other_value(*controller_, request_, part);
  if (other.empty()) return advance(replies);
  ControllerReply refused{request_.verb, {}, {}, true, other};
  refused.axis = request_.axis;
  end(refused, replies);
}

void ControllerHost::take_body(std::string body, std::vector<ControllerReply>& replies) {
  const ControllerExchange* const now = awaited();
  if (now && controller_->echo != Controller::Echo::never && !sent_.empty() && body.starts_with(sent_))
    body = controller::stripped(body.substr(sent_.size()));
  if (probe_ || quiet_) return take_while_unclear(body, replies);
  const auto refused = now ? controller::refusal(*controller_, now, body) : std::nullopt;
  if (refused) {
    ControllerReply reply{request_.verb, {}, {}, true, say("{}", Name{*refused})};
    reply.axis = request_.axis;
    return end(reply, replies);
  }
  const auto content = now ? controller::parse_reply(*controller_, *now, sent_, body) : std::nullopt;
  if (content) {
    const ControllerReply part = controller::meaning_of(*controller_, *content, request_);
    if (is_reading() || !late_match(body)) owed_.clear();  // replies come in the order of the questions
    if (part.problem.empty()) return accept(part, replies);
    return replies.push_back(part);
  }
  if (body.empty()) return;
  drop_late(body);
  if (const auto notice = controller::notice_of(*controller_, body)) return replies.push_back(*notice);
  if (!now) return replies.push_back(problem(say("{} came although nothing was asked", Name{quoted(body)})));
  for (const auto& command : controller_->commands)
    for (const auto& other : command.exchanges)
      if (&command != command_ && !other.modbus && controller::parse_reply(*controller_, other, "", body))
        return replies.push_back(problem(say("{} is a reply to '{}', and '{}' was asked", Name{quoted(body)},
                                             name(command.verb), name(request_.verb))));
  spoiled_ = true;
  replies.push_back(problem(say("unknown reply {} to {}", Name{quoted(body)}, Name{quoted(sent_)})));
}

std::vector<ControllerReply> ControllerHost::feed(std::string_view bytes) {
  std::vector<ControllerReply> replies;
  replies.swap(ready_);
  pending_ += bytes;
  for (;;) {
    const auto sizes = controller::reply_sizes(*controller_, awaited());
    const auto line = controller::take_line(*controller_, Direction::reply, sizes, pending_);
    if (!line) break;
    if (!line->problem.empty()) replies.push_back(problem(line->problem));
    if (!line->body) continue;
    const bool is_tcp = controller_->protocol == Controller::Protocol::modbus_tcp;
    if (is_tcp && line->transaction != transaction_)
      replies.push_back(problem(say("a reply of transaction {}, and {} was asked", line->transaction, transaction_)));
    else
      take_body(*line->body, replies);
  }
  return replies;
}

ControllerReply ControllerHost::give_up() {
  const Name sent{quoted(sent_)};
  auto reply = problem(pending_.empty() ? say("no reply to {} within {:g} s", sent, timeout())
                                        : say("no reply to {} within {:g} s; received was {}, which is cut", sent,
                                              timeout(), Name{quoted(pending_)}));
  if (const ControllerExchange* const late = awaited(); late && !spoiled_) owe(*late);
  pending_.clear();
  command_ = nullptr;
  probe_ = nullptr;
  awaits_ = due_ = quiet_ = false;
  return reply;
}

}  // namespace tumble
