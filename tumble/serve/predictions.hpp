#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// Predictions of plans while they are written, made by processes of the program. The latest answers are kept, so that
/// the one of the saved plan is made once.
class Predictions {
 public:
  /// The text of a plan, and the file in which it is or will be.
  struct Question {
    std::string text, path;
  };
  struct Answer {
    bool ready = false;
    Problems problems;                                   ///< why there is no prediction
    std::shared_ptr<const Estimate> estimate = nullptr;  ///< null: not ready, or problems
  };

  /// Given: the file of the program, and of how many processes at once.
  Predictions(std::string program, unsigned runners);
  ~Predictions();
  Predictions(const Predictions&) = delete;
  Predictions& operator=(const Predictions&) = delete;

  /// Answers to the questions, as far as they are known. A prediction that nobody has asked for yet is begun, where
  /// users take turns; one that the same page of a user asked for before, and now does not ask for any more, is ended.
  /// Throws Error::unsupported where too many of this user wait.
  std::vector<Answer> ask(const std::string& user, const std::string& page, const std::vector<Question>& questions);

 private:
  struct Entry {
    Question question;
    std::string user, page;
    enum class State { waiting, running, done } state = State::waiting;
    int process = 0;  ///< 0: none yet
    bool unwanted = false;
    std::uint64_t used = 0;
    Answer answer = {};
  };

  void run();
  void carry_out(std::unique_lock<std::mutex>& lock, const std::string& key);
  void forget_others(const std::string& user, const std::string& page, const std::vector<std::string>& wanted);
  std::size_t waiting_of(const std::string& user) const;
  std::string next() const;
  void forget_old();

  std::string program_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::map<std::string, Entry> entries_;
  std::uint64_t now_ = 0;
  bool ended_ = false;
  std::vector<std::thread> runners_;
};

}  // namespace tumble
