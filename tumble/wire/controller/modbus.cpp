#include "tumble/wire/controller/modbus.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::controller {

namespace {

std::size_t registers_of(const ControllerRegister& access) {
  return static_cast<std::size_t>(access.number.number.bytes) / 2;
}

std::string word_of(int value) { return {static_cast<char>(value >> 8 & 0xff), static_cast<char>(value & 0xff)}; }

int word_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]) << 8 | static_cast<unsigned char>(bytes[at + 1]);
}

int code_of(std::string_view bytes) { return static_cast<unsigned char>(bytes[0]); }

int address_of(const ControllerRegister& access, int axis) { return access.address + access.step * (axis - 1); }

/// The order of the two words, either way.
std::string in_order(const ControllerRegister& access, std::string bytes) {
  return access.low_word_first && bytes.size() == 4 ? bytes.substr(2) + bytes.substr(0, 2) : bytes;
}

std::string data_of(const ControllerRegister& access, const Content& content) {
  if (access.constant) {
    ControllerPiece plain = access.number;
    plain.unit = Unit(), plain.factor = 1.0;
    return in_order(access, write_number(plain, *access.constant));
  }
  return in_order(access, fill({"", {access.number}}, content, {}));
}

std::optional<Content> parse_data(const ControllerRegister& access, std::string_view data, int axis) {
  Content content;
  content.axis = axis;
  const std::string bytes = in_order(access, std::string(data));
  if (access.constant) return data == data_of(access, {}) ? std::optional(content) : std::nullopt;
  std::string_view rest = bytes;
  const auto value = take_number(access.number, rest);
  if (!value) return std::nullopt;
  content.values[key_of(access.number)] = *value;
  return content;
}

}  // namespace

std::string modbus_request(const ControllerRegister& access, const Content& content, int axis) {
  const std::string head{static_cast<char>(access.function)};
  const std::string address = word_of(address_of(access, axis));
  const auto count = static_cast<int>(registers_of(access));
  if (access.function == 3) return head + address + word_of(count);
  const std::string data = data_of(access, content);
  if (access.function == 6) return head + address + data;
  return head + address + word_of(count) + static_cast<char>(data.size()) + data;
}

std::optional<Content> parse_modbus_request(const ControllerRegister& access, int axes, std::string_view body) {
  if (body.size() < 5 || code_of(body) != access.function) return std::nullopt;
  const int last = access.step == 0 ? 1 : axes;
  for (int axis = 1; axis <= last; ++axis) {
    if (word_at(body, 1) != address_of(access, axis)) continue;
    Content content;
    content.axis = axis;
    const auto count = static_cast<int>(registers_of(access));
    if (access.function == 3)
      return body.size() == 5 && word_at(body, 3) == count ? std::optional(content) : std::nullopt;
    if (access.function == 6) return body.size() == 5 ? parse_data(access, body.substr(3), axis) : std::nullopt;
    const bool sound = body.size() == 6 + 2 * registers_of(access) && word_at(body, 3) == count &&
                       static_cast<unsigned char>(body[5]) == 2 * count;
    return sound ? parse_data(access, body.substr(6), axis) : std::nullopt;
  }
  return std::nullopt;
}

std::string modbus_reply(const ControllerRegister& access, std::string_view sent, const Content& content, int) {
  if (access.function != 3) return std::string(sent.substr(0, 5));
  const std::string data = data_of(access, content);
  return std::string{'\x03', static_cast<char>(data.size())} + data;
}

std::optional<Content> parse_modbus_reply(const ControllerRegister& access, std::string_view sent,
                                          std::string_view body) {
  if (access.function != 3) return body == sent.substr(0, 5) ? std::optional(Content{}) : std::nullopt;
  const std::size_t size = 2 * registers_of(access);
  if (body.size() != 2 + size || code_of(body) != 3 || static_cast<unsigned char>(body[1]) != size) return std::nullopt;
  auto content = parse_data(access, body.substr(2), 1);
  if (content) content->axis.reset();
  return content;
}

std::optional<std::string> modbus_refusal(std::string_view body) {
  if (body.size() != 2 || (code_of(body) & 0x80) == 0) return std::nullopt;
  const int code = static_cast<unsigned char>(body[1]);
  const char* const names[] = {"",
                               "illegal function",
                               "illegal data address",
                               "illegal data value",
                               "failure of the device",
                               "acknowledged, not done yet",
                               "the device is busy"};
  return fmt::format("exception {}{}{}", code, code >= 1 && code <= 6 ? ": " : "",
                     code >= 1 && code <= 6 ? names[code] : "");
}

std::string modbus_exception(std::string_view sent, int code) {
  const int function = sent.empty() ? 0 : code_of(sent);
  return {static_cast<char>(function | 0x80), static_cast<char>(code)};
}

std::vector<std::size_t> modbus_request_sizes(std::string_view begin) {
  if (begin.empty()) return {5};
  const int function = code_of(begin);
  if (function == 3 || function == 6) return {5};
  if (function != 16) return {};
  if (begin.size() < 6) return {6};
  return {6 + static_cast<std::size_t>(static_cast<unsigned char>(begin[5]))};
}

std::vector<std::size_t> modbus_reply_sizes(const ControllerRegister& access) {
  return {2, access.function == 3 ? 2 + 2 * registers_of(access) : 5};
}

}  // namespace tumble::controller
