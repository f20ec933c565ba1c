#include "tumble/serve/sign_in.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/formats/checksum.hpp"
#include "tumble/serve/passwords.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t most_sessions = 50;  ///< of a user

const User* find_user(const UsersFile::Users& users, const std::string& name) {
  const auto found = std::ranges::find(*users, name, &User::name);
  return found == users->end() ? nullptr : &*found;
}

}  // namespace

SignIn::SignIn(std::string file, std::function<double()> clock)
    : file_(file), clock_(std::move(clock)), decoy_(hash_of_password(random_secret())) {}

/// A name is forgotten long after its last pause has ended, and for no other reason: who tries many names unlocks none.
/// Their number is limited by the time that a check takes, one after the other. Names are kept as hashes of one length.
SignIn::Attempts& SignIn::attempts_of(const std::string& user) {
  const double now = clock_();
  if (now - forgotten_ > longest_pause) {
    std::erase_if(attempts_, [&](const auto& entry) { return now - entry.second.last > 8.0 * longest_pause; });
    forgotten_ = now;
  }
  return attempts_[sha256_of(user)];
}

PasswordCheck SignIn::check(const std::string& user, const std::string& password) {
  const std::lock_guard one(checking_);
  std::string hash = decoy_;
  bool known = false;
  const auto users = file_.now();
  {
    const std::lock_guard lock(mutex_);
    const auto attempts = attempts_.find(sha256_of(user));
    if (attempts != attempts_.end() && attempts->second.until > clock_())
      return {.state = PasswordCheck::State::paused, .pause = attempts->second.until - clock_()};
    if (const User* found = find_user(users, user)) hash = found->password, known = true;
  }
  const bool right = is_password(password, hash) && known;
  const std::lock_guard lock(mutex_);
  if (right) {
    const auto found = attempts_.find(sha256_of(user));
    const unsigned before = found == attempts_.end() ? 0 : found->second.wrong;
    if (found != attempts_.end()) attempts_.erase(found);
    return {.state = PasswordCheck::State::right, .before = before};
  }
  Attempts& attempts = attempts_of(user);
  attempts.last = clock_();
  ++attempts.wrong;
  if (attempts.wrong < free_attempts)
    return {.state = PasswordCheck::State::wrong, .remaining = free_attempts - attempts.wrong};
  const double pause = std::min(longest_pause, first_pause * std::exp2(attempts.wrong - free_attempts));
  attempts.until = attempts.last + pause;
  return {.state = PasswordCheck::State::wrong, .remaining = 0, .pause = pause};
}

/// Who signs in again and again loses sessions of his own.
void SignIn::forget_oldest_of(const std::string& user) {
  std::size_t open = 0;
  auto oldest = sessions_.end();
  for (auto one = sessions_.begin(); one != sessions_.end(); ++one) {
    if (one->second.user != user) continue;
    ++open;
    if (oldest == sessions_.end() || one->second.begun < oldest->second.begun) oldest = one;
  }
  if (open >= most_sessions) sessions_.erase(oldest);
}

std::string SignIn::begin(const std::string& user) {
  const auto users = file_.known();
  const User* found = find_user(users, user);
  const std::lock_guard lock(mutex_);
  if (!found) throw Error{Error::Kind::bad_input, "there is no such user any more"};
  const double now = clock_();
  std::erase_if(sessions_, [&](const auto& entry) { return now - entry.second.begun > longest_session; });
  forget_oldest_of(user);
  const std::string secret = random_secret();
  sessions_[sha256_of(secret)] = {user, found->password, now};
  return secret;
}

std::optional<Session> SignIn::session_of(const std::string& secret) {
  return secret.empty() ? std::nullopt : session_of(secret, file_.now());
}

std::optional<Session> SignIn::known_session_of(const std::string& secret) {
  return secret.empty() ? std::nullopt : session_of(secret, file_.known());
}

std::optional<Session> SignIn::session_of(const std::string& secret, const UsersFile::Users& users) {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(sha256_of(secret));
  if (found == sessions_.end()) return std::nullopt;
  const User* user = find_user(users, found->second.user);
  if (!user || user->password != found->second.password || clock_() - found->second.begun > longest_session) {
    sessions_.erase(found);
    return std::nullopt;
  }
  return Session{user->name, user->roles};
}

void SignIn::end(const std::string& secret) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(sha256_of(secret));
}

}  // namespace tumble
