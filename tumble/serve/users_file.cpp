#include "tumble/serve/users_file.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <thread>

#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct UsersFile::State {
  std::string file;
  fs::file_time_type changed;  ///< of the reading thread alone
  mutable std::mutex mutex;
  std::condition_variable news;
  Users users;
  std::uint64_t asked = 0, answered = 0;  ///< looks at the file
  bool late = false;                      ///< the disk has not answered: nobody waits for it
  bool ended = false, gone = false;       ///< the thread shall end; it has

  void look();
  void look_again_and_again();
};

void UsersFile::State::look() {
  std::error_code failed;
  const auto now = fs::last_write_time(file, failed);
  if (!failed && now == changed) return;
  changed = failed ? fs::file_time_type::min() : now;
  auto read = std::make_shared<const std::vector<User>>();
  if (!failed) try {
      read = std::make_shared<const std::vector<User>>(read_users(file));
    } catch (const std::exception&) {
      changed = fs::file_time_type::min();
    }
  const std::lock_guard lock(mutex);
  users = read;
}

void UsersFile::State::look_again_and_again() {
  std::unique_lock lock(mutex);
  for (;;) {
    news.wait_for(lock, 1s, [this] { return ended || asked > answered; });
    if (ended) break;
    const auto ticket = asked;
    lock.unlock();
    look();
    lock.lock();
    answered = ticket;
    late = false;
    news.notify_all();
  }
  gone = true;
  news.notify_all();
}

UsersFile::UsersFile(const std::string& file) : state_(std::make_shared<State>()) {
  state_->file = file;
  std::error_code failed;  // read_users() says what is wrong with the file
  state_->changed = fs::last_write_time(file, failed);
  state_->users = std::make_shared<const std::vector<User>>(read_users(file));
  if (state_->users->empty())
    throw Error{Error::Kind::bad_input,
                say("{} has no users: tumble serve --users {} --add-user NAME --role approve", Name{file}, Name{file})};
  std::thread([state = state_] { state->look_again_and_again(); }).detach();
}

/// A thread that waits for its disk is left to it.
UsersFile::~UsersFile() {
  std::unique_lock lock(state_->mutex);
  state_->ended = true;
  state_->news.notify_all();
  state_->news.wait_for(lock, 2s, [this] { return state_->gone; });
}

UsersFile::Users UsersFile::now() {
  std::unique_lock lock(state_->mutex);
  if (!state_->late) {
    const auto ticket = ++state_->asked;
    state_->news.notify_all();
    state_->late = !state_->news.wait_for(lock, 2s, [&] { return state_->late || state_->answered >= ticket; }) ||
                   state_->answered < ticket;
  }
  return state_->users;
}

UsersFile::Users UsersFile::known() const {
  const std::lock_guard lock(state_->mutex);
  return state_->users;
}

}  // namespace tumble
