// The command line of Tumble: `tumble VERB ...`, one file a verb. Everything is done by tumble/tasks.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <new>

#include "completion.hpp"
#include "live_output.hpp"
#include "serve.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

constexpr int data = 3, internal = 4;

int status_of(Error::Kind kind) {
  switch (kind) {
    case Error::Kind::bad_input:
    case Error::Kind::unsupported:
      return usage;
    case Error::Kind::bad_data:
    case Error::Kind::bad_file:
      return data;
    case Error::Kind::internal:
      break;
  }
  return internal;
}

int refused(const Terminal& terminal, Error::Kind kind, const Problems& problems) {
  complain(terminal, problems);
  hand_on(kind, problems);
  return status_of(kind);
}

int run_and_catch(int argc, char** argv) {
  auto terminal = terminal_of_process();
  try {
    const char* const folder = std::getenv(confinement_variable);
    const Confinement confinement(folder ? folder : "");
    std::vector<Verb> verbs{
        list_verb(),     init_verb(),        inspect_verb(), simulate_verb(), identify_verb(), predict_verb(),
        validate_verb(), compensate_verb(),  report_verb(),  export_verb(),   compare_verb(),  certificate_verb(),
        convert_verb(),  rehearse_verb(),    run_verb(),     resume_verb(),   stop_verb(),     answer_verb(),
        station_verb(),  virtual_rig_verb(), record_verb(),  seal_verb(),     archive_verb(),  population_verb(),
        fleet_verb(),    serve_verb()};
    verbs.push_back(completion_verb(verbs));
    return run_command_line(argc, argv, verbs, terminal);
  } catch (const Error& error) {
    auto problems = error.problems;
    for (auto& problem : problems) problem = with_values(problem, as_written);
    return refused(terminal, error.kind, problems);
  } catch (const std::bad_alloc&) {
    return refused(terminal, Error::Kind::bad_data,
                   {"not enough memory for these data; a shorter recording or fewer channels would need less"});
  } catch (const std::filesystem::filesystem_error& error) {  // a name that is too long, a folder that is closed
    const Sentence reason = system_reason(error.code());
    if (error.path1().empty()) return refused(terminal, Error::Kind::bad_file, {reason});
    return refused(terminal, Error::Kind::bad_file, {say("'{}': {}", as_written(error.path1().string()), reason)});
  } catch (const std::exception& error) {
    return refused(terminal, Error::Kind::internal,
                   {say("internal: {}; this is a defect of the program, please report it", error.what())});
  }
}

/// The HDF5 library can fall over bytes that were changed in a file without checksums. The handler may only write.
extern "C" void last_words(int) {
  static constexpr char text[] =
      "error: internal: memory fault. A damaged HDF5 file can cause this in the HDF5 library: check the recording with "
      "h5dump. If it is sound, this is a defect of the program, please report it. Nothing was written.\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, sizeof text - 1);
  unlink_unfinished();
  _exit(internal);
}

/// Last words on a stack of their own: the fault may be that the other one has ended.
void on_fault() {
  static std::array<char, 1 << 16> room;
  const stack_t stack{.ss_sp = room.data(), .ss_flags = 0, .ss_size = room.size()};
  sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_handler = last_words;
  action.sa_flags = SA_ONSTACK;
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE}) sigaction(fault, &action, nullptr);
}

/// Ctrl-C and the like: nothing half written stays behind, and the shell learns which signal it was.
extern "C" void interrupted(int number) {
  unlink_unfinished();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

/// A file that is opened later is never taken for a standard one that was closed: messages would go to a device, and
/// its answers would be orders. Each is opened in the way that it is not used in, so that it is refused as before.
void keep_standard_files() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(file, F_GETFD) < 0) open("/dev/null", file == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace
}  // namespace tumble::cli

int main(int argc, char** argv) {
  tumble::cli::keep_standard_files();
  std::signal(SIGXFSZ, SIG_IGN);                   // a file too large for its limit is a failed write, with a message
  std::signal(SIGPIPE, tumble::cli::interrupted);  // `tumble list | head` ends quietly
  for (const int end : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU})
    if (std::signal(end, tumble::cli::interrupted) == SIG_IGN) std::signal(end, SIG_IGN);  // as under nohup
  tumble::cli::on_fault();
  const int status = tumble::cli::run_and_catch(argc, argv);
  tumble::cli::end_live_output();
  return status;
}
