#pragma once

#include <optional>
#include <string>

#include "tumble/serve/http_server.hpp"

namespace tumble {

/// Who may ask a workbench what.
struct Guard {
  std::string token;  ///< empty: everybody who reaches the server
  std::string host;   ///< what the server listens at
  unsigned port = 0;
  bool tls = false;
  std::string computer;  ///< name of this computer in the network

  /// Whether the head names this server: else a page of another site may have led a browser here (DNS rebinding).
  bool names_this_server(const HttpRequest& request) const;
  /// Whether a page of another site sent it.
  bool is_cross_site(const HttpRequest& request) const;
  /// Whether it has the token, in the cookie or as "Authorization: Bearer".
  bool has_token(const HttpRequest& request) const;
  /// Whether this is the token; takes as long for any answer.
  bool is_token(const std::string& text) const;
  /// The header Set-Cookie of a browser that has shown the token.
  std::string cookie() const;

 private:
  std::string cookie_name() const;
  std::string cookie_value() const;
};

/// Headers of every answer: no page of another site may show or read it.
void add_safety(HttpResponse& response);

}  // namespace tumble
