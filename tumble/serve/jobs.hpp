#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tumble/serve/event_feed.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// Long work, done by processes of the program itself, one step after the other.
struct Job {
  enum class State { waiting, running, done, failed, cancelled };
  /// One call of the program: its arguments, without its own name.
  using Step = std::vector<std::string>;

  std::string id;    ///< given by Jobs
  std::string kind;  ///< "identify", "noise", "convert", "compensate", "prepare", "rehearse", "optimise"
  std::string title;
  std::vector<Step> steps;  ///< {folder} is replaced by the folder of the job
  State state = State::waiting;
  double progress = 0.0;           ///< [1] 0 to 1 of all steps
  std::string doing;               ///< what is being done
  Problems problems;               ///< what the program said where it failed
  double begun = 0.0;              ///< [s] since 1970-01-01, when it was asked for
  bool kept = true;                ///< false: has no folder, and is forgotten with the server
  std::string owner;               ///< user who asked for it; empty: who has the link
  std::uint64_t folder = 0;        ///< number of its folder, by which a folder of somebody else is known
  std::vector<std::string> files;  ///< names of results in its folder
  std::string scratch;             ///< name of a file in its folder that only the steps need; empty: none
};

std::string name(Job::State state);

/// How jobs are carried out.
struct JobOptions {
  std::string program;  ///< file of the program
  std::string root;     ///< the folder of the workbench: results of a job are in jobs/ID of it
  std::string state;    ///< of what must be known of jobs, outside of the root; empty: it is forgotten with the server
  unsigned runners = 2;
  std::function<double()> clock;  ///< [s] since 1970-01-01
};

/// The jobs of a workbench. A job that a stop of the server interrupted waits again with the next one. What is carried
/// out is known from the folder of the state alone: a folder of recordings may come from anybody, and nothing in it is
/// run.
class Jobs {
 public:
  /// `feed` gets an event "job" at each change. Throws Error::bad_file.
  Jobs(JobOptions options, EventFeed& feed);
  /// Ends what is running; it stays marked as running on the disk.
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// Puts a job in the queue; its identifier. Users take turns. Throws Error::bad_input where its owner has too many
  /// that wait, std::filesystem::filesystem_error where its folder cannot be made.
  std::string start(Job job);
  /// False: there is no such job, or it has ended.
  bool cancel(const std::string& id);
  std::vector<Job> all() const;
  /// The job of that identifier; one with an empty identifier if no job has it.
  Job find(const std::string& id) const;
  /// Replaces its argument by the bytes of a file of a job that come next; false: there are no more. Empty where the
  /// job has no file of that name.
  std::function<bool(std::string& bytes)> reader_of(const std::string& id, const std::string& file) const;

  static constexpr std::size_t most_waiting = 100;  ///< jobs of a user
  static constexpr std::size_t most_unkept = 300;   ///< that have no folder, of a user

 private:
  void restore();
  void forget_unkept();
  void run_jobs();
  Job* next_waiting();
  void carry_out(std::unique_lock<std::mutex>& lock, const std::string& id);
  void settle(Job& job);
  void require_room(const Job& job) const;
  void make_folder(Job& job);
  bool has_its_folder(const Job& job) const;
  void changed(const Job& job);
  std::string folder_of(const Job& job) const;
  std::string state_of(const Job& job) const;

  JobOptions options_;
  EventFeed& feed_;
  mutable std::mutex mutex_;
  std::condition_variable work_;
  std::map<std::string, Job> jobs_;
  std::map<std::string, int> processes_;  ///< of running jobs; 0: between two steps
  std::uint64_t next_ = 1;
  bool ended_ = false;
  std::vector<std::thread> runners_;
};

/// A job as one line of JSON.
std::string to_json(const Job& job);

}  // namespace tumble
