#include "tumble/serve/predictions.hpp"

#include <algorithm>
#include <filesystem>

#include "tumble/formats/checksum.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/jobs/process.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t most_waiting = 20, most_waiting_of_link = 100, most_kept = 64;

std::string key_of(const Predictions::Question& question) { return sha256_of(question.path + '\n' + question.text); }

Predictions::Answer answer_of(const jobs::Outcome& outcome, const std::string& output) {
  if (outcome.status != 0) {
    if (!outcome.problems.empty()) return {true, coded_problems_from_json(outcome.problems).problems, nullptr};
    return {true,
            {Problem("the prediction takes too long while you write: save the plan and use `tumble predict`")},
            nullptr};
  }
  try {
    return {true, {}, std::make_shared<const Estimate>(estimate_from_json(output, "prediction"))};
  } catch (const Error& error) {
    return {true, error.problems, nullptr};
  }
}

}  // namespace

Predictions::Predictions(std::string program, unsigned runners) : program_(std::move(program)) {
  for (unsigned i = 0; i < runners; ++i) runners_.emplace_back([this] { run(); });
}

Predictions::~Predictions() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (const auto& [key, entry] : entries_) jobs::end_process(entry.process);
  }
  work_.notify_all();
  for (auto& runner : runners_) runner.join();
}

std::size_t Predictions::waiting_of(const std::string& user) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      entries_, [&](const auto& one) { return one.second.user == user && one.second.state != Entry::State::done; }));
}

std::vector<Predictions::Answer> Predictions::ask(const std::string& user, const std::string& page,
                                                  const std::vector<Question>& questions) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> wanted;
  for (const auto& question : questions) wanted.push_back(key_of(question));
  forget_others(user, page, wanted);
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < questions.size(); ++i) {
    auto found = entries_.find(wanted[i]);
    if (found == entries_.end()) {
      if (waiting_of(user) >= (user.empty() ? most_waiting_of_link : most_waiting))
        throw Error(Error::Kind::unsupported, "too many predictions are waiting; try again");
      found = entries_.emplace(wanted[i], Entry{.question = questions[i], .user = user, .page = page}).first;
      work_.notify_one();
    }
    found->second.used = ++now_;
    answers.push_back(found->second.answer);
  }
  forget_old();
  return answers;
}

/// Ends what only this page asked for and does not want any more.
void Predictions::forget_others(const std::string& user, const std::string& page,
                                const std::vector<std::string>& wanted) {
  for (auto& [key, entry] : entries_) {
    const bool is_wanted = std::ranges::find(wanted, key) != wanted.end();
    if (entry.state == Entry::State::done) continue;
    if (is_wanted && entry.user == user) entry.page = page;
    if (is_wanted || entry.user != user || entry.page != page) continue;
    entry.unwanted = true;
    jobs::end_process(entry.process);
  }
  std::erase_if(entries_,
                [](const auto& one) { return one.second.unwanted && one.second.state == Entry::State::waiting; });
}

void Predictions::forget_old() {
  std::vector<std::pair<std::uint64_t, std::string>> done;
  for (const auto& [key, entry] : entries_)
    if (entry.state == Entry::State::done) done.emplace_back(entry.used, key);
  std::ranges::sort(done);
  for (std::size_t i = 0; i + most_kept < done.size(); ++i) entries_.erase(done[i].second);
}

/// The key of one that waits, of the user who has the fewest running; empty: none waits.
std::string Predictions::next() const {
  std::map<std::string, int> running;
  for (const auto& [key, entry] : entries_)
    if (entry.state == Entry::State::running) ++running[entry.user];
  const std::pair<const std::string, Entry>* chosen = nullptr;
  for (const auto& one : entries_)
    if (one.second.state == Entry::State::waiting &&
        (!chosen || running[one.second.user] < running[chosen->second.user]))
      chosen = &one;
  return chosen ? chosen->first : "";
}

void Predictions::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    std::string next_key;
    work_.wait(lock, [&] { return ended_ || !(next_key = next()).empty(); });
    if (ended_) return;
    carry_out(lock, next_key);
  }
}

/// The lock is held except while the process runs; a running entry is never erased by others.
void Predictions::carry_out(std::unique_lock<std::mutex>& lock, const std::string& key) {
  entries_[key].state = Entry::State::running;
  const Question question = entries_[key].question;
  lock.unlock();
  std::string output;
  const auto outcome =
      jobs::run_process(program_, {"serve", "--predict", question.path}, question.text, output, [&](int process) {
        const std::lock_guard inside(mutex_);
        auto& entry = entries_[key];
        entry.process = process;
        if (process > 0 && (ended_ || entry.unwanted)) jobs::end_process(process);
      });
  auto answer = answer_of(outcome, output);
  lock.lock();
  auto& entry = entries_[key];
  if (entry.unwanted) {
    entries_.erase(key);  // who asks again meanwhile begins again
    return;
  }
  entry.answer = std::move(answer);
  entry.state = Entry::State::done;
}

}  // namespace tumble
