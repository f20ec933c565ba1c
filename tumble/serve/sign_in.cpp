#include "tumble/serve/sign_in.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/formats/checksum.hpp"
#include "tumble/serve/passwords.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t most_names = 1000, most_sessions = 1000;

}  // namespace

SignIn::SignIn(std::string file, std::function<double()> clock)
    : file_(std::move(file)), clock_(std::move(clock)), decoy_(hash_of_password(random_secret())) {
  std::error_code failed;  // read_users() says what is wrong with the file
  changed_ = std::filesystem::last_write_time(file_, failed);
  users_ = read_users(file_);
  if (users_.empty())
    throw Error{Error::Kind::bad_input,
                file_ + " has no users: tumble serve --users " + file_ + " --add-user NAME --role approve"};
}

/// A file that cannot be read lets nobody in: it is safer than the users of before.
void SignIn::refresh() {
  std::error_code failed;
  const auto changed = std::filesystem::last_write_time(file_, failed);
  if (!failed && changed == changed_) return;
  changed_ = failed ? std::filesystem::file_time_type::min() : changed;
  users_.clear();
  if (!failed) try {
      users_ = read_users(file_);
    } catch (const Error&) {
      changed_ = std::filesystem::file_time_type::min();
    }
}

const User* SignIn::find(const std::string& user) const {
  const auto found = std::ranges::find(users_, user, &User::name);
  return found == users_.end() ? nullptr : &*found;
}

/// Room for a new name is that of the one whose last attempt is the oldest.
SignIn::Attempts& SignIn::attempts_of(const std::string& user) {
  if (!attempts_.contains(user) && attempts_.size() >= most_names)
    attempts_.erase(std::ranges::min_element(attempts_, {}, [](const auto& entry) { return entry.second.last; }));
  return attempts_[user];
}

PasswordCheck SignIn::check(const std::string& user, const std::string& password) {
  const std::unique_lock one(checking_, std::try_to_lock);
  if (!one) return {.state = PasswordCheck::State::busy};
  std::string hash = decoy_;
  bool known = false;
  {
    const std::lock_guard lock(mutex_);
    refresh();
    const auto attempts = attempts_.find(user);
    if (attempts != attempts_.end() && attempts->second.until > clock_())
      return {.state = PasswordCheck::State::paused, .pause = attempts->second.until - clock_()};
    if (const User* found = find(user)) hash = found->password, known = true;
  }
  const bool right = is_password(password, hash) && known;
  const std::lock_guard lock(mutex_);
  if (right) {
    const auto found = attempts_.find(user);
    const unsigned before = found == attempts_.end() ? 0 : found->second.wrong;
    attempts_.erase(user);
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

std::string SignIn::begin(const std::string& user) {
  const std::lock_guard lock(mutex_);
  const User* found = find(user);
  if (!found) throw Error{Error::Kind::bad_input, "there is no such user any more"};
  const double now = clock_();
  std::erase_if(sessions_, [&](const auto& entry) { return now - entry.second.begun > longest_session; });
  if (sessions_.size() >= most_sessions)
    sessions_.erase(std::ranges::min_element(sessions_, {}, [](const auto& entry) { return entry.second.begun; }));
  const std::string secret = random_secret();
  sessions_[sha256_of(secret)] = {user, found->password, now};
  return secret;
}

std::optional<Session> SignIn::session_of(const std::string& secret) {
  if (secret.empty()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(sha256_of(secret));
  if (found == sessions_.end()) return std::nullopt;
  refresh();
  const User* user = find(found->second.user);
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
