// Station files, requests to the workbench and databases of archives, mutated with a fixed seed: TUMBLE_FUZZ_INPUTS of each
// (300). script/fuzz goes on with other ways.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "fuzz/targets.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

std::string changed_somewhere(std::string bytes, std::mt19937_64& random, std::string_view words) {
  for (auto changes = 1 + random() % 6; changes-- > 0 && !bytes.empty();) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 6) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = words[random() % words.size()];
        break;
      case 2:
        bytes.insert(at, 1 + random() % 3, words[random() % words.size()]);
        break;
      case 3:
        bytes.erase(at, 1 + random() % 30);
        break;
      case 4:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 60));
        break;
      default:
        if (random() % 8 == 0) bytes.resize(at);
    }
  }
  return bytes;
}

class FuzzServices : public ::testing::TestWithParam<const char*> {};

TEST_P(FuzzServices, AnyBytesAreTakenOrRefused) {
  const char* const stated = std::getenv("TUMBLE_FUZZ_INPUTS");
  const std::size_t inputs = stated ? std::strtoul(stated, nullptr, 10) : 300;
  const ScratchFolder folder;
  const auto seeds = fuzz::seeds_of(GetParam(), TUMBLE_SOURCE_DIR, folder.file("seed"));
  ASSERT_FALSE(seeds.empty());
  std::mt19937_64 random(40);
  for (std::size_t i = 0; i < inputs; ++i) {
    const std::string bytes =
        changed_somewhere(seeds[random() % seeds.size()], random, "[]{}=\"'.,:-+eE0129nif\n#&%/\\ ");
    ASSERT_EQ(fuzz::run_target(GetParam(), bytes, folder.file("f")), "") << "input " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Each, FuzzServices, ::testing::Values("station", "route", "archive"),
                         [](const auto& target) { return std::string(target.param); });

}  // namespace
}  // namespace tumble
