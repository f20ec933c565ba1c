#include "tumble/serve/guard.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>

#include "tumble/formats/checksum.hpp"
#include "tumble/serve/passwords.hpp"

namespace tumble {
namespace {

std::string header(const HttpRequest& request, const std::string& name) {
  const auto found = request.headers.find(name);
  return found == request.headers.end() ? std::string() : found->second;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return text;
}

/// "127.0.0.1:8321" into host and port; brackets of IPv6 are removed.
std::pair<std::string, std::string> split_host(const std::string& text) {
  if (text.starts_with('[')) {
    const auto end = text.find(']');
    if (end == std::string::npos) return {};
    return {text.substr(1, end - 1), text.size() > end + 2 && text[end + 1] == ':' ? text.substr(end + 2) : ""};
  }
  const auto colon = text.find(':');
  return {text.substr(0, colon), colon == std::string::npos ? "" : text.substr(colon + 1)};
}

bool is_address(const std::string& host) {
  unsigned char room[16];
  return inet_pton(AF_INET, host.c_str(), room) == 1 || inet_pton(AF_INET6, host.c_str(), room) == 1;
}

bool is_loopback(const std::string& host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

}  // namespace

std::string LinkSessions::begin() {
  constexpr std::size_t most = 1000;
  const std::string secret = random_secret();
  const std::lock_guard lock(mutex_);
  if (hashes_.size() == most) hashes_.pop_front();
  hashes_.push_back(sha256_of(secret));
  return secret;
}

bool LinkSessions::knows(const std::string& secret) const {
  const auto hash = sha256_of(secret);
  const std::lock_guard lock(mutex_);
  return std::ranges::find(hashes_, hash) != hashes_.end();
}

void LinkSessions::end(const std::string& secret) {
  const auto hash = sha256_of(secret);
  const std::lock_guard lock(mutex_);
  std::erase(hashes_, hash);
}

/// An address cannot be bound to another computer, a name can: names are only our own.
bool Guard::names_this_server(const HttpRequest& request) const {
  const auto [raw_name, port_text] = split_host(header(request, "host"));
  const std::string name = lower(raw_name);
  if (name.empty()) return false;
  const std::string usual = tls ? "443" : "80";
  if ((port_text.empty() ? usual : port_text) != std::to_string(port)) return false;
  if (is_loopback(host)) return name == "localhost" || (is_address(name) && is_loopback(name));
  return name == "localhost" || is_address(name) || name == lower(host) || name == lower(computer) ||
         name == lower(computer) + ".local";
}

bool Guard::is_cross_site(const HttpRequest& request) const {
  const auto site = header(request, "sec-fetch-site");
  if (site == "cross-site" || site == "same-site") {
    // A link from elsewhere may open the page itself, which shows nothing without the token.
    return request.method != "GET" || header(request, "sec-fetch-mode") != "navigate" ||
           request.path.starts_with("/api/");
  }
  const auto origin = header(request, "origin");
  return !origin.empty() && lower(origin) != lower((tls ? "https://" : "http://") + header(request, "host"));
}

std::string Guard::cookie_name() const { return fmt::format("tumble_{}", port); }

/// The value of our cookie in a request; empty: it has none.
std::string Guard::secret_of(const HttpRequest& request) const {
  const auto authorization = header(request, "authorization");
  constexpr std::string_view bearer = "Bearer ";
  if (authorization.starts_with(bearer)) return authorization.substr(bearer.size());
  const std::string cookies = header(request, "cookie"), wanted = cookie_name() + "=";
  for (std::size_t begin = 0; begin < cookies.size();) {
    const auto end = std::min(cookies.find(';', begin), cookies.size());
    const std::string_view part(cookies.data() + begin, end - begin);
    if (part.starts_with(wanted)) return std::string(part.substr(wanted.size()));
    begin = cookies.find_first_not_of(" ;", end);
    if (begin == std::string::npos) break;
  }
  return "";
}

bool Guard::has_token(const HttpRequest& request) const {
  if (token.empty()) return true;
  const std::string shown = secret_of(request);
  return header(request, "authorization").empty() ? link->knows(shown) : equal_in_constant_time(shown, token);
}

std::optional<Session> Guard::session_of(const HttpRequest& request) const {
  if (users) return users->session_of(secret_of(request));
  if (!has_token(request)) return std::nullopt;
  return Session{"", {all_rights().begin(), all_rights().end()}};
}

std::optional<Session> Guard::known_session_of(const HttpRequest& request) const {
  return users ? users->known_session_of(secret_of(request)) : session_of(request);
}

bool Guard::is_token(const std::string& text) const { return equal_in_constant_time(text, token); }

/// Not the token: who reads the cookies of a browser cannot make the link from them.
std::string Guard::begin_by_link() const { return link->begin(); }

void Guard::end_session(const HttpRequest& request) const {
  const auto secret = secret_of(request);
  if (users) users->end(secret);
  link->end(secret);
}

std::string Guard::cookie(const std::string& secret) const {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", cookie_name(), secret, tls ? "; Secure" : "",
                     secret.empty() ? "; Max-Age=0" : "");
}

void add_safety(HttpResponse& response) {
  const auto has = [&](std::string_view name) {
    return std::ranges::any_of(response.headers, [&](const auto& entry) { return entry.first == name; });
  };
  if (!has("Content-Security-Policy"))
    response.headers.emplace_back(
        "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
        "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  if (!has("Cache-Control")) response.headers.emplace_back("Cache-Control", "no-store");
  response.headers.emplace_back("X-Content-Type-Options", "nosniff");
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  response.headers.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
  response.headers.emplace_back("Cross-Origin-Opener-Policy", "same-origin");
}

}  // namespace tumble
