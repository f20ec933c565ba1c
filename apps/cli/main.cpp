// The command line of Tumble: `tumble VERB ...`, one file a verb. Everything is done by tumble/tasks.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <new>

#include "tumble/core/settings.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/units/error.hpp"
#include "tumble/version.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

constexpr int usage = 2, data = 3, internal = 4;

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

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// What was on the command line that no option or argument takes, with the nearest that would.
int refuse_extras(const CLI::App& program, const Terminal& terminal) {
  const auto used = program.get_subcommands();
  const auto& app = used.empty() ? program : *used.front();
  const auto help = fmt::format("see `tumble {}--help`", used.empty() ? "" : app.get_name() + " ");
  std::vector<std::string> verbs;
  for (const auto* verb : program.get_subcommands({})) verbs.push_back(verb->get_name());
  std::vector<std::string> problems;
  for (const auto& extra : program.remaining(true)) {
    if (extra.starts_with("-")) {
      auto known = option_names(app);
      for (const auto& name : option_names(program)) known.push_back(name);
      problems.push_back(fmt::format("unknown option '{}'{} ({})", extra, did_you_mean(extra, known), help));
    } else if (used.empty()) {
      problems.push_back(
          fmt::format("unknown verb '{}'{} (verbs: {})", extra, did_you_mean(extra, verbs), fmt::join(verbs, ", ")));
      break;  // what follows was meant for it
    } else {
      problems.push_back(fmt::format("'{}' is one argument too many ({})", extra, help));
    }
  }
  complain(terminal, problems);
  return usage;
}

int run(int argc, char** argv, Terminal& terminal) {
  CLI::App program("Identify inertial instruments: from a plan and recordings to parameters with uncertainty.",
                   "tumble");
  program.set_version_flag("--version", fmt::format("tumble {}", version));
  program.add_flag("--quiet", terminal.quiet, "print only errors on standard error");
  program.fallthrough();
  const std::vector<Verb> verbs{add_list(program),     add_inspect(program), add_simulate(program),
                                add_identify(program), add_predict(program), add_compensate(program),
                                add_report(program),   add_convert(program)};
  program.footer("`tumble VERB --help` describes a verb, with examples.");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    return refuse_extras(program, terminal);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    const auto used = program.get_subcommands();
    complain(terminal, fmt::format("{} (see `tumble {}--help`)", error.what(),
                                   used.empty() ? "" : used.front()->get_name() + " "));
    return usage;
  }
  for (const auto& verb : verbs)
    if (verb.app->parsed()) return verb.run(terminal);
  fmt::print(stderr, "{}", program.help());
  return usage;
}

int run_and_catch(int argc, char** argv) {
  auto terminal = terminal_of_process();
  try {
    return run(argc, argv, terminal);
  } catch (const Error& error) {
    complain(terminal, error.problems);
    return status_of(error.kind);
  } catch (const std::bad_alloc&) {
    complain(terminal, "not enough memory for these data; a shorter recording or fewer channels would need less");
    return data;
  } catch (const std::exception& error) {
    complain(terminal, fmt::format("internal: {}; this is a defect of the program, please report it", error.what()));
    return internal;
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

/// Ctrl-C and the like: nothing half written stays behind, and the shell learns which signal it was.
extern "C" void interrupted(int number) {
  unlink_unfinished();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace
}  // namespace tumble::cli

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file too large for its limit is a failed write, with a message
  std::signal(SIGPIPE, SIG_DFL);  // `tumble list | head` ends quietly
  for (const int end : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(end, tumble::cli::interrupted) == SIG_IGN) std::signal(end, SIG_IGN);  // as under nohup
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE}) std::signal(fault, tumble::cli::last_words);
  return tumble::cli::run_and_catch(argc, argv);
}
