#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "tumble/serve/http_server.hpp"
#include "tumble/serve/rights.hpp"
#include "tumble/serve/sign_in.hpp"

namespace tumble {

/// Browsers that have shown the token of the link, each with a secret of its own. From any thread.
class LinkSessions {
 public:
  std::string begin();
  bool knows(const std::string& secret) const;
  void end(const std::string& secret);

 private:
  mutable std::mutex mutex_;
  std::deque<std::string> hashes_;  ///< SHA-256 of secrets, the oldest first
};

/// Who may ask a workbench what.
struct Guard {
  std::string token;  ///< empty: everybody who reaches the server, unless there are users
  std::string host;   ///< what the server listens at
  unsigned port = 0;
  bool tls = false;
  std::string computer;                ///< name of this computer in the network
  std::shared_ptr<SignIn> users = {};  ///< where set, only who has signed in, and there is no token
  /// Sessions of browsers that have shown the token.
  std::shared_ptr<LinkSessions> link = std::make_shared<LinkSessions>();

  /// Whether the head names this server: else a page of another site may have led a browser here (DNS rebinding).
  bool names_this_server(const HttpRequest& request) const;
  /// Whether a page of another site sent it.
  bool is_cross_site(const HttpRequest& request) const;
  /// Who sent it, by the cookie or "Authorization: Bearer" with the token or the secret of a session; none where it
  /// shows nothing that is valid. The token of the link has all roles.
  std::optional<Session> session_of(const HttpRequest& request) const;
  /// session_of() with the users as they are known: it waits for no disk, and hears of a change a second later.
  std::optional<Session> known_session_of(const HttpRequest& request) const;
  /// Whether this is the token; takes as long for any answer.
  bool is_token(const std::string& text) const;
  /// Begins a session of a browser that has shown the token: the secret of its cookie.
  std::string begin_by_link() const;
  /// Ends the session that a request shows, of a user or of the link.
  void end_session(const HttpRequest& request) const;
  /// The header Set-Cookie of a browser whose session has this secret; an empty one removes it.
  std::string cookie(const std::string& secret) const;
  /// The secret of the session that a request shows; empty: none.
  std::string secret_of(const HttpRequest& request) const;

 private:
  bool has_token(const HttpRequest& request) const;
  std::string cookie_name() const;
};

/// Headers of every answer: no page of another site may show or read it.
void add_safety(HttpResponse& response);

}  // namespace tumble
