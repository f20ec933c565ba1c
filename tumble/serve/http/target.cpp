#include "tumble/serve/http/target.hpp"

#include <cctype>
#include <optional>
#include <string>

namespace tumble::http {
namespace {

/// "%20" and, in a query, "+" decoded; nothing where it is not well formed or holds a zero byte.
std::optional<std::string> decoded(std::string_view text, bool plus) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      const auto digit = [&](std::size_t at) {
        return at < text.size() && std::isxdigit(static_cast<unsigned char>(text[at])) != 0;
      };
      if (!digit(i + 1) || !digit(i + 2)) return std::nullopt;
      out += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    } else {
      out += plus && text[i] == '+' ? ' ' : text[i];
    }
    if (out.back() == '\0') return std::nullopt;
  }
  return out;
}

}  // namespace

bool take_target(std::string_view target, HttpRequest& request) {
  if (!target.starts_with('/')) return false;
  const auto mark = target.find('?');
  const auto path = decoded(target.substr(0, mark), false);
  if (!path) return false;
  request.path = *path;
  if (mark == std::string_view::npos) return true;
  for (std::string_view rest = target.substr(mark + 1); !rest.empty();) {
    const auto end = rest.find('&');
    const auto part = rest.substr(0, end);
    const auto equals = part.find('=');
    const auto key = decoded(part.substr(0, equals), true);
    const auto value = decoded(equals == std::string_view::npos ? std::string_view() : part.substr(equals + 1), true);
    if (!key || !value) return false;
    request.query.emplace_back(*key, *value);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return true;
}

}  // namespace tumble::http
