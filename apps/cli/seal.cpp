#include <fmt/format.h>

#include <memory>

#include "tumble/recorder/recorder_read.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct SealArguments {
  std::string run, output, raw;
};

int run(const SealArguments& arguments, const Terminal& terminal) {
  if (!arguments.output.empty()) check_output("-o", arguments.output, {}, {".h5", ".hdf5"});
  if (!arguments.raw.empty()) {
    check_output("--raw", arguments.raw, {}, {".raw", ".bin", ".frames"});
    const auto bytes = write_raw(arguments.run, arguments.raw);
    note(terminal, say("wrote {}: {} bytes as they came", Name{arguments.raw}, bytes));
    return 0;
  }
  std::vector<SealedRecording> sealed;
  {
    ProgressLine line(terminal);
    Disk disk;
    sealed = tumble::seal(arguments.run, disk, arguments.output, line.progress());
  }
  for (const auto& [slot, path, sha256, findings] : sealed) {
    note(terminal, say("wrote {}", Name{path}));
    for (const Finding& finding : findings) {
      const Sentence said = said_of(finding);
      note(terminal, finding.where.empty() ? said : say("{}: {}", Name{finding.where}, said));
    }
  }
  return 0;
}

}  // namespace

Verb seal_verb() {
  auto arguments = std::make_shared<SealArguments>();
  return {"seal",
          "Make the recording of a run from its live store, also after a crash",
          {{"RUN", &arguments->run, "folder of the run", true},
           {"-o,--output", &arguments->output,
            "recording to write (.h5); default: as the run says, else RUN/recording.h5;\nof several units "
            "each has a file, NAME-SLOT.h5"},
           {"--raw", &arguments->raw, "write the received bytes instead, as they came, into a file", false, "FILE"}},
          "Example:\n"
          "  tumble seal fog.run\n"
          "  tumble seal fog.run --raw fog.raw\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
