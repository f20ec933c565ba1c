// What a refusal advises works: each file lacks something, and the settings that the messages name are tried as they
// are written, one refusal after the other.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>

#include "tumble/math/random.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// A table whose first column is `stamp` of the number of the row; without an own time, only its values.
struct AdvisedTable {
  std::string name, header;
  std::function<std::string(int)> stamp;
  Sets given = {};

  void write(const fs::path& path) const {
    const RandomStream random(5);
    std::ofstream out(path);
    if (!header.empty()) out << header << '\n';
    for (int i = 0; i < 400; ++i) out << stamp(i) << 5.0 + random.normal(static_cast<std::size_t>(i)) << '\n';
  }
};

std::string hundredths(int i, const char* separator) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f%s", 0.01 * i, separator);
  return text;
}

/// The settings of the line to copy, else all that the messages name; of two for one key the first.
Sets advised_by(const Error& error) {
  static const std::regex setting(R"re(--set ([\w.]+)=("[^"]*"|[^\s,;)]+))re");
  std::string text;
  for (const std::string& problem : texts_of(error.problems))
    if (const auto copy = problem.find("to copy"); copy != problem.npos) text += problem.substr(copy);
  if (text.empty())
    for (const std::string& problem : texts_of(error.problems)) text += problem + "\n";
  Sets sets;
  for (std::sregex_iterator at(text.begin(), text.end(), setting), end; at != end; ++at) {
    std::string value = (*at)[2];
    if (value.starts_with('"')) value = value.substr(1, value.size() - 2);
    const auto same = [&](const auto& set) { return set.first == (*at)[1].str(); };
    if (value != "COLUMN" && std::ranges::none_of(sets, same)) sets.emplace_back((*at)[1], value);
  }
  return sets;
}

/// Empty where the advice leads to an answer, else the last message.
std::string led_to(const std::string& path, Sets sets) {
  std::string last;
  for (int refusals = 0; refusals < 4; ++refusals) try {
      identify(gather(plan_for_method("static_bias", sets), {path}, {}), {});
      return "";
    } catch (const Error& error) {
      last = error.what();
      const Sets advised = advised_by(error);
      if (advised.empty()) return "no advice: " + last;
      for (const auto& set : advised) sets.push_back(set);
    }
  return last;
}

TEST(Advice, OfRefusalsWorksWhenItIsCopied) {
  const auto comma = [](int i) { return hundredths(i, ","); };
  const auto semicolon = [](int i) { return hundredths(i, ";"); };
  const auto tab = [](int i) { return hundredths(i, "\t"); };
  const std::vector<AdvisedTable> tables{
      {"time.csv", "time,gyro[deg/h]", comma},
      {"t.csv", "t,gyro[deg/h]", comma},
      {"nothing.csv", "time,gyro", comma},
      {"semicolons.csv", "time;gyro", semicolon},
      {"tabs.txt", "time\tgyro", tab},
      {"numbers.csv", "", comma},
      {"no_time.csv", "gyro[deg/h]", [](int) { return std::string(); }},
      {"dates.csv", "date,gyro[deg/h]", [](int i) { return "01/02/2026 09:00:" + hundredths(100 + i, ","); }},
      {"clock.csv", "clock1,gyro[deg/h]", comma, {{"time", "clock1"}}},
      {"clock_with_unit.csv", "clock1,gyro[deg/h]", comma, {{"time", "clock1"}, {"unit.clock1", "s"}}},
  };
  const auto folder = fs::temp_directory_path() / ("tumble_advice_" + std::to_string(getpid()));
  fs::create_directories(folder);
  for (const auto& table : tables) {
    table.write(folder / table.name);
    EXPECT_EQ(led_to((folder / table.name).string(), table.given), "") << table.name;
  }
  fs::remove_all(folder);
}

TEST(Advice, AUnitForAColumnThatIsNotThereIsRefused) {
  const auto path = fs::temp_directory_path() / ("tumble_advice_" + std::to_string(getpid()) + ".csv");
  AdvisedTable{"", "time[s],gyro[deg/h]", [](int i) { return hundredths(i, ","); }}.write(path);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"tim", "tim"}}, [&] {
    gather(plan_for_method("static_bias", {{"unit.tim", "s"}}), {path.string()}, {});
  }));
  fs::remove(path);
}

/// A file of each kind in the place of a plan.
TEST(KindOfFile, IsSaidWhereAPlanIsNeeded) {
  const auto folder = fs::temp_directory_path() / ("tumble_kind_" + std::to_string(getpid()));
  fs::create_directories(folder);
  AdvisedTable{"", "time[s],gyro[deg/h]", [](int i) { return hundredths(i, ","); }}.write(folder / "gyro.csv");
  std::ofstream(folder / "noise.json") << "{\n \"tumble\": \"1\",\n \"parameters\": []\n}\n";
  std::ofstream(folder / "plan.txt") << "# a plan\nmethod = \"static_bias\"\n";
  const auto said = [&](const char* name) {
    try {
      load_plan((folder / name).string(), {});
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string in = folder.string() + "/";
  EXPECT_EQ(said("gyro.csv"), in +
                                  "gyro.csv is a recording; the method or the plan comes first: tumble identify "
                                  "allan_noise " +
                                  in + "gyro.csv");
  EXPECT_EQ(
      said("noise.json"),
      in + "noise.json is a result, and a plan is needed; to read the result: tumble report " + in + "noise.json");
  EXPECT_EQ(said("plan.txt"), "");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tumble
