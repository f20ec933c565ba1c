#include "tumble/wire/controller/http.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

namespace {

namespace http = boost::beast::http;
using Pointer = nlohmann::json::json_pointer;

std::string body_of(const http::request<http::string_body>& message) {
  return std::string(message.method_string()) + " " + std::string(message.target());
}

std::string body_of(const http::response<http::string_body>& message) {
  return fmt::format("{} {}", message.result_int(), message.body());
}

/// Drops what is no message, up to where the next one may begin.
Line without_message(Direction direction, const Sentence& reason, std::string& pending) {
  const bool is_reply = direction == Direction::reply;
  const auto next = is_reply ? pending.find("HTTP/1.", 1) : pending.find("\r\n\r\n");
  const std::size_t size = next == std::string::npos ? pending.size() : is_reply ? next : next + 4;
  const std::string bytes = pending.substr(0, size);
  pending.erase(0, size);
  return {std::nullopt, say("'{}' is no message of HTTP ({})", shown(bytes), reason)};
}

template <bool is_request>
std::optional<Line> take_message(const Controller& controller, std::string& pending) {
  const Direction direction = is_request ? Direction::request : Direction::reply;
  http::parser<is_request, http::string_body> parser;
  parser.eager(true);
  parser.body_limit(controller.longest);
  boost::beast::error_code code;
  const std::size_t used =
      pending.find("\r\n\r\n") == std::string::npos ? 0 : parser.put(boost::asio::buffer(pending), code);
  if (code && code != http::error::need_more) return without_message(direction, system_reason(code), pending);
  if (parser.is_done()) {
    pending.erase(0, used);
    return Line{body_of(parser.get()), ""};
  }
  if (pending.size() <= controller.longest) return std::nullopt;
  return without_message(direction, "too long", pending);
}

/// A word of a line as JSON has it: a number, true, false, or a text.
nlohmann::json json_of_word(std::string_view word) {
  auto value = nlohmann::json::parse(word, nullptr, false);
  if (value.is_number() || value.is_boolean()) return value;
  return std::string(word);
}

std::string ascii_text(const nlohmann::json& json) { return json_text(json, -1, true); }

}  // namespace

std::string http_message(const Controller& controller, Direction direction, const std::string& body) {
  if (direction == Direction::reply) {
    const auto text = std::string_view(body).substr(std::min<std::size_t>(4, body.size()));
    const bool is_good = body.starts_with('2');
    return fmt::format("HTTP/1.1 {} {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{}",
                       body.substr(0, 3), is_good ? "OK" : "Error", text.size(), text);
  }
  std::string bytes = fmt::format("{} HTTP/1.1\r\nHost: {}\r\n", body, controller.http.host);
  for (const auto& header : controller.http.headers) bytes += header + "\r\n";
  return bytes + (body.starts_with("GET ") ? "\r\n" : "Content-Length: 0\r\n\r\n");
}

std::optional<Line> take_http(const Controller& controller, Direction direction, std::string& pending) {
  if (pending.empty()) return std::nullopt;
  return direction == Direction::request ? take_message<true>(controller, pending)
                                         : take_message<false>(controller, pending);
}

std::optional<std::string> line_of_json(const std::vector<std::string>& pointers, std::string_view text) {
  if (pointers.empty()) return stripped(text);
  const auto json = nlohmann::json::parse(text, nullptr, false);
  std::vector<std::string> words;
  for (const auto& pointer : pointers) {
    const Pointer place(pointer);
    if (!json.contains(place)) return std::nullopt;
    const auto& value = json.at(place);
    if (value.is_structured() || value.is_null()) return std::nullopt;
    words.push_back(value.is_string() ? value.get<std::string>() : ascii_text(value));
  }
  return fmt::format("{}", fmt::join(words, " "));
}

std::string json_of_line(const std::vector<std::string>& pointers, std::string_view line) {
  if (pointers.empty()) return std::string(line);
  nlohmann::json json;
  for (std::size_t i = 0; i < pointers.size(); ++i) {
    const auto end = i + 1 == pointers.size() ? line.size() : std::min(line.find(' '), line.size());
    json[Pointer(pointers[i])] = json_of_word(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return ascii_text(json);
}

bool is_json_pointer(const std::string& text) {
  try {
    return text.starts_with('/') && !Pointer(text).empty();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace tumble::controller
