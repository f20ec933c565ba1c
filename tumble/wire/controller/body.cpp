#include "tumble/wire/controller/body.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/http.hpp"
#include "tumble/wire/controller/modbus.hpp"

namespace tumble::controller {

namespace {

/// Why a text that matched says no: the text, and what its first word means.
std::string explained(const ControllerTemplate& form, const Content& content, std::string_view body,
                      const std::map<std::string, std::string>& meaning) {
  const std::string text = shown(body);
  for (const auto& piece : form.pieces)
    if (const auto word = content.words.find(piece.text); word != content.words.end())
      if (const auto found = meaning.find(word->second); found != meaning.end())
        return fmt::format("{}: {}", text, found->second);
  return text;
}

/// Printable and without what ends a line; empty texts are no words.
std::string one_line(std::string text) {
  for (char& c : text)
    if (c < 0x20 || c > 0x7e) c = ' ';
  text = stripped(text);
  return text.empty() ? "refused" : text;
}

std::string filled_refusal(const Controller& controller, const ControllerTemplate& form, const std::string& text) {
  Content content;
  for (const auto& piece : form.pieces)
    if (piece.kind == ControllerPiece::Kind::word && !piece.otherwise) content.words[piece.text] = one_line(text);
  return fill(form, content, controller.axes);
}

/// The line of a reply of HTTP that says yes; absent: it has other content.
std::optional<std::string> line_of_reply(const ControllerExchange& exchange, std::string_view body) {
  return body.size() < 4 || body[0] != '2' ? std::nullopt : line_of_json(exchange.json, body.substr(4));
}

/// "HTTP 500: no test is loaded"
std::optional<std::string> refusal_of_http(const Controller& controller, std::string_view body) {
  if (body.size() < 4 || body[0] == '1' || body[0] == '2') return std::nullopt;
  const bool has_place = !controller.http.message.empty();
  const auto text = has_place ? line_of_json({controller.http.message}, body.substr(4)) : std::nullopt;
  return fmt::format("HTTP {}: {}", body.substr(0, 3), shown(text.value_or(std::string(body.substr(4)))));
}

}  // namespace

bool has_reply(const ControllerExchange& exchange) {
  return exchange.modbus || !exchange.expect.empty() || !exchange.refused.empty();
}

bool answers_itself(const ControllerExchange& exchange) {
  if (exchange.modbus) return exchange.modbus->function != 3;
  if (exchange.expect.empty()) return exchange.refused.empty();
  return std::ranges::all_of(exchange.expect.front().pieces, [](const ControllerPiece& piece) {
    using Kind = ControllerPiece::Kind;
    return piece.kind == Kind::literal || piece.kind == Kind::any || piece.kind == Kind::axis || piece.otherwise;
  });
}

std::string request_body(const Controller& controller, const ControllerExchange& exchange, const Content& content) {
  if (exchange.modbus) return modbus_request(*exchange.modbus, content, content.axis.value_or(1));
  return fill(exchange.send, content, controller.axes);
}

std::optional<Content> parse_request(const Controller& controller, const ControllerExchange& exchange,
                                     std::string_view body) {
  if (exchange.modbus) return parse_modbus_request(*exchange.modbus, static_cast<int>(controller.axes.size()), body);
  return match(exchange.send, body, controller.axes);
}

std::string reply_body(const Controller& controller, const ControllerExchange& exchange, const std::string& sent,
                       const Content& content) {
  if (exchange.modbus) return modbus_reply(*exchange.modbus, sent, content, content.axis.value_or(1));
  const std::string line = exchange.expect.empty() ? "" : fill(exchange.expect.front(), content, controller.axes);
  return controller.protocol == Controller::Protocol::http ? "200 " + json_of_line(exchange.json, line) : line;
}

std::optional<Content> parse_reply(const Controller& controller, const ControllerExchange& exchange,
                                   std::string_view sent, std::string_view body) {
  if (exchange.modbus) return parse_modbus_reply(*exchange.modbus, sent, body);
  const bool is_http = controller.protocol == Controller::Protocol::http;
  const auto line = is_http ? line_of_reply(exchange, body) : std::optional<std::string>(body);
  if (!line) return std::nullopt;
  for (const auto& form : exchange.expect)
    if (auto content = match(form, *line, controller.axes)) return content;
  return std::nullopt;
}

std::optional<std::string> refusal(const Controller& controller, const ControllerExchange* exchange,
                                   std::string_view body) {
  if (controller.is_modbus()) {
    const bool mine = exchange && exchange->modbus && !body.empty() &&
                      static_cast<unsigned char>(body[0]) == (exchange->modbus->function | 0x80);
    return mine ? modbus_refusal(body) : std::nullopt;
  }
  std::string line(body);
  if (controller.protocol == Controller::Protocol::http) {
    if (auto text = refusal_of_http(controller, body)) return text;
    line = exchange ? line_of_reply(*exchange, body).value_or("") : "";
  }
  for (const auto& error : controller.errors)
    if (const auto content = match(error.expect, line, controller.axes))
      return explained(error.expect, *content, line, error.meaning);
  if (!exchange || parse_reply(controller, *exchange, "", body)) return std::nullopt;
  for (const auto& form : exchange->refused)
    if (const auto content = match(form, line, controller.axes)) return explained(form, *content, line, {});
  return std::nullopt;
}

std::optional<std::string> refusal_body(const Controller& controller, const ControllerExchange* exchange,
                                        std::string_view sent, const std::string& text) {
  if (controller.protocol == Controller::Protocol::http) {
    const bool has_place = !controller.http.message.empty();
    const std::vector<std::string> places(has_place ? 1 : 0, controller.http.message);
    return (exchange ? "500 " : "404 ") + json_of_line(places, one_line(text));
  }
  if (controller.is_modbus())
    return modbus_exception(sent, exchange                                                          ? 4
                                  : sent.empty() || (sent[0] != 3 && sent[0] != 6 && sent[0] != 16) ? 1
                                                                                                    : 2);
  if (exchange && !exchange->refused.empty()) return filled_refusal(controller, exchange->refused.front(), text);
  if (controller.errors.empty()) return std::nullopt;
  return filled_refusal(controller, controller.errors.front().expect, text);
}

Sizes request_sizes(const Controller& controller) {
  if (controller.is_modbus()) return modbus_request_sizes;
  std::vector<std::size_t> sizes;
  for (const auto& command : controller.commands)
    for (const auto& exchange : command.exchanges)
      if (const auto size = size_of(exchange.send)) sizes.push_back(*size);
  std::ranges::sort(sizes);
  sizes.erase(std::ranges::unique(sizes).begin(), sizes.end());
  return [sizes](std::string_view) { return sizes; };
}

Sizes reply_sizes(const Controller& controller, const ControllerExchange* exchange) {
  std::vector<std::size_t> sizes;
  if (exchange && exchange->modbus) sizes = modbus_reply_sizes(*exchange->modbus);
  const auto add = [&](const ControllerTemplate& form) {
    if (const auto size = size_of(form)) sizes.push_back(*size);
  };
  if (exchange) std::ranges::for_each(exchange->expect, add), std::ranges::for_each(exchange->refused, add);
  for (const auto& error : controller.errors) add(error.expect);
  for (const auto& notice : controller.notices) add(notice.expect);
  std::ranges::sort(sizes);
  return [sizes](std::string_view) { return sizes; };
}

std::optional<ControllerReply> notice_of(const Controller& controller, std::string_view body) {
  for (const auto& notice : controller.notices) {
    const auto content = match(notice.expect, body, controller.axes);
    if (!content) continue;
    ControllerReply reply{ControllerVerb::notice};
    reply.text = say("{}", Name{explained(notice.expect, *content, body, notice.meaning)});
    if (!notice.state.empty()) reply.words["state"] = notice.state;
    return reply;
  }
  return std::nullopt;
}

}  // namespace tumble::controller
