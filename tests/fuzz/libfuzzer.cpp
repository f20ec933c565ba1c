// The entry of libFuzzer (script/fuzz). The environment says what to do:
//   TUMBLE_FUZZ_TARGET   the target that gets the bytes
//   TUMBLE_FUZZ_SEEDS    a folder: the seeds of the target are written there, from the repository TUMBLE_FUZZ_ROOT
//   TUMBLE_FUZZ_LIST     the names of all targets are printed
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "targets.hpp"

namespace {

std::string setting(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

std::string scratch_file() { return "/tmp/tumble_fuzz_" + std::to_string(getpid()); }

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  if (!setting("TUMBLE_FUZZ_LIST").empty()) {
    for (const auto& name : tumble::fuzz::target_names()) std::printf("%s\n", name.c_str());
    std::exit(0);
  }
  if (const auto folder = setting("TUMBLE_FUZZ_SEEDS"); !folder.empty()) {
    int number = 0;
    for (const auto& seed :
         tumble::fuzz::seeds_of(setting("TUMBLE_FUZZ_TARGET"), setting("TUMBLE_FUZZ_ROOT"), scratch_file()))
      std::ofstream(folder + "/seed-" + std::to_string(number++), std::ios::binary) << seed;
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = scratch_file(), target = setting("TUMBLE_FUZZ_TARGET");
  const auto wrong = tumble::fuzz::run_target(target, {reinterpret_cast<const char*>(data), size}, path);
  if (wrong.empty()) return 0;
  std::fprintf(stderr, "%s\n", wrong.c_str());
  std::abort();
}
