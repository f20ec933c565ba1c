#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tumble/serve/http_server.hpp"
#include "tumble/serve/rights.hpp"
#include "tumble/serve/sign_in.hpp"

namespace tumble {

/// Who may ask a workbench what.
struct Guard {
  std::string token;  ///< empty: everybody who reaches the server, unless there are users
  std::string host;   ///< what the server listens at
  unsigned port = 0;
  bool tls = false;
  std::string computer;                ///< name of this computer in the network
  std::shared_ptr<SignIn> users = {};  ///< where set, only who has signed in, and there is no token

  /// Whether the head names this server: else a page of another site may have led a browser here (DNS rebinding).
  bool names_this_server(const HttpRequest& request) const;
  /// Whether a page of another site sent it.
  bool is_cross_site(const HttpRequest& request) const;
  /// Who sent it, by the cookie or "Authorization: Bearer" with the token or the secret of a session; none where it
  /// shows nothing that is valid. The token of the link has all roles.
  std::optional<Session> session_of(const HttpRequest& request) const;
  /// Whether this is the token; takes as long for any answer.
  bool is_token(const std::string& text) const;
  /// The header Set-Cookie of a browser that has shown the token.
  std::string cookie() const;
  /// That of a browser whose user has signed in; an empty secret removes it.
  std::string cookie(const std::string& secret) const;
  /// The secret of the session that a request shows; empty: none.
  std::string secret_of(const HttpRequest& request) const;

 private:
  bool has_token(const HttpRequest& request) const;
  std::string cookie_name() const;
  std::string cookie_value() const;
};

/// Headers of every answer: no page of another site may show or read it.
void add_safety(HttpResponse& response);

}  // namespace tumble
