// clang++ -std=c++20 -fsanitize=fuzzer,address -I. tests/fuzz/libfuzzer.cpp tests/fuzz/readers.cpp <library and its
// own>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/tmp/tumble_fuzz_" + std::to_string(getpid());
  const auto wrong = tumble::fuzz::read_hostile({reinterpret_cast<const char*>(data), size}, path);
  if (wrong.empty()) return 0;
  std::fprintf(stderr, "%s\n", wrong.c_str());
  std::abort();
}
