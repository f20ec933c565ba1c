#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

/// Protocol data units of Modbus (MODBUS Application Protocol V1.1b3): functions 3, 6 and 16.
std::string modbus_request(const ControllerRegister& access, const Content& content, int axis);
std::optional<Content> parse_modbus_request(const ControllerRegister& access, int axes, std::string_view body);
std::string modbus_reply(const ControllerRegister& access, std::string_view sent, const Content& content, int axis);
std::optional<Content> parse_modbus_reply(const ControllerRegister& access, std::string_view sent,
                                          std::string_view body);

/// "exception 2: illegal data address", if the bytes are one.
std::optional<std::string> modbus_refusal(std::string_view body);
std::string modbus_exception(std::string_view sent, int code);

/// [byte] of a question that begins with these bytes, and of answers to an access.
std::vector<std::size_t> modbus_request_sizes(std::string_view begin);
std::vector<std::size_t> modbus_reply_sizes(const ControllerRegister& access);

}  // namespace tumble::controller
