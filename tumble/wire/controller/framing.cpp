#include "tumble/wire/controller/framing.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/text_parts.hpp"
#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/number.hpp"
#include "tumble/wire/controller/http.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

namespace {

unsigned char byte_of(char c) { return static_cast<unsigned char>(c); }

/// The checksum as it stands on the line, behind its mark.
std::string checksum_of(const ControllerChecksum& check, std::string_view bytes) {
  if (!check.sum) return "";
  using Form = ControllerChecksum::Form;
  const auto sum = codec::checksum_over(*check.sum, bytes);
  const int width = check.sum->width;
  if (check.form == Form::digits) return check.sum->before + fmt::format("{:0{}X}", sum, width / 4);
  std::string stated(static_cast<std::size_t>(width / 8), '\0');
  codec::put_word(check.form == Form::bit7 ? sum | 0x80u : sum, reinterpret_cast<unsigned char*>(stated.data()),
                  width / 8, false);
  return check.sum->before + stated;
}

std::size_t size_of_checksum(const ControllerChecksum& check) { return checksum_of(check, "").size(); }

/// The head as it is on the line: the address of the device for Modbus RTU.
std::string head_of(const Controller& controller, Direction direction) {
  if (controller.protocol == Controller::Protocol::modbus_rtu) return {static_cast<char>(controller.unit)};
  return direction == Direction::request ? controller.send.head : controller.reply.head;
}

/// What the checksum covers, and the checksum.
std::string summed(const ControllerChecksum& check, const std::string& head, std::string_view body) {
  return check.with_head ? head + std::string(body) : std::string(body);
}

/// The body without its checksum; absent with a problem where the checksum is wrong.
Line without_checksum(const ControllerChecksum& check, const std::string& head, std::string_view text) {
  if (!check.sum) return {std::string(text), ""};
  const std::size_t size = size_of_checksum(check);
  if (text.size() < size) return {std::nullopt, say("cut line '{}': its checksum is missing", shown(text))};
  const auto body = text.substr(0, text.size() - size), stated = text.substr(text.size() - size);
  const std::string expected = checksum_of(check, summed(check, head, body));
  if (stated == expected) return {std::string(body), ""};
  return {std::nullopt, say("wrong checksum in '{}': it ends with '{}', and its bytes give '{}'", shown(text),
                            shown(stated), shown(expected))};
}

void clear_bit7(Line& line) {
  if (!line.body) return;
  if (std::ranges::all_of(*line.body, [](char c) { return byte_of(c) >= 0x80; })) {
    for (char& c : *line.body) c = static_cast<char>(byte_of(c) & 0x7fu);
    return;
  }
  line = {std::nullopt, say("'{}' has a byte without bit 7", shown(*line.body))};
}

Sentence too_long(std::string& pending) {
  const Sentence text =
      say("{} bytes without an end of line, which begin '{}'", pending.size(), shown(pending.substr(0, 40)));
  pending.clear();
  return text;
}

/// A line that ends with a text.
std::optional<Line> take_ended(const Controller& controller, const ControllerFraming& framing, std::size_t skip,
                               std::string& pending) {
  std::size_t end = std::string::npos, size = 0;
  for (const auto& tail : framing.tail)
    if (const auto at = pending.find(tail, skip); at < end) end = at, size = tail.size();
  if (end == std::string::npos) {
    if (pending.size() <= controller.longest) return std::nullopt;
    return Line{std::nullopt, too_long(pending)};
  }
  std::string text = pending.substr(0, end);
  pending.erase(0, end + size);
  text.erase(0, std::min(skip, text.size()));
  std::string before;
  if (!framing.head.empty()) {
    const auto head = text.rfind(framing.head);
    if (head == std::string::npos) {
      if (stripped(text).empty()) return Line{"", ""};
      return Line{std::nullopt, say("'{}' does not begin with '{}'", shown(text), shown(framing.head))};
    }
    before = stripped(text.substr(0, head));
    text.erase(0, head + framing.head.size());
  }
  Line line = without_checksum(controller.checksum, framing.head, text);
  if (controller.bit7) clear_bit7(line);
  if (line.body && controller.trim) line.body = stripped(*line.body);
  if (!before.empty() && line.problem.empty())
    line.problem = say("'{}' stands before '{}'", shown(before), shown(framing.head));
  return line;
}

/// A line whose length follows from its content. Bytes before it are a problem.
std::optional<Line> take_sized(const Controller& controller, Direction direction, const Sizes& sizes,
                               std::string& pending) {
  const std::string head = head_of(controller, direction);
  const ControllerChecksum& check = controller.checksum;
  std::size_t at = 0;
  for (; at < pending.size(); ++at) {
    const auto rest = std::string_view(pending).substr(at);
    if (std::string_view(head).substr(0, rest.size()) != rest.substr(0, head.size())) continue;
    bool waits = rest.size() < head.size(), stands = false;
    for (const std::size_t size : waits ? std::vector<std::size_t>{} : sizes(rest.substr(head.size()))) {
      const std::size_t body = size + size_of_checksum(check);
      waits = waits || rest.size() < head.size() + body;
      if (rest.size() < head.size() + body) continue;
      const Line line = without_checksum(check, head, rest.substr(head.size(), body));
      if (!line.body) continue;
      stands = true;
      if (at > 0) break;
      pending.erase(0, head.size() + body);
      return line;
    }
    if (waits || stands) break;
  }
  if (at == 0) return std::nullopt;
  const std::string bytes = pending.substr(0, at);
  pending.erase(0, at);
  return Line{std::nullopt, say("{} bytes that belong to no {}, or whose checksum is wrong: '{}'", bytes.size(),
                                direction == Direction::reply ? "reply" : "command", shown(bytes))};
}

/// Modbus over TCP: transaction, protocol 0, length, address of the device.
std::optional<Line> take_modbus_tcp(const Controller& controller, std::string& pending) {
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint16_t>(byte_of(pending[at]) << 8 | byte_of(pending[at + 1]));
  };
  std::size_t dropped = 0;
  for (; pending.size() >= 7; pending.erase(0, 1), ++dropped) {
    const std::size_t length = word(4);
    if (word(2) != 0 || length < 3 || length > 254 || byte_of(pending[6]) != controller.unit) continue;
    if (dropped > 0) break;
    if (pending.size() < 6 + length) return std::nullopt;
    const Line line{pending.substr(7, length - 1), "", word(0)};
    pending.erase(0, 6 + length);
    return line;
  }
  if (dropped == 0) return std::nullopt;
  return Line{std::nullopt, say("{} bytes that are no Modbus from address {}", dropped, controller.unit)};
}

std::string with_bit7(std::string text) {
  for (char& c : text) c = static_cast<char>(byte_of(c) | 0x80u);
  return text;
}

}  // namespace

std::string stripped(std::string_view text) { return std::string(trimmed(text)); }

std::string wrap(const Controller& controller, Direction direction, const std::string& plain, bool bare,
                 std::uint16_t transaction) {
  if (bare) return plain;
  if (controller.protocol == Controller::Protocol::http) return http_message(controller, direction, plain);
  if (controller.protocol == Controller::Protocol::modbus_tcp) {
    const auto length = plain.size() + 1;
    const unsigned char head[] = {static_cast<unsigned char>(transaction >> 8),
                                  static_cast<unsigned char>(transaction),
                                  0,
                                  0,
                                  static_cast<unsigned char>(length >> 8),
                                  static_cast<unsigned char>(length),
                                  static_cast<unsigned char>(controller.unit)};
    return std::string(reinterpret_cast<const char*>(head), sizeof head) + plain;
  }
  const std::string body = controller.bit7 ? with_bit7(plain) : plain;
  const std::string head = head_of(controller, direction);
  const ControllerChecksum& check = controller.checksum;
  const auto& tails = direction == Direction::request ? controller.send.tail : controller.reply.tail;
  std::string bytes = head + body + checksum_of(check, summed(check, head, body));
  if (!tails.empty()) bytes += tails.front();
  return direction == Direction::reply ? std::string(static_cast<std::size_t>(controller.skip), ' ') + bytes : bytes;
}

std::optional<Line> take_line(const Controller& controller, Direction direction, const Sizes& sizes,
                              std::string& pending) {
  if (controller.protocol == Controller::Protocol::modbus_tcp) return take_modbus_tcp(controller, pending);
  if (controller.protocol == Controller::Protocol::http) return take_http(controller, direction, pending);
  const auto& framing = direction == Direction::request ? controller.send : controller.reply;
  if (controller.protocol == Controller::Protocol::modbus_rtu || framing.tail.empty())
    return take_sized(controller, direction, sizes, pending);
  const int skip = direction == Direction::reply ? controller.skip : 0;
  return take_ended(controller, framing, static_cast<std::size_t>(skip), pending);
}

}  // namespace tumble::controller
