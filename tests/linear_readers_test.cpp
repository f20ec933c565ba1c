// What every reader of text promises: twice the text takes about twice the time, whatever is written in it. A loop that
// searches to the end of the text for each line takes hours for a file of a megabyte.

#include <gtest/gtest.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "tumble/core/tables/document.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/rehearsal/virtual_faults.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/plan_text.hpp"
#include "tumble/units/error.hpp"
#include "tumble/wire/controller.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// Text of about `size` bytes: a begin, and a piece that is repeated. %: a number that counts the pieces.
struct Shape {
  const char* name;
  const char* begin;
  const char* piece;

  std::string text(std::size_t size) const {
    std::string out = begin;
    for (std::size_t number = 0; out.size() < size; ++number)
      for (const char* c = piece; *c != '\0'; ++c) *c == '%' ? out += std::to_string(number) : out += *c;
    return out;
  }
};

const std::vector<Shape> shapes{
    {"empty lines", "", "\n"},
    {"empty lines of Windows", "", "\r\n"},
    {"blanks", "", " "},
    {"comments", "", "# %\n"},
    {"one long line", "", "x"},
    {"one line of columns", "", "a%,"},
    {"columns of one name", "", "a,"},
    {"quotes", "", "\""},
    {"words", "", "word\n"},
    {"semicolons", "", ";\n"},
    {"keys", "", "k% = 1\n"},
    {"tables", "", "[t%]\na = 1\n"},
    {"arrays of tables", "", "[[schedule]]\nlabel = \"%\"\n"},
    {"inline tables", "a = [", "{x = %},"},
    {"samples", "time[s],gyro[deg/h]\n", "%,1\n"},
    {"samples that are no numbers", "time[s],gyro[deg/h]\n", "%,no\n"},
    {"empty lines after samples", "time[s],gyro[deg/h]\n0,1\n1,2\n", "\n"},
    {"headers of LabVIEW", "LabVIEW Measurement\t\nSeparator\tTab\n", "***End_of_Header***\t\n"},
    {"datasets", "", "    -1\n    58\n"},
    {"JSON", "{\"tumble\": \"1\", \"parameters\": [", "{\"name\": \"%\"},"},
    {"brackets of JSON", "", "["},
};

/// [s] of processor time of this thread.
double taken_by(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  try {
    work();
  } catch (const Error&) {  // most of the shapes are no such file
  }
  return now() - begin;
}

/// Four times the text may take four times as long and half of that again, over what cannot be measured; a square
/// takes sixteen times.
void expect_linear(const std::string& reader, const std::function<void(const std::string& text)>& read) {
  constexpr std::size_t size = 100'000;
  constexpr double unmeasurable = 0.1;  // s
  for (const Shape& shape : shapes) {
    const std::string few = shape.text(size), many = shape.text(4 * size);
    double once = taken_by([&] { read(few); });
    double four = taken_by([&] { read(many); });
    if (four > 6.0 * once + unmeasurable) {  // a busy machine: the least of several
      for (int i = 0; i < 2; ++i) four = std::min(four, taken_by([&] { read(many); }));
    }
    EXPECT_LE(four, 6.0 * once + unmeasurable) << reader << ": " << shape.name;
  }
}

class LinearFormats : public ::testing::TestWithParam<const Format*> {};

TEST_P(LinearFormats, TakeTimeInProportionToTheText) {
  const auto folder = fs::temp_directory_path() / ("tumble_linear_" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string path = (folder / ("text" + GetParam()->extensions[0])).string();
  expect_linear(GetParam()->name, [&](const std::string& text) {
    std::ofstream(path) << text;
    GetParam()->read(path, {}, {});
  });
  fs::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(All, LinearFormats, ::testing::ValuesIn(format_catalogue()),
                         [](const auto& format) { return std::string(format.param->name); });

TEST(LinearReaders, DocumentsTakeTimeInProportionToTheText) {
  expect_linear("document", [](const std::string& text) { tables::document_of(text, "text.toml"); });
}

TEST(LinearReaders, PlansTakeTimeInProportionToTheText) {
  expect_linear("plan",
                [](const std::string& text) { plan_of_text("method = \"static_bias\"\n" + text, "text.toml"); });
}

TEST(LinearReaders, FaultsTakeTimeInProportionToTheText) {
  expect_linear("faults", [](const std::string& text) { read_faults(text, "text.toml"); });
}

TEST(LinearReaders, ControllersTakeTimeInProportionToTheText) {
  expect_linear("controller", [](const std::string& text) { read_controller(text, "text.toml"); });
}

TEST(LinearReaders, FramesTakeTimeInProportionToTheText) {
  expect_linear("frames", [](const std::string& text) { read_frames(text, "text.toml"); });
}

TEST(LinearReaders, ResultsTakeTimeInProportionToTheText) {
  expect_linear("result", [](const std::string& text) { estimate_from_json(text, "text.json"); });
}

}  // namespace
}  // namespace tumble
