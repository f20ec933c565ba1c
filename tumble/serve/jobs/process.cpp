#include "tumble/serve/jobs/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <system_error>
#include <utility>

#include "tumble/formats/confinement.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/units/error.hpp"

namespace tumble::jobs {
namespace {

constexpr std::size_t most_messages = 1 << 16;
constexpr int progress_descriptor = 3;

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) == 0) read = ends[0], write = ends[1];
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close_end(read);
    close_end(write);
  }
  static void close_end(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }
};

/// What a program reads and where it writes; -1: nothing.
struct Files {
  int input = -1, output = -1;
};

/// What a process that becomes the program has open.
struct Descriptors {
  int input, output, messages, progress;
};

/// Signals were blocked before the fork: they act as they do on any program again.
[[noreturn]] void run_in_place(const char* program, char* const* arguments, char* const* environment,
                               Descriptors given) {
  for (const int end : {SIGINT, SIGTERM, SIGHUP}) signal(end, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = open("/dev/null", O_RDWR);
  // All of them first to numbers above those that they get: none is overwritten before it is used.
  const auto above = [&](int descriptor) { return fcntl(descriptor < 0 ? nothing : descriptor, F_DUPFD, 10); };
  const Descriptors kept{above(given.input), above(given.output), above(given.messages), above(given.progress)};
  dup2(kept.input, STDIN_FILENO);
  dup2(kept.output, STDOUT_FILENO);
  dup2(kept.messages, STDERR_FILENO);
  dup2(kept.progress, progress_descriptor);
  close_range(progress_descriptor + 1, ~0u, 0);
  execve(program, arguments, environment);
  _exit(127);
}

/// Between fork and exec: only what a signal handler may do. The process ends with the server. Signals were blocked
/// before the fork: a handler of the server that ran in here would write to what both share, and end the server.
[[noreturn]] void become(const char* program, char* const* arguments, char* const* environment, Descriptors given,
                         pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  run_in_place(program, arguments, environment, given);
}

/// That of this process, but the program speaks English: its messages are kept, and said to each reader in the language
/// of the page. It opens what documents name where this process does.
std::vector<std::string> environment_in_english() {
  const std::string confined = std::string(confinement_variable) + "=";
  std::vector<std::string> all{"LC_ALL=C.UTF-8", confined + confined_to().string()};
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view one(*entry);
    if (!one.starts_with("TUMBLE_PROGRESS=") && !one.starts_with("TUMBLE_PROBLEMS=") && !one.starts_with("LC_ALL=") &&
        !one.starts_with(confined))
      all.emplace_back(one);
  }
  return all;
}

/// The same with the place for progress.
std::vector<std::string> environment_of_job() {
  auto all = environment_in_english();
  all.push_back("TUMBLE_PROGRESS=" + std::to_string(progress_descriptor));
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

/// The last whole line of "0.25 what": earlier ones are history.
void take_progress(std::string& waiting, const std::function<void(double, const std::string&)>& progress) {
  const auto end = waiting.rfind('\n');
  if (end == std::string::npos) return;
  const auto before = end == 0 ? std::string::npos : waiting.rfind('\n', end - 1);
  const std::string line = waiting.substr(before == std::string::npos ? 0 : before + 1,
                                          end - (before == std::string::npos ? 0 : before + 1));
  waiting.erase(0, end + 1);
  double done = 0.0;
  const auto [rest, fault] = std::from_chars(line.data(), line.data() + line.size(), done);
  if (fault == std::errc{} && done >= 0.0 && done <= 1.0)
    progress(done, std::string(*rest == ' ' ? rest + 1 : rest, line.data() + line.size()));
}

/// Until the process has closed both.
void listen_to(int messages, int progress, Outcome& outcome,
               const std::function<void(double, const std::string&)>& say) {
  pollfd ends[2] = {{messages, POLLIN, 0}, {progress, POLLIN, 0}};
  std::string waiting;
  char bytes[4096];
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (poll(ends, 2, -1) < 0 && errno != EINTR) return;
    for (pollfd& end : ends) {
      if (end.fd < 0 || end.revents == 0) continue;
      const auto count = read(end.fd, bytes, sizeof bytes);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        end.fd = -1;
      } else if (&end == ends) {
        if (outcome.messages.size() < most_messages) outcome.messages.append(bytes, static_cast<std::size_t>(count));
      } else {
        waiting.append(bytes, static_cast<std::size_t>(count));
        take_problems(waiting, outcome.problems);
        take_progress(waiting, say);
      }
    }
  }
}

Outcome run(const std::string& program, const std::vector<std::string>& arguments, Files files,
            const std::function<void(int)>& started, const std::function<void(double, const std::string&)>& progress) {
  Outcome outcome{-1, {}, {}};
  Pipe messages, steps;
  std::vector<std::string> words{program}, environment = environment_of_job();
  words.insert(words.end(), arguments.begin(), arguments.end());
  const auto argument_pointers = pointers(words), environment_pointers = pointers(environment);
  const pid_t parent = getpid();
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t child = messages.write >= 0 && steps.write >= 0 ? fork() : -1;
  if (child == 0)
    become(program.c_str(), argument_pointers.data(), environment_pointers.data(),
           {files.input, files.output, messages.write, steps.write}, parent);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (child < 0) {
    outcome.messages = "no process can be started\n";
    return outcome;
  }
  setpgid(child, child);
  started(child);
  Pipe::close_end(messages.write);
  Pipe::close_end(steps.write);
  listen_to(messages.read, steps.read, outcome, progress);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  started(0);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

/// A file without a name.
struct MemoryFile {
  int descriptor = memfd_create("tumble", MFD_CLOEXEC);
  MemoryFile() = default;
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (descriptor >= 0) close(descriptor);
  }
};

bool write_all(int descriptor, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto count = write(descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return lseek(descriptor, 0, SEEK_SET) == 0;
}

void read_all(int descriptor, std::string& bytes) {
  lseek(descriptor, 0, SEEK_SET);
  char block[1 << 14];
  for (;;) {
    const auto count = read(descriptor, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    bytes.append(block, static_cast<std::size_t>(count));
  }
}

/// A new file that begins with a line. Throws Error::bad_file where the disk has no room for it: what a program writes
/// later would be lost there, and with it the reason why it has ended. What has the name gives way: were it a link or a
/// pipe, the messages would go elsewhere.
int file_of_messages(const std::string& path, const std::string& line) {
  unlink(path.c_str());
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  errno = file < 0 ? errno : ENOSPC;  // of a part that was written
  if (file >= 0 && write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size())) return file;
  const std::string reason = std::system_category().message(errno);
  if (file >= 0) {
    close(file);
    unlink(path.c_str());
  }
  throw Error{Error::Kind::bad_file, say("cannot write '{}': {}", path, system_reason(reason))};
}

}  // namespace

Outcome run_process(const std::string& program, const std::vector<std::string>& arguments,
                    const std::function<void(int)>& started,
                    const std::function<void(double, const std::string&)>& progress) {
  return run(program, arguments, {}, started, progress);
}

Outcome run_process(const std::string& program, const std::vector<std::string>& arguments, const std::string& input,
                    std::string& output, const std::function<void(int)>& started) {
  const MemoryFile given, answered;
  if (given.descriptor < 0 || answered.descriptor < 0 || !write_all(given.descriptor, input))
    return {-1, "there is not enough memory for the plan\n", {}};
  const auto outcome =
      run(program, arguments, {given.descriptor, answered.descriptor}, started, [](double, const std::string&) {});
  read_all(answered.descriptor, output);
  return outcome;
}

CodedProblems problems_of(const Outcome& outcome, const std::string& root) {
  CodedProblems found{"failed", {}};
  if (!outcome.problems.empty())
    found = coded_problems_from_json(outcome.problems);
  else if (!outcome.messages.empty())
    found.problems.emplace_back(Sentence(outcome.messages.substr(0, outcome.messages.find_last_not_of('\n') + 1)));
  if (found.problems.empty()) found.problems.emplace_back("the program ended without a message");
  for (Problem& problem : found.problems) problem = named_from(root, problem);
  return found;
}

void take_problems(std::string& waiting, std::string& problems) {
  constexpr std::string_view mark = "problems ";
  for (std::size_t begin = 0, end = 0; (end = waiting.find('\n', begin)) != std::string::npos; begin = end + 1)
    if (std::string_view(waiting).substr(begin).starts_with(mark)) {
      problems = waiting.substr(begin + mark.size(), end - begin - mark.size());
      waiting.erase(begin, end + 1 - begin);
      return;
    }
}

int start_detached(const std::string& program, const std::vector<std::string>& arguments, const std::string& messages) {
  Pipe alive;
  const int told = file_of_messages(messages, "tumble: " + (arguments.empty() ? program : arguments.front()) + "\n");
  if (alive.write < 0) return close(told), -1;
  std::vector<std::string> words{program}, environment = environment_in_english();
  environment.push_back("TUMBLE_PROBLEMS=" + std::to_string(progress_descriptor));
  words.insert(words.end(), arguments.begin(), arguments.end());
  const auto argument_pointers = pointers(words), environment_pointers = pointers(environment);
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t child = fork();
  if (child == 0) {
    setsid();
    // The child of a child that ends at once belongs to the first process of the system, which buries it. No terminal,
    // no signal and no end of this process reaches it.
    if (fork() == 0)
      run_in_place(program.c_str(), argument_pointers.data(), environment_pointers.data(),
                   {-1, told, told, alive.write});
    _exit(0);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  close(told);
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return child > 0 ? std::exchange(alive.read, -1) : -1;
}

void end_process(int process) {
  if (process > 0) kill(-process, SIGTERM);
}

}  // namespace tumble::jobs
